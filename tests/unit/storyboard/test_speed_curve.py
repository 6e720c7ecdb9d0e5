"""Speed profiles with limits of jerk: what must hold of any of them, and closed forms."""

from __future__ import annotations

from itertools import pairwise

import pytest

from openscenario.storyboard.limits import Limits
from openscenario.storyboard.speed_curve import Piece, Point, _one_by_one, _top, curve, reach, straight, within

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


@pytest.mark.parametrize(
    ("limits", "last"), [(Limits(up=0.0), 20.0), (Limits(rise=0.0), 0.0), (Limits(up=0.0, rise=4.0), 20.0)]
)
def test_what_the_limits_forbid_is_never_reached(limits: Limits, last: float) -> None:
    """The speed that is never reached, or the last one if there can be no change at all."""
    pieces = profile((0.0, 3.0), (1.0, 20.0), (2.0, 0.0), limits=limits)
    assert pieces[-1] == Piece(float("inf"), last)
    assert [piece.at(100.0) for piece in pieces[:-1]] == [3.0] * (len(pieces) - 1)


@pytest.mark.parametrize("time", [2.0, 3.0, 5.0])
def test_a_piece_has_constant_jerk(time: float) -> None:
    """From 10 m/s with 3 m/s^2 and -1 m/s^3, by the clock on which it begins at 2 s."""
    piece, t = Piece(2.0, 10.0, 3.0, -1.0), time - 2.0
    assert piece.at(time) == pytest.approx(10.0 + 3.0 * t - 0.5 * t * t)
    assert piece.slope(time) == pytest.approx(3.0 - t)


def test_points_at_one_time_are_a_step() -> None:
    pieces = straight([(1.0, 2.0), (3.0, 8.0), (3.0, 5.0), (4.0, 5.0)])
    assert pieces == [Piece(1.0, 2.0, 3.0), Piece(3.0, 5.0, 0.0), Piece(4.0, 5.0)]
    assert straight([(1.0, 2.0)]) == [Piece(1.0, 2.0)]


def test_points_within_the_limits_stay_as_they_are() -> None:
    points = [(0.0, 0.0), (2.0, 10.0), (3.0, 0.0), (4.0, 0.0)]
    assert within(points, LIMITS) == points  # 5 m/s^2 upwards, 10 downwards: just what is allowed


def test_what_is_too_fast_or_too_steep_is_brought_within_the_limits() -> None:
    """Backwards 60 is 50 m/s; braked with 10 m/s^2 that takes 5 s, and all that follows comes 4 s later."""
    points = [(1.0, 0.0), (2.0, -60.0), (4.0, -50.0), (10.0, -50.0)]
    assert within(points, LIMITS) == [(1.0, 0.0), (6.0, -50.0), (8.0, -50.0), (14.0, -50.0)]
    assert within([(0.0, 0.0), (1.0, 2.0)], Limits(up=0.5)) == [(0.0, 0.0), (4.0, 2.0)]


def test_nothing_follows_what_is_never_reached() -> None:
    points = [(0.0, 5.0), (1.0, 5.0), (2.0, 6.0), (3.0, 5.0)]
    assert within(points, Limits(up=0.0)) == [(0.0, 5.0), (1.0, 5.0), (float("inf"), 6.0)]
    assert within(points[:3], Limits(down=0.0)) == points[:3]  # to keep a speed is no braking


def test_before_what_is_never_reached_all_the_rest_is() -> None:
    """Braking to 1 m/s in 2 s is allowed, the way up from there is not."""
    pieces = profile((0.0, 3.0), (2.0, 1.0), (3.0, 5.0), limits=LIMITS._replace(up=0.0))
    assert (pieces[-2].time, pieces[-2].speed) == (pytest.approx(2.0), 1.0)
    assert pieces[-1] == Piece(float("inf"), 5.0)
    held(pieces[:-1])


def integral(pieces: list[Piece]) -> float:
    """Change of speed by the accelerations alone."""
    return sum(0.5 * (a.acceleration + a.slope(b.time)) * (b.time - a.time) for a, b in pairwise(pieces))


