"""Motion beyond the Performance of an entity, and jumps without a teleport, are found with entity, time and event.

The cars of these scenarios have maxSpeed 70 m/s, maxAcceleration 10 m/s^2 unless a test says otherwise, maxDeceleration
10 m/s^2.
"""

from __future__ import annotations

from typing import Any

import pytest

from openscenario.storyboard.engine import Storyboard
from openscenario.storyboard.plausibility import Plausibility, said_of

from .conftest import Make, at_time, condition, event, group, lane_position, speed, story, teleport

DT = 0.05
START = [teleport(lane_position(100.0)), speed(10.0)]


def watched(board: Storyboard, seconds: float = 4.0) -> tuple[dict[str, Any], ...]:
    board.start()
    watch = Plausibility(board)
    for _ in range(round(seconds / DT)):
        board.step(DT)
        watch.look(DT)
    return watch.findings()


def follow(*vertices: tuple[float, float, float]) -> str:
    """An action that follows a polyline of (time, x, y) by its time stamps."""
    points = "".join(
        f'<Vertex time="{t}"><Position><WorldPosition x="{x}" y="{y}" z="0" h="0"/></Position></Vertex>'
        for t, x, y in vertices
    )
    return (
        '<PrivateAction><RoutingAction><FollowTrajectoryAction><TrajectoryRef><Trajectory name="t" closed="false">'
        f"<Shape><Polyline>{points}</Polyline></Shape></Trajectory></TrajectoryRef><TimeReference>"
        '<Timing domainAbsoluteRelative="relative" offset="0" scale="1"/></TimeReference>'
        '<TrajectoryFollowingMode followingMode="position"/></FollowTrajectoryAction></RoutingAction></PrivateAction>'
    )


def later(action: str, time: float = 1.0) -> str:
    return story(event("late", action, start=group(condition(at_time(time)))))


def test_a_car_that_keeps_its_speed_and_lane_is_not_found(make: Make) -> None:
    assert watched(make(A=START)) == ()


@pytest.mark.parametrize("target", [25.0, 2.0])
def test_a_step_in_speed_is_found_with_the_event_that_asks_for_it(make: Make, target: float) -> None:
    findings = {each["field"]: each for each in watched(make(A=START, stories=later(follow_at(target))))}
    found = findings["A.acceleration" if target > 10.0 else "A.deceleration"]
    assert (found["code"], found["entity"]) == ("dvp.implausible_motion", "A")
    assert found["t"] == pytest.approx(1.05, abs=0.051)
    assert found["worst"] == pytest.approx(abs(target - 10.0) / DT, rel=0.02)
    assert found["allowed"] == "up to 10 m/s^2"
    assert found["event"] == "late"


def follow_at(pace: float) -> str:
    """A straight trajectory from where the car is at 1 s, at a constant pace [m/s]."""
    return follow((0.0, 110.0, -1.75), (10.0, 110.0 + 10.0 * pace, -1.75))


@pytest.mark.parametrize("pace", [74.0, 80.0, 100.0])
def test_a_speed_above_the_maximum_is_found(make: Make, pace: float) -> None:
    """The first one beyond 70 m/s, 5 % and 0.1 m/s is 73.7 m/s."""
    findings = {each["field"]: each for each in watched(make(A=START, stories=later(follow_at(pace))))}
    assert findings["A.speed"]["found"] == pytest.approx(pace, rel=1e-3)
    assert findings["A.speed"]["allowed"] == "up to 70 m/s"
    assert findings["A.speed"]["count"] > 10


def test_an_acceleration_that_the_car_can_do_is_not_found(make: Make) -> None:
    ramp = speed(30.0, "linear", "rate", 9.9)
    assert watched(make(A=START, stories=later(ramp))) == ()


def test_a_trajectory_that_begins_elsewhere_is_a_jump(make: Make) -> None:
    aside = follow((0.0, 110.0, -5.25), (10.0, 210.0, -5.25))
    found = next(each for each in watched(make(A=START, stories=later(aside))) if each["field"] == "A.position")
    assert found["found"] == pytest.approx((3.5**2 + 0.5**2) ** 0.5, abs=0.3)  # a lane's width sideways in one step
    assert found["count"] == 1
    assert "position of A" in said_of(found)


