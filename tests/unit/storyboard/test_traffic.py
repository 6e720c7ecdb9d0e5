"""Traffic that comes and goes: how many there are, where, and that none of it runs into anybody."""

from __future__ import annotations

import math

import pytest

from openscenario.storyboard.crowd import HEADWAY, STANDSTILL, following
from openscenario.storyboard.engine import Storyboard

from .conftest import Make, at_time, by_entity, condition, event, group, lane_position, log, run, speed, story, teleport

EGO = [teleport(lane_position(500.0)), speed(20.0)]
CARS = (
    '<TrafficDefinition name="d"><VehicleCategoryDistribution>'
    '<VehicleCategoryDistributionEntry category="{}" weight="1"/></VehicleCategoryDistribution><ControllerDistribution>'
    '<ControllerDistributionEntry weight="1"><Controller name="c"><Properties/></Controller>'
    "</ControllerDistributionEntry></ControllerDistribution></TrafficDefinition>"
)


def traffic(action: str, name: str = "flow", kinds: str = CARS.format("car")) -> str:
    return (
        f'<GlobalAction><TrafficAction trafficName="{name}">{action.format(kinds=kinds)}</TrafficAction></GlobalAction>'
    )


def source(rate: float, s: float, radius: float = 1.0) -> str:
    return (
        f'<TrafficSourceAction rate="{rate}" radius="{radius}" velocity="10">'
        f"<Position>{lane_position(s)}</Position>{{kinds}}</TrafficSourceAction>"
    )


def sink(s: float, radius: float = 10.0) -> str:
    return (
        f'<TrafficSinkAction rate="100" radius="{radius}"><Position>{lane_position(s)}</Position>{{kinds}}'
        "</TrafficSinkAction>"
    )


def swarm(number: int, velocity: float = 20.0, inner: float = 30.0) -> str:
    return (
        f'<TrafficSwarmAction innerRadius="{inner}" semiMajorAxis="300" semiMinorAxis="100" offset="0" '
        f'numberOfVehicles="{number}" velocity="{velocity}">{{kinds}}<CentralObject entityRef="A"/>'
        "</TrafficSwarmAction>"
    )


def now(*actions: str) -> str:
    return story(event("e", *actions, start=group(condition(at_time(0.0)))))


def others(board: Storyboard) -> list[str]:
    return [name for name in board.entities if name != "A"]


def test_a_source_lets_so_many_a_second_in_at_its_place(make: Make) -> None:
    board = make(A=EGO, stories=now(traffic(source(0.25, 100.0))))
    run(board, 20.05)
    assert others(board) == [f"flow-{i}" for i in range(1, 7)]  # at 0, 4, ..., 20 s
    first = board.entities["flow-1"]
    assert first.y == pytest.approx(-1.75)
    assert first.x == pytest.approx(100.0 + 10.0 * 20.0, abs=6.0)


def test_a_sink_takes_what_came_and_nothing_that_the_file_names(make: Make) -> None:
    board = make(
        A=[teleport(lane_position(150.0)), speed(0.0)],
        stories=now(traffic(source(0.2, 50.0)), traffic(sink(100.0, 60.0))),
    )
    run(board, 12.0)
    assert board.entities["A"].active
    assert all(board.entities[name].x < 40.0 for name in others(board))


def test_a_swarm_keeps_its_number_within_the_ellipse(make: Make) -> None:
    board = make(A=EGO, stories=now(traffic(swarm(12))))
    for _ in range(10):
        run(board, 1.0)
        central = board.entities["A"]
        assert len(others(board)) == 12
        for name in others(board):
            car = board.entities[name]
            assert ((car.x - central.x) / 300.0) ** 2 + ((car.y - central.y) / 100.0) ** 2 <= 1.05


def test_nobody_of_a_swarm_appears_in_the_inner_circle(make: Make) -> None:
    board = make(A=EGO, stories=now(traffic(swarm(12, inner=100.0))))
    run(board, 0.01)
    assert len(others(board)) == 12
    central = board.entities["A"]
    assert min(math.hypot(c.x - central.x, c.y - central.y) for c in board.entities.values() if c is not central) > 99.0