JERKS = Limits(speed=100.0, up=5.0, down=4.0, rise=2.0, fall=1.0)


@pytest.mark.parametrize("begin", [-3.0, -0.5, 0.0, 0.5, 2.0])
@pytest.mark.parametrize("target", [-30.0, 3.0, 9.0, 15.0, 45.0])
@pytest.mark.parametrize("duration", [0.0, 6.0, 15.0])
def test_a_single_change_is_smooth_and_in_time_if_it_can_be(begin: float, target: float, duration: float) -> None:
    """Speed is the integral of acceleration, that of jerk; who is there later does as much as it may."""
    pieces = reach(Piece(1.0, 10.0, begin), target, duration, JERKS)
    held(pieces, JERKS)
    assert (pieces[0].time, pieces[0].speed, pieces[0].acceleration) == (1.0, 10.0, begin)
    assert pieces[-1].speed == target
    assert 10.0 + integral(pieces) == pytest.approx(target, abs=1e-6)
    late = pieces[-1].time - (1.0 + duration)
    assert late >= -1e-9
    if late > 1e-6:
        top = max((abs(piece.acceleration) for piece in pieces[1:]), default=0.0)
        most = 5.0 if target > 10.0 + 0.5 * begin * abs(begin) / (1.0 if begin > 0.0 else 2.0) else 4.0
        hold = pieces[2].time - pieces[1].time if len(pieces) == 4 else 0.0
        assert hold <= 1e-9 or top == pytest.approx(most)


def test_who_is_there_when_it_takes_its_foot_off_does_just_that() -> None:
    """2 m/s^2 taken back with 1 m/s^3: 2 s, and 10 + 2 m/s; it waits for its time."""
    pieces = reach(Piece(1.0, 10.0, 2.0), 12.0, 6.0, JERKS)
    assert pieces == [Piece(1.0, 10.0, 2.0, -1.0), Piece(3.0, 12.0), Piece(7.0, 12.0)]
    pieces = reach(Piece(1.0, 10.0, -2.0), 9.0, 0.5, JERKS)
    assert pieces == [Piece(1.0, 10.0, -2.0, 2.0), Piece(2.0, 9.0), Piece(2.0, 9.0)]
    pieces = reach(Piece(1.0, 10.0, -0.5), 9.9375, 0.5, JERKS)  # 0.5 m/s^2 taken back with 2 m/s^3: 0.25 s
    assert pieces == [Piece(1.0, 10.0, -0.5, 2.0), Piece(1.25, 9.9375), Piece(1.5, 9.9375)]
    pieces = reach(Piece(1.0, 10.0, 0.5), 10.125, 0.25, JERKS)  # with 1 m/s^3: half a second
    assert pieces == [Piece(1.0, 10.0, 0.5, -1.0), Piece(1.5, 10.125), Piece(1.5, 10.125)]
    assert reach(Piece(1.0, 10.0), 10.0, 2.0, JERKS) == [Piece(1.0, 10.0), Piece(3.0, 10.0)]


def shown(pieces: list[Piece]) -> list[object]:
    return [pytest.approx((piece.time, piece.speed, piece.acceleration, piece.jerk)) for piece in pieces]


def test_a_small_change_takes_the_time_it_is_given() -> None:
    """With 2 and 1 m/s^3: 0.1 s up to 0.2 m/s^2, 0.3 s of it, 0.2 s back: 0.01 + 0.06 + 0.02 m/s."""
    pieces = reach(Piece(0.0, 10.0), 10.09, 0.6, JERKS)
    assert [tuple(piece) for piece in pieces] == shown(
        [Piece(0.0, 10.0, 0.0, 2.0), Piece(0.1, 10.01, 0.2), Piece(0.4, 10.07, 0.2, -1.0), Piece(0.6, 10.09)]
    )


