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


def test_a_speed_above_the_maximum_is_found(make: Make) -> None:
    findings = {each["field"]: each for each in watched(make(A=START, stories=later(follow_at(80.0))))}
    assert findings["A.speed"]["found"] == pytest.approx(80.0, rel=1e-3)
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