@pytest.mark.parametrize(
    ("push", "turn", "fields"),
    [
        (0.4, 0.0, {}),  # a way of 0.9 m, of which 10 m/s explain 0.5 m and 0.5 m are tolerated
        (0.6, 0.0, {"A.position": 1.1}),
        (5.0, 0.0, {"A.position": 5.5}),
        (0.0, 0.4, {}),  # a circle of 2 m explains 0.25 rad on 0.5 m, and 0.2 rad are tolerated
        (0.0, 0.5, {"A.heading": 0.5}),
        (0.0, -3.0, {"A.heading": 3.0}),
        (3.0, 2.0, {"A.position": 3.5, "A.heading": 2.0}),
    ],
)
def test_a_push_along_the_road_and_a_turn_on_the_spot_are_jumps(
    make: Make, push: float, turn: float, fields: dict[str, float]
) -> None:
    board = make(A=START)
    board.start()
    watch = Plausibility(board)
    for step in range(3):
        board.step(DT)
        board.entities["A"].x += push if step == 2 else 0.0
        board.entities["A"].h += turn if step == 2 else 0.0
        watch.look(DT)
    assert {each["field"]: each["found"] for each in watch.findings()} == pytest.approx(fields)


def test_a_teleport_is_none(make: Make) -> None:
    assert watched(make(A=START, stories=later(teleport(lane_position(400.0, lane=-2))))) == ()


def test_the_ego_is_not_the_storyboards_to_move(make: Make) -> None:
    board = make(A=START, external=("A",))
    board.start()
    watch = Plausibility(board)
    board.place("A", 500.0, 0.0, 0.0, 2.0, 99.0)
    board.step(DT)
    watch.look(DT)
    assert watch.findings() == ()


def keep_distance(limits: str, distance: float = 100.0) -> str:
    return (
        f'<PrivateAction><LongitudinalAction><LongitudinalDistanceAction entityRef="B" continuous="true" '
        f'freespace="false" distance="{distance}"><DynamicConstraints {limits}/></LongitudinalDistanceAction>'
        "</LongitudinalAction></PrivateAction>"
    )


def test_who_is_too_fast_for_a_constraint_brakes_within_it_and_is_found(make: Make) -> None:
    # 20 m/s with maxSpeed 14 and maxDeceleration 2: too fast for (20 - 14) / 2 = 3 s, 60 steps
    limits = 'maxSpeed="14" maxAcceleration="2" maxDeceleration="2"'
    here, there = [teleport(lane_position(0.0)), speed(20.0)], [teleport(lane_position(800.0)), speed(20.0)]
    board = make(A=here, B=there, stories=later(keep_distance(limits)))
    (found,) = watched(board, 6.0)
    assert (found["field"], found["limit"], found["event"]) == ("A.speed", "DynamicConstraints", "late")
    assert found["t"] == pytest.approx(1.05, abs=0.051)
    assert found["found"] == pytest.approx(20.0 - 2.0 * DT, abs=1e-9)
    assert found["count"] == pytest.approx(
        (20.0 - 1.05 * 14.0 - 0.1) / 2.0 / DT, abs=1.1
    )  # 5 % and 0.1 m/s are tolerated
    assert found["allowed"] == "up to 14 m/s by DynamicConstraints of late"
    assert board.entities["A"].speed == pytest.approx(14.0)


@pytest.mark.parametrize(
    ("field", "change", "worst"),
    [("A.acceleration", 0.4, 0.4 / DT), ("A.deceleration", -0.4, 0.4 / DT), ("A.acceleration_rate", 0.2, None)],
)
def test_an_error_of_the_interpreter_shows_against_the_constraints(
    make: Make, field: str, change: float, worst: float | None
) -> None:
    """As a wrong action would, the test itself changes the speed by 0.4 m/s in a step: 8 m/s^2, which the car can do.

    By 0.2 m/s: 4 m/s^2 within a step of 50 ms, a jerk of 80 m/s^3.
    """
    limits = 'maxAcceleration="4.5" maxDeceleration="4.5" maxAccelerationRate="10" maxDecelerationRate="10"'
    here, there = [teleport(lane_position(0.0)), speed(10.0)], [teleport(lane_position(100.0)), speed(10.0)]
    board = make(A=here, B=there, stories=later(keep_distance(limits, distance=100.0)))
    board.start()
    watch = Plausibility(board)
    for step in range(60):
        board.step(DT)
        board.entities["A"].speed += change if step == 40 else 0.0
        watch.look(DT)
        if step == 40:
            break
    found = {each["field"]: each for each in watch.findings()}[field]
    assert (found["limit"], found["event"], found["count"]) == ("DynamicConstraints", "late", 1)
    assert found["found"] == pytest.approx(abs(change) / DT / DT if worst is None else worst, rel=1e-6)