def test_who_brakes_and_has_no_time_turns_round_as_soon_as_it_can() -> None:
    """From -1 to 0.2 m/s^2 with 2 m/s^3 in 0.6 s, which costs 0.24 m/s; back with 1 m/s^3 in 0.2 s: 0.02 m/s."""
    pieces = reach(Piece(0.0, 10.0, -1.0), 9.78, 0.0, JERKS)
    assert [tuple(piece) for piece in pieces] == shown(
        [Piece(0.0, 10.0, -1.0, 2.0), Piece(0.6, 9.76, 0.2), Piece(0.6, 9.76, 0.2, -1.0), Piece(0.8, 9.78)]
    )


@pytest.mark.parametrize("duration", [0.0, 5.5, 6.0])
def test_who_accelerates_more_than_it_may_comes_back_to_what_it_may(duration: float) -> None:
    """From 6 to 5 m/s^2 with 1 m/s^3: 5.5 m/s in 1 s; back to none in 5 s: 12.5 m/s; the other 22 m/s take 4.4 s. To
    take back 6 m/s^2 alone needs 6 s, so there is no time for less."""
    pieces = reach(Piece(0.0, 10.0, 6.0), 50.0, duration, JERKS)
    assert [tuple(piece) for piece in pieces] == shown(
        [Piece(0.0, 10.0, 6.0, -1.0), Piece(1.0, 15.5, 5.0), Piece(5.4, 37.5, 5.0, -1.0), Piece(10.4, 50.0)]
    )


def test_one_by_one_each_point_has_its_own_time() -> None:
    pieces = _one_by_one([(0.0, 10.0), (10.0, 20.0), (20.0, 10.0)], 0.0, JERKS)
    held(pieces, JERKS)
    (half,) = [piece for piece in pieces[1:-1] if piece.acceleration == 0.0]
    assert (half.time, half.speed) == pytest.approx((10.0, 20.0))
    assert (pieces[-1].time, pieces[-1].speed) == pytest.approx((20.0, 10.0))


def test_who_accelerates_too_much_holds_less_for_as_long_as_its_time_is() -> None:
    """2 m/s^2 taken back with 1 m/s^3 bring 2 m/s in 2 s. For 0.5 m/s more in half a second more it holds 1 m/s^2."""
    pieces = reach(Piece(1.0, 10.0, 2.0), 12.5, 2.5, JERKS)
    assert [(p.time, p.speed, p.acceleration, p.jerk) for p in pieces] == [
        pytest.approx(one)
        for one in ((1.0, 10.0, 2.0, -1.0), (2.0, 11.5, 1.0, 0.0), (2.5, 12.0, 1.0, -1.0), (3.5, 12.5, 0.0, 0.0))
    ]


def test_a_change_as_soon_as_the_limits_allow() -> None:
    """Jerks 2 and 1: a peak a takes a / 2 + a s and brings (1/4 + 1/2) a^2; for 3 m/s that is a = 2 m/s^2 in 3 s."""
    pieces = reach(Piece(0.0, 10.0), 13.0, 0.0, JERKS)
    assert pieces[1].acceleration == pytest.approx(2.0)
    assert [piece.time for piece in pieces] == pytest.approx([0.0, 1.0, 1.0, 3.0])
    pieces = reach(Piece(0.0, 10.0), 7.0, 0.0, JERKS)
    assert [piece.time for piece in pieces] == pytest.approx([0.0, 2.0, 2.0, 3.0])
    assert pieces[1].acceleration == pytest.approx(-2.0)


def test_a_change_that_meets_the_limit_of_acceleration_holds_it() -> None:
    """5 m/s^2 after 2.5 s, back in 5 s: (1/4 + 1/2) 25 = 18.75 m/s; the other 11.25 m/s take 2.25 s."""
    pieces = reach(Piece(0.0, 10.0), 40.0, 0.0, JERKS)
    assert [piece.time for piece in pieces] == pytest.approx([0.0, 2.5, 4.75, 9.75])
    assert [piece.speed for piece in pieces] == pytest.approx([10.0, 16.25, 27.5, 40.0])


