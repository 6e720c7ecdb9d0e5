"""Speed profiles with limits of jerk: what must hold of any of them, and closed forms."""

from __future__ import annotations

from itertools import pairwise

import pytest

from openscenario import model
from openscenario.storyboard.speed_curve import Piece, rounded, straight

LIMITS = model.DynamicConstraints(
    max_acceleration=5.0, max_deceleration=10.0, max_acceleration_rate=4.0, max_deceleration_rate=3.0, max_speed=50.0
)


def profile(*points: tuple[float, float]) -> list[Piece]:
    curve = rounded(points, 0.0, LIMITS)
    assert curve is not None
    return curve


@pytest.mark.parametrize(
    "points",
    [
        ((0.0, 0.0), (4.0, 10.0), (8.0, 4.0), (10.0, 8.0)),
        ((0.0, 10.0), (6.0, 2.0)),
        ((0.0, 0.0), (10.0, 20.0)),
        ((0.0, 0.0), (1.0, 20.0)),  # not to be had in the given time
    ],
)
def test_speed_and_acceleration_have_no_jumps_and_jerk_keeps_its_limits(
    points: tuple[tuple[float, float], ...],
) -> None:
    pieces = profile(*points)
    for piece, after in pairwise(pieces):
        assert after.time >= piece.time
        assert piece.at(after.time) == pytest.approx(after.speed, abs=1e-9)
        assert piece.slope(after.time) == pytest.approx(after.acceleration, abs=1e-9)
        assert piece.jerk in (0.0, 4.0, -3.0)
        assert -10.0 <= piece.acceleration <= 5.0
    assert pieces[-1].speed == pytest.approx(points[-1][1])
    assert pieces[-1].acceleration == pytest.approx(0.0, abs=1e-9)


def test_between_the_corners_the_lines_are_kept() -> None:
    """From (4, 10) to (8, 4) and from there to (10, 8): the middles of the lines lie on the curve."""
    pieces = profile((0.0, 0.0), (4.0, 10.0), (8.0, 4.0), (10.0, 8.0))

    def at(time: float) -> float:
        return [piece for piece in pieces if piece.time <= time][-1].at(time)

    assert at(6.0) == pytest.approx(7.0)
    assert at(9.0) == pytest.approx(6.0)


def test_a_single_target_is_reached_in_its_time() -> None:
    """0 to 20 m/s in 10 s with 4 and -3 m/s^3: 20 = 10 a - (1/8 + 1/6) a^2."""
    pieces = profile((0.0, 0.0), (10.0, 20.0))
    assert pieces[-1].time == pytest.approx(10.0)
    a = pieces[1].acceleration
    assert 10.0 * a - (1.0 / 8.0 + 1.0 / 6.0) * a * a == pytest.approx(20.0)


def test_a_corner_without_room_leaves_the_lines_as_they_are() -> None:
    points = ((0.0, 0.0), (0.1, 0.4), (0.2, 0.0), (0.3, 0.4))
    assert rounded(points, 0.0, LIMITS) is None
    assert [piece.acceleration for piece in straight(points)] == [pytest.approx(k) for k in (4.0, -4.0, 4.0, 0.0)]