def beside(limits: str) -> str:
    return (
        '<PrivateAction><LateralAction><LateralDistanceAction entityRef="B" continuous="true" freespace="false" '
        f'distance="3.5" displacement="leftToReferencedEntity" coordinateSystem="lane"><DynamicConstraints {limits}/>'
        "</LateralDistanceAction></LateralAction></PrivateAction>"
    )


def test_moving_to_the_side_within_the_constraints_is_not_found(make: Make) -> None:
    b = [teleport(lane_position(100.0, lane=-2)), speed(10.0)]
    limits = 'maxSpeed="1" maxAcceleration="1" maxDeceleration="1"'
    assert watched(make(A=START, B=b, stories=later(beside(limits))), 8.0) == ()


@pytest.mark.parametrize("push", [0.06, 0.1, 0.2])
def test_a_push_to_the_side_is_found_against_the_lateral_constraints(make: Make, push: float) -> None:
    b = [teleport(lane_position(100.0, lane=-2)), speed(10.0)]
    board = make(A=START, B=b, stories=later(beside('maxSpeed="1" maxAcceleration="1" maxDeceleration="1"')))
    board.start()
    watch = Plausibility(board)
    for step in range(60):
        board.step(DT)
        board.entities["A"].y += push if step == 59 else 0.0  # 0.1 m in 50 ms: 2 m/s, from rest 40 m/s^2
        watch.look(DT)
    found = {each["field"]: each for each in watch.findings()}
    assert found["A.lateral_speed"]["found"] == pytest.approx(push / DT, abs=0.01)
    assert found["A.lateral_acceleration"]["found"] == pytest.approx(push / DT**2, abs=0.2)
    assert found["A.lateral_speed"]["limit"] == "DynamicConstraints"


@pytest.mark.parametrize(("target", "found"), [(2.8, False), (6.0, True)])
def test_a_walker_starts_at_once_but_not_with_any_speed(make: Make, target: float, found: bool) -> None:
    board = make(A=[teleport(lane_position(100.0))], stories=later(speed(target)))
    walker = board.entities["A"]
    walker.kind = "pedestrian"
    walker.max_speed = walker.max_acceleration = walker.max_deceleration = float("inf")
    fields = [(each["field"], each["limit"], each["event"]) for each in watched(board)]
    assert fields == ([("A.speed_jump", "continuity", "late")] if found else [])


def test_a_step_of_the_speed_names_the_event_that_was_over_at_once(make: Make) -> None:
    (found,) = watched(make(A=START, stories=later(speed(20.0))))
    assert (found["field"], found["event"], found["limit"]) == ("A.acceleration", "late", "Performance")
    assert found["found"] == pytest.approx((20.0 - 10.0) / DT)


def test_how_a_scenario_begins_is_no_jump(make: Make) -> None:
    assert watched(make(A=START, stories=later(speed(20.0), time=0.0))) == ()


def test_the_step_in_which_the_storyboard_ends_moves_nobody_and_shows_nothing(make: Make) -> None:
    """To the left with 1 m/s^2, for 0.4 s until the storyboard ends: 0.08 m and 0.4 m/s by then, give or take a step.
    It does not stop in that step, which would take 0.4 / 0.05 = 8 m/s^2."""
    limits = 'maxSpeed="1" maxAcceleration="1" maxDeceleration="1"'
    board = make(A=START, B=START, stories=later(beside(limits)), stop=group(condition(at_time(1.4))))
    assert watched(board) == ()
    assert (board.done, board.time) == (True, pytest.approx(1.4))
    assert board.entities["A"].y == pytest.approx(-1.75 + 0.08, abs=0.02)


@pytest.mark.parametrize(
    ("h", "found"),
    [(0.0, None), (0.78, None), (0.79, 0.79), (1.5, 1.5), (-1.5, 1.5), (2.0, 3.14159 - 2.0), (3.14159, None)],
)
def test_who_faces_across_its_lane_and_gets_a_speed_slides(make: Make, h: float, found: float | None) -> None:
    """As a pedestrian that is to cross the road and has no trajectory; who drives backwards does not slide."""
    facing = lane_position(100.0, inner=f'<Orientation type="relative" h="{h}"/>')
    board = make(A=[teleport(facing)], stories=later(speed(2.0, "linear", "time", 1.0)))
    findings = {each["field"]: each for each in watched(board)}
    assert set(findings) == (set() if found is None else {"A.direction_of_motion"})
    if found is not None:
        slides = findings["A.direction_of_motion"]
        assert slides["worst"] == pytest.approx(found, abs=1e-4)
        assert slides["t"] == pytest.approx(1.1, abs=0.06)
        assert "direction of motion of A" in said_of(slides)
