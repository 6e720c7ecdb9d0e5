"""Speed profiles with limits of jerk: what must hold of any of them, and closed forms."""

from __future__ import annotations

from itertools import pairwise

import pytest

from openscenario.storyboard.limits import Limits
from openscenario.storyboard.speed_curve import Piece, Point, curve

LIMITS = Limits(speed=50.0, up=5.0, down=10.0, rise=4.0, fall=3.0)
NO_ROOM = ((0.0, 0.0), (0.1, 0.4), (0.2, 0.0), (0.3, 0.4))


def profile(*points: Point, acceleration: float = 0.0, limits: Limits = LIMITS) -> list[Piece]:
    return curve(points, acceleration, limits)


def held(pieces: list[Piece], limits: Limits = LIMITS) -> None:
    """No jump of speed or acceleration, nothing beyond the limits, no acceleration at the end."""
    for piece, after in pairwise(pieces):
        assert after.time >= piece.time
        assert piece.at(after.time) == pytest.approx(after.speed, abs=1e-9)
        assert piece.slope(after.time) == pytest.approx(after.acceleration, abs=1e-6)
        assert -limits.fall <= piece.jerk <= limits.rise
        assert -limits.down - 1e-9 <= piece.acceleration <= limits.up + 1e-9
        assert abs(piece.speed) <= limits.speed + 1e-9
    assert pieces[-1].acceleration == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    "points",
    [
        ((0.0, 0.0), (4.0, 10.0), (8.0, 4.0), (10.0, 8.0)),
        ((0.0, 10.0), (6.0, 2.0)),
        ((0.0, 0.0), (10.0, 20.0)),
        ((0.0, 0.0), (1.0, 20.0)),  # not to be had in the given time
        ((0.0, 0.0), (1.0, 20.0), (2.0, 0.0), (3.0, 30.0)),  # none of them is
        NO_ROOM,  # the lines are slow enough, their corners are too near to each other
        ((0.0, 0.0), (3.0, 0.0), (6.0, 9.0)),
    ],
)
@pytest.mark.parametrize("acceleration", [0.0, 3.0, -6.0])
def test_speed_and_acceleration_have_no_jumps_and_nothing_is_beyond_its_limits(
    points: tuple[Point, ...], acceleration: float
) -> None:
    pieces = profile(*points, acceleration=acceleration)
    held(pieces)
    assert pieces[0].acceleration == acceleration
    assert pieces[-1].speed == pytest.approx(points[-1][1])


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


def test_a_single_target_beyond_the_limits_comes_later() -> None:
    """0 to 30 m/s in 4 s: 5 m/s^2 is reached with 4 m/s^3 after 1.25 s and left with 3 m/s^3 in 5/3 s; in these the
    speed grows by 25/8 and 25/6 m/s, the rest needs (30 - 25/8 - 25/6) / 5 s."""
    pieces = profile((0.0, 0.0), (4.0, 30.0))
    held(pieces)
    assert pieces[-1].time == pytest.approx(1.25 + 5.0 / 3.0 + (30.0 - 25.0 / 8.0 - 25.0 / 6.0) / 5.0)


def test_who_accelerates_more_than_it_needs_takes_it_back_first() -> None:
    """From 3 m/s^2 to 20 m/s in 10 s, begun at 10 m/s: with -3 m/s^3 all the way, 10 = 9/6 + a (10 - 1)."""
    pieces = profile((0.0, 10.0), (10.0, 20.0), acceleration=3.0)
    held(pieces)
    assert pieces[-1].time == pytest.approx(10.0)
    assert pieces[1].acceleration == pytest.approx(8.5 / 9.0)


def test_lines_are_stretched_to_the_limits_and_the_later_ones_put_off() -> None:
    """Without jerk: 0 to 20 m/s at 5 m/s^2 takes 4 s, not 1; down to 5 m/s in the 2 s given; 80 is 50 m/s, 9 s."""
    limits = Limits(speed=50.0, up=5.0, down=10.0)
    pieces = profile((0.0, 0.0), (1.0, 20.0), (3.0, 5.0), (3.0, 80.0), limits=limits)
    assert [(piece.time, piece.speed) for piece in pieces] == [
        (pytest.approx(time), pytest.approx(speed)) for time, speed in ((0, 0), (4, 20), (6, 5), (15, 50))
    ]


@pytest.mark.parametrize("limits", [Limits(up=0.0), Limits(rise=0.0), Limits(up=0.0, rise=4.0)])
def test_what_the_limits_forbid_is_never_reached(limits: Limits) -> None:
    pieces = profile((0.0, 3.0), (1.0, 20.0), (2.0, 0.0), limits=limits)
    assert pieces[-1].time == float("inf")
    assert [piece.at(100.0) for piece in pieces[:-1]] == [3.0] * (len(pieces) - 1)