def test_traffic_does_not_run_into_a_standing_car(make: Make) -> None:
    board = make(A=[teleport(lane_position(300.0)), speed(0.0)], stories=now(traffic(source(0.2, 50.0))))
    run(board, 60.0)
    first = board.entities["flow-1"]
    gap = (300.0 + 1.5 - 2.5) - (first.x + first.center_x + 0.5 * first.length)
    assert first.speed == pytest.approx(0.0, abs=0.2)
    assert gap == pytest.approx(STANDSTILL, abs=0.5)


def test_the_law_of_following_rests_at_its_own_distance() -> None:
    """At v = v_other and v << v_wished the equilibrium gap is s0 + v T (Treiber et al. 2000, eq. 4)."""
    v = 5.0
    gap = (STANDSTILL + v * HEADWAY) / math.sqrt(1.0 - (v / 30.0) ** 4)
    assert following(v, 30.0, gap, v) == pytest.approx(0.0, abs=1e-9)
    assert following(30.0, 30.0, math.inf, 0.0) == pytest.approx(0.0)


def test_the_kinds_are_those_of_the_definition(make: Make) -> None:
    board = make(A=EGO, stories=now(traffic(swarm(5), kinds=CARS.format("bus"))))
    run(board, 0.01)
    assert {board.entities[name].category for name in others(board)} == {"bus"}


def test_a_stop_lets_no_more_in(make: Make) -> None:
    stop = story(event("s", traffic("<TrafficStopAction/>"), start=group(condition(at_time(9.0))))).replace(
        'name="story"', 'name="other"'
    )
    board = make(A=EGO, stories=now(traffic(source(0.25, 100.0))) + stop)
    run(board, 20.0)
    assert len(others(board)) == 3  # at 0, 4, 8 s


def test_who_comes_to_the_end_of_the_road_is_gone(make: Make) -> None:
    board = make(A=EGO, stories=now(traffic(source(0.01, 950.0))))
    run(board, 8.0)
    assert others(board) == []


def test_the_seed_decides(make: Make) -> None:
    def places() -> list[tuple[float, float]]:
        board = make(A=EGO, stories=now(traffic(swarm(12))))
        run(board, 3.0)
        return [(each.x, each.y) for each in board.entities.values()]

    assert places() == places()


@pytest.mark.parametrize("came", [False, True])
def test_conditions_on_any_entity_see_traffic_too(make: Make, came: bool) -> None:
    clear = (
        '<RelativeClearanceCondition distanceForward="0" distanceBackward="60" freeSpace="false" oppositeLanes="false">'
    )
    clear += '<RelativeLaneRange from="0" to="0"/></RelativeClearanceCondition>'
    start = group(condition(by_entity(clear, "A"), "c"), condition(at_time(1.0), "t"))
    wait = story(event("clear", speed(0.0), start=start)).replace('name="story"', 'name="other"')
    here = [teleport(lane_position(300.0)), speed(0.0)]
    board = make(A=here, stories=(now(traffic(source(0.01, 260.0))) if came else "") + wait)
    run(board, 2.0)
    assert bool([each for each in log(board, "event") if each[1:] == ("clear", "startTransition")]) is not came


@pytest.mark.parametrize("visible", [True, False])
def test_traffic_brakes_for_those_only_whom_it_sees(make: Make, visible: bool) -> None:
    """A car of 10 m/s comes from s = 400 m to one that stands at 500 m: 100 m take it 10 s if nothing is there."""
    hide = (
        f'<PrivateAction><VisibilityAction graphics="true" sensors="true" traffic="{str(visible).lower()}"/>'
        "</PrivateAction>"
    )
    flow = event("e", traffic(source(0.01, 400.0)))
    board = make(A=[teleport(lane_position(500.0)), speed(0.0), hide], stories=story(flow))
    run(board, 12.0)
    came = board.entities["flow-1"]
    assert (came.x > 505.0) is not visible
    assert (came.speed < 5.0) is visible
