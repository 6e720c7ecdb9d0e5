"""Distances along and across the trajectory that an entity follows (ASAM OpenSCENARIO XML 1.3, "Trajectory
coordinate system": s along the trajectory, t to its left); without one there are none."""

from __future__ import annotations

import math

import pytest

from openscenario.storyboard.distances import measure
from openscenario.storyboard.engine import Storyboard

from .conftest import Make, by_entity, condition, event, group, log, run, speed, story, teleport


def follow(*points: tuple[float, float]) -> str:
    vertices = "".join(f'<Vertex><Position><WorldPosition x="{x}" y="{y}"/></Position></Vertex>' for x, y in points)
    return (
        '<PrivateAction><RoutingAction><FollowTrajectoryAction><TrajectoryRef><Trajectory name="t" closed="false">'
        f"<Shape><Polyline>{vertices}</Polyline></Shape></Trajectory></TrajectoryRef><TimeReference><None/></TimeReference>"
        '<TrajectoryFollowingMode followingMode="position"/></FollowTrajectoryAction></RoutingAction></PrivateAction>'
    )


CORNER = follow((0.0, 0.0), (50.0, 0.0), (50.0, 50.0))  # first along x, then along y


def world(x: float, y: float, h: float = 0.0) -> str:
    return teleport(f'<WorldPosition x="{x}" y="{y}" h="{h}"/>')


def board_with(make: Make, x: float, y: float, *actions: str, stories: str = "") -> Storyboard:
    return make(A=[speed(10.0), CORNER], B=[world(x, y), *actions], stories=stories, without_road=True)


@pytest.mark.parametrize(
    ("x", "y", "s", "t"),
    [
        (20.0, 3.0, 20.0, 3.0),
        (48.0, 30.0, 80.0, 2.0),  # round the corner, to the left
        (53.0, 70.0, 120.0, -3.0),  # 20 m beyond its end
        (-5.0, 1.0, -5.0, 1.0),
    ],
)
def test_s_and_t_are_those_of_the_trajectory(make: Make, x: float, y: float, s: float, t: float) -> None:
    board = board_with(make, x, y)
    run(board, 0.0)
    a, b = board.entities["A"], board.entities["B"]
    assert measure(board, a, b, kind="longitudinal", system="trajectory", free=False)() == pytest.approx(s)
    assert measure(board, a, b, kind="lateral", system="trajectory", free=False)() == pytest.approx(t)
    run(board, 1.0)
    assert measure(board, a, b, kind="longitudinal", system="trajectory", free=False)() == pytest.approx(s - 10.0)


@pytest.mark.parametrize(("y", "h", "t"), [(3.0, 0.5 * math.pi, 1.0), (6.0, -0.5 * math.pi, 1.0),
                                           (4.0, -0.5 * math.pi, 0.0), (-3.0, -0.5 * math.pi, -1.0)])  # fmt: skip
def test_who_stands_across_reaches_as_far_aside_as_its_ends(make: Make, y: float, h: float, t: float) -> None:
    """Its front is 4 m from its reference point and its rear 1 m; A's sides are 1 m from the trajectory."""
    board = make(A=[speed(10.0), CORNER], B=[world(20.0, y, h)], without_road=True)
    run(board, 0.0)
    a, b = board.entities["A"], board.entities["B"]
    found = measure(board, a, b, kind="lateral", system="trajectory", free=True)()
    assert found == pytest.approx(t, abs=1e-9)


def test_free_distances_are_between_the_bodies(make: Make) -> None:
    """A reaches 4 m ahead of its reference point; B, which stands across, 1 m to either side (conftest: 5 x 2 m)."""
    board = board_with(make, 50.0, 30.0)
    run(board, 0.0)
    a, b = board.entities["A"], board.entities["B"]
    assert measure(board, a, b, kind="longitudinal", system="trajectory", free=True)() == pytest.approx(
        80.0 - 4.0 - 1.0
    )


def test_without_a_trajectory_there_is_no_such_distance(make: Make) -> None:
    board = make(A=[world(0.0, 0.0), speed(10.0)], B=[world(20.0, 0.0)], without_road=True)
    run(board, 0.1)
    a, b = board.entities["A"], board.entities["B"]
    assert measure(board, a, b, kind="longitudinal", system="trajectory", free=False)() is None


@pytest.mark.parametrize(("of_b", "at"), [(0.0, 6.0), (5.0, 8.0)])
def test_time_to_collision_round_a_corner(make: Make, of_b: float, at: float) -> None:
    """B is 80 m ahead along the trajectory: standing, it is 2 s away after 60 m; at 5 m/s 40 m are left after 8 s."""
    value = 2.0 if of_b == 0.0 else 8.0
    test = (
        f'<TimeToCollisionCondition value="{value + 1e-6}" freespace="false" coordinateSystem="trajectory" '
        'relativeDistanceType="longitudinal" rule="lessOrEqual"><TimeToCollisionConditionTarget><EntityRef '
        'entityRef="B"/></TimeToCollisionConditionTarget></TimeToCollisionCondition>'
    )
    act = event("e", speed(10.0), start=group(condition(by_entity(test, "A"))))
    board = make(
        A=[speed(10.0), CORNER],
        B=[world(50.0, 30.0, 1.5707963267948966), speed(of_b)],
        stories=story(act),
        without_road=True,
    )
    run(board, at + 0.5)
    assert [time for time, _, what in log(board, "event") if what == "startTransition"] == [pytest.approx(at, abs=0.02)]
