"""An entity that something else moves: Init places it, later actions only ask, conditions see where it really is."""

from __future__ import annotations

import pytest

from .conftest import (
    Make,
    at_time,
    by_entity,
    condition,
    event,
    group,
    lane_change,
    lane_position,
    log,
    run,
    speed,
    story,
    teleport,
)

HERE = [teleport(lane_position(100.0)), speed(10.0)]
LATER = group(condition(at_time(0.5)))
ROUTE = (
    '<PrivateAction><RoutingAction><AssignRouteAction><Route name="r" closed="false">'
    f'<Waypoint routeStrategy="shortest"><Position>{lane_position(100.0)}</Position></Waypoint>'
    f'<Waypoint routeStrategy="shortest"><Position>{lane_position(400.0)}</Position></Waypoint>'
    "</Route></AssignRouteAction></RoutingAction></PrivateAction>"
)


def test_init_places_it_and_gives_it_speed_and_route(make: Make) -> None:
    board = make(A=[*HERE, ROUTE], external=("A",))
    board.start()
    a = board.entities["A"]
    assert (a.x, a.speed, a.set_speed) == (pytest.approx(100.0), 10.0, 10.0)
    assert [place.x for place in a.route] == [pytest.approx(100.0), pytest.approx(400.0)]


def test_it_stays_where_it_is_put(make: Make) -> None:
    board = make(A=HERE, external=("A",))
    run(board, 1.0)
    assert board.entities["A"].x == pytest.approx(100.0)


def test_a_speed_action_becomes_a_request(make: Make) -> None:
    board = make(A=HERE, external=("A",), stories=story(event("e", speed(20.0, "linear", "rate", 5.0), start=LATER)))
    run(board, 1.0)
    (request,) = board.requests
    assert (request.time, request.entity, request.kind, request.values["target"]) == (0.5, "A", "speed", 20.0)
    assert board.entities["A"].speed == 10.0


def test_the_asked_action_ends_when_the_change_would(make: Make) -> None:
    board = make(A=HERE, external=("A",), stories=story(event("e", speed(20.0, "linear", "rate", 5.0), start=LATER)))
    run(board, 3.0)
    assert (2.5, "e", "endTransition") in log(board, "event")


def test_route_and_lane_change_become_requests(make: Make) -> None:
    change = lane_change('<AbsoluteTargetLane value="-2"/>')
    board = make(A=HERE, external=("A",), stories=story(event("e", ROUTE, change, start=LATER)))
    run(board, 1.0)
    assert [each.kind for each in board.requests] == ["route", "lane_change"]
    assert board.requests[1].values["lane"] == -2


def test_conditions_see_the_placed_pose(make: Make) -> None:
    reach = (
        f'<ReachPositionCondition tolerance="1"><Position>{lane_position(300.0)}</Position></ReachPositionCondition>'
    )
    board = make(
        A=HERE,
        B=[teleport(lane_position(500.0))],
        external=("A",),
        stories=story(event("e", speed(5.0), start=group(condition(by_entity(reach, "A")))), actor="B"),
    )
    board.start()
    board.place("A", 250.0, -1.75, 0.0, 0.0, 12.0)
    board.step(0.05)
    assert board.entities["B"].speed == 0.0
    board.place("A", 299.5, -1.75, 0.0, 0.0, 12.0)
    board.step(0.05)
    assert board.entities["B"].speed == 5.0


def test_its_travelled_distance_counts(make: Make) -> None:
    board = make(A=HERE, external=("A",))
    board.start()
    for i in range(20):
        board.place("A", 100.0 + 0.5 * i, -1.75, 0.0, 0.0, 10.0)
        board.step(0.05)
    assert board.entities["A"].travelled == pytest.approx(10.0)


@pytest.mark.parametrize("external", [(), ("A",)])
def test_it_comes_to_the_end_of_its_road_as_any_other(make: Make, external: tuple[str, ...]) -> None:
    """The road ends at 1000 m; who is moved from outside is at its end from 10 cm before it on."""
    ends = by_entity('<EndOfRoadCondition duration="1"/>', "A")
    later = event("e", speed(0.0), start=group(condition(ends)))
    board = make(A=[teleport(lane_position(995.0)), speed(10.0)], external=external, stories=story(later))
    board.start()
    y = board.entities["A"].y
    for k in range(1, 301):
        if external:
            board.place("A", min(995.0 + 0.1 * k, 1003.0), y, 0.0, 0.0, 10.0)
        board.step(0.01)
    told = [when for when, _, state in log(board, "event") if state == "startTransition"]
    assert told == [pytest.approx(1.5, abs=0.05)]