def test_the_largest_speed_may_lie_within_a_piece() -> None:
    """From 4 m/s with 2 m/s^2 and -1 m/s^3: 6 m/s after 2 s, 4 m/s after 4 s."""
    assert _top([Piece(0.0, 4.0, 2.0, -1.0), Piece(4.0, 4.0)]) == pytest.approx(6.0)
    assert _top([Piece(0.0, -4.0, -2.0, 1.0), Piece(4.0, -4.0)]) == pytest.approx(6.0)
    assert _top([Piece(0.0, 4.0, 2.0, -1.0), Piece(1.0, 5.5)]) == pytest.approx(5.5)
    assert _top([Piece(0.0, 9.0, -2.0), Piece(1.0, 7.0), Piece(2.0, 7.0)]) == pytest.approx(7.0)
    assert _top([Piece(0.0, 4.0, 2.0, -2.0), Piece(2.0, 4.0)]) == pytest.approx(5.0)  # after 1 s
    assert _top([Piece(0.0, 0.5, -0.1), Piece(1.0, 0.4)]) == pytest.approx(0.4)


def test_two_lines_are_rounded_where_they_meet_and_one_alone_is_not() -> None:
    """2 m/s^2 and none after it: the line's own acceleration is kept, which a change by itself would exceed."""
    pieces = profile((0.0, 0.0), (4.0, 8.0), (8.0, 8.0))
    assert [piece.acceleration for piece in pieces[1:]] == pytest.approx([2.0, 2.0, 0.0])
    assert [piece.jerk for piece in pieces[2:]] == pytest.approx([-3.0, 0.0])
    assert pieces[-1].speed == pytest.approx(8.0)
    assert profile((0.0, 0.0), (4.0, 8.0), (8.0, 8.0), limits=LIMITS._replace(speed=8.0)) == pieces  # just so fast
    more = profile((0.0, 0.0), (2.0, 4.0), (4.0, 8.0), (8.0, 8.0))  # a point on the line is no corner
    assert [tuple(piece) for piece in more] == shown(pieces)
    alone = profile((0.0, 0.0), (4.0, 8.0))
    assert max(piece.acceleration for piece in alone) > 2.1


def test_a_corner_is_the_parabola_that_touches_both_lines() -> None:
    """2 to -1 m/s^2 with -3 m/s^3: 1 s, half of it before the lines meet; from -1 to 0 with 4 m/s^3: 1/4 s."""
    pieces = profile((0.0, 0.0), (4.0, 8.0), (8.0, 4.0), (12.0, 4.0))
    corners = [(piece.time, piece.jerk) for piece in pieces if piece.jerk != 0.0]
    start = 0.5  # 2 m/s^2 with 4 m/s^3; the line is the one through where it has got by then
    assert corners[0] == (0.0, 4.0)
    assert pieces[1].time == pytest.approx(start)
    meet = 4.0 + 0.5 * start * 2.0 / 3.0  # what the start has lost the first line makes up for later
    assert corners[1] == (pytest.approx(meet - 0.5), -3.0)
    assert corners[2] == (pytest.approx(8.0 - 0.125), 4.0)
    assert pieces[-1].time == pytest.approx(8.125)
    assert pieces[-1].speed == pytest.approx(4.0)


def test_a_corner_bends_the_way_its_lines_do_however_small_it_is() -> None:
    """2 to 1.5 m/s^2 with -3 m/s^3: 1/6 s; from 1.5 to 1.75 with 4 m/s^3: 1/16 s; back to 0 with -3 m/s^3: 7/12 s."""
    pieces = profile((0.0, 0.0), (4.0, 8.0), (8.0, 14.0), (12.0, 21.0), (16.0, 21.0), acceleration=2.0)
    held(pieces)
    corners = [(piece, after) for piece, after in pairwise(pieces) if piece.jerk != 0.0 and after.time > piece.time]
    assert [piece.jerk for piece, _ in corners] == [-3.0, 4.0, -3.0]
    assert [0.5 * (piece.time + after.time) for piece, after in corners] == pytest.approx([4.0, 8.0, 12.0])
    assert [after.time - piece.time for piece, after in corners] == pytest.approx([1.0 / 6.0, 1.0 / 16.0, 7.0 / 12.0])
