"""A course as a table over its arc length: every question that one may ask of it, by hand-drawn polylines."""

from __future__ import annotations

import math

import pytest

from openscenario.storyboard.trajectories import Course

# 3-4-5 triangle, then 10 m along y, then 6 m along x, with heights that tell the pieces apart
POINTS = ((0.0, 0.0, 0.0, 0.0), (3.0, 4.0, 1.0, 0.4), (3.0, 14.0, 6.0, 0.8), (9.0, 14.0, 4.0, -0.2))
LENGTH = 21.0
STANDING = (
    (1.0, 2.0, 0.0, 0.3),
    (1.0, 2.0, 0.0, 0.3),
    (5.0, 2.0, 0.0, 0.0),
    (5.0, 2.0, 0.0, 0.0),
    (5.0, 5.0, 0.0, 1.0),
)


@pytest.mark.parametrize(
    ("s", "x", "y", "z", "h"),
    [
        (0.0, 0.0, 0.0, 0.0, 0.0),
        (1.0, 0.6, 0.8, 0.2, 0.08),
        (2.5, 1.5, 2.0, 0.5, 0.2),
        (5.0, 3.0, 4.0, 1.0, 0.4),
        (7.5, 3.0, 6.5, 2.25, 0.5),
        (15.0, 3.0, 14.0, 6.0, 0.8),
        (16.5, 4.5, 14.0, 5.5, 0.55),
        (21.0, 9.0, 14.0, 4.0, -0.2),
    ],
)
def test_a_place_is_interpolated_over_the_arc_length(s: float, x: float, y: float, z: float, h: float) -> None:
    course = Course(POINTS)
    assert course.length == pytest.approx(LENGTH)
    assert course.at(s) == pytest.approx((x, y, z, h))


@pytest.mark.parametrize(("s", "end"), [(-0.5, 0), (-7.0, 0), (21.5, 3), (99.0, 3)])
def test_beyond_an_end_a_course_stands_still_there(s: float, end: int) -> None:
    assert Course(POINTS).at(s) == pytest.approx(POINTS[end])


def test_a_single_point_is_everywhere() -> None:
    course = Course([(2.0, 3.0, 4.0, 0.5)])
    assert course.length == 0.0
    assert course.at(0.0) == course.at(9.0) == course.at(-1.0) == (2.0, 3.0, 4.0, 0.5)
    assert course.tangent(3.0) == 0.5
    assert course.pitch(3.0) == 0.0


def test_points_at_one_place_are_passed_at_once() -> None:
    course = Course(STANDING)
    assert course.length == pytest.approx(7.0)
    assert course.at(0.0)[:2] == (1.0, 2.0)
    assert course.at(2.0)[:2] == pytest.approx((3.0, 2.0))
    assert course.at(5.0)[:2] == pytest.approx((5.0, 3.0))
    assert Course([STANDING[0], STANDING[0]]).at(0.0)[:2] == (1.0, 2.0)


def test_headings_are_unwound_the_short_way() -> None:
    """From 3 rad to -3 rad are 2 pi - 6 = 0.28 rad to the left."""
    course = Course([(0.0, 0.0, 0.0, 3.0), (10.0, 0.0, 0.0, -3.0), (20.0, 0.0, 0.0, 3.0)])
    assert course.h == pytest.approx([3.0, 2.0 * math.pi - 3.0, 3.0])
    assert course.at(5.0)[3] == pytest.approx(math.pi)


@pytest.mark.parametrize(
    ("s", "h"),
    [
        (0.0, 0.0),  # nothing lies before the first point
        (1.0, 0.0),
        (8.0, 0.0),  # as far before the vertex as the corner is long
        (9.0, 0.25),  # half of the way to the mean, which is 0.5
        (10.0, 0.5),
        (11.0, 0.75),
        (12.0, 1.0),
        (15.0, 1.0),
        (18.0, 1.0),
        (19.0, 0.75),  # to 0 again
        (20.0, 0.5),
        (22.0, 0.0),
        (30.0, 0.0),
    ],
)
def test_where_it_is_not_smooth_the_heading_turns_within_two_metres_of_a_vertex(s: float, h: float) -> None:
    """Pieces of 10 m with headings 0, 1 and 0: half of the turn before the vertex, half of it behind, linearly."""
    points = [(10.0 * i, 0.0, 0.0, heading) for i, heading in enumerate((0.0, 1.0, 0.0, 0.0))]
    assert Course(points, smooth=[False] * 4).at(s)[3] == pytest.approx(h)


def test_a_corner_takes_no_more_than_half_of_a_piece() -> None:
    """Pieces of 2 m: the corners are 1 m long, and meet in the middle."""
    points = [(2.0 * i, 0.0, 0.0, heading) for i, heading in enumerate((0.0, 1.0, 0.0))]
    course = Course(points, smooth=[False] * 3)
    assert [course.at(s)[3] for s in (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5)] == pytest.approx(
        [0.0, 0.0, 0.25, 0.5, 0.75, 1.0, 0.75]
    )


@pytest.mark.parametrize(("corner", "before", "behind"), [(4.0, 0.25, 0.75), (0.0, 0.0, 1.0)])
def test_the_length_of_a_corner_can_be_chosen(corner: float, before: float, behind: float) -> None:
    """Half way through a corner of 4 m the turn is at a quarter; without corners it is at the vertex."""
    points = [(10.0 * i, 0.0, 0.0, heading) for i, heading in enumerate((0.0, 1.0, 1.0))]
    course = Course(points, smooth=[False] * 3, corner=corner)
    assert course.at(8.0)[3] == pytest.approx(before)
    assert course.at(12.0)[3] == pytest.approx(behind)


def test_each_piece_turns_as_its_own_first_point_says() -> None:
    """The first piece evenly, the second in its corners: that behind the vertex 10 begins half way."""
    points = [(10.0 * i, 0.0, 0.0, heading) for i, heading in enumerate((0.0, 1.0, 3.0))]
    course = Course(points, smooth=[True, False, True])
    assert course.at(5.0)[3] == pytest.approx(0.5)
    assert course.at(9.0)[3] == pytest.approx(0.9)
    assert course.at(11.0)[3] == pytest.approx(0.75)
    assert course.at(15.0)[3] == pytest.approx(1.0)
    assert course.at(19.0)[3] == pytest.approx(1.5)


@pytest.mark.parametrize(
    ("s", "direction"),
    [(-1.0, math.atan2(4, 3)), (0.0, math.atan2(4, 3)), (4.9, math.atan2(4, 3)), (5.0, math.pi / 2.0),
     (14.0, math.pi / 2.0), (15.0, 0.0), (21.0, 0.0), (50.0, 0.0)],
)  # fmt: skip
def test_the_tangent_is_that_of_the_piece(s: float, direction: float) -> None:
    assert Course(POINTS).tangent(s) == pytest.approx(direction)


def test_short_pieces_have_directions_of_their_own() -> None:
    course = Course([(0.0, 0.0, 0.0, 0.9), (0.01, 0.0, 0.0, 0.9), (0.01, 0.01, 0.0, 0.9), (0.01, 0.02, 0.0, 0.9)])
    assert [course.tangent(s) for s in (0.0, 0.005, 0.015, 0.025)] == pytest.approx([0.0, 0.0, *[0.5 * math.pi] * 2])


def test_where_points_coincide_the_tangent_is_that_of_the_piece_before() -> None:
    course = Course(STANDING)
    assert course.tangent(2.0) == pytest.approx(0.0)
    assert course.tangent(4.0) == pytest.approx(math.pi / 2.0)
    ends = Course([(0.0, 0.0, 0.0, 0.7), (0.0, 3.0, 0.0, 0.7), (0.0, 3.0, 0.0, 0.7)])
    assert ends.tangent(3.0) == pytest.approx(math.pi / 2.0)
    assert Course([STANDING[0], STANDING[0]]).tangent(0.0) == 0.3


@pytest.mark.parametrize(
    ("s", "uphill"),
    [(-1.0, 1 / 5), (0.0, 1 / 5), (4.0, 1 / 5), (5.0, 5 / 10), (14.0, 5 / 10), (16.0, -2 / 6), (30.0, -2 / 6)],
)
def test_the_pitch_is_minus_the_angle_of_the_rise(s: float, uphill: float) -> None:
    """ISO 8855: a positive pitch lowers the front."""
    assert Course(POINTS).pitch(s) == pytest.approx(-math.atan(uphill))


def test_where_points_coincide_there_is_no_pitch() -> None:
    assert Course([(0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 5.0, 0.0)]).pitch(0.0) == 0.0


@pytest.mark.parametrize(
    ("x", "y", "s"),
    [
        (-5.0, -5.0, 0.0),
        (1.5, 2.0, 2.5),
        (1.5 - 0.8, 2.0 + 0.6, 2.5),  # 1 m to the left, at right angles
        (2.0, 9.0, 10.0),
        (5.0, 9.0, 10.0),
        (3.0, 4.0, 5.0),
        (7.0, 15.0, 19.0),
        (7.0, 12.0, 19.0),
        (30.0, 14.0, 21.0),
    ],
)
def test_the_nearest_point_lies_at_right_angles_or_at_a_vertex(x: float, y: float, s: float) -> None:
    assert Course(POINTS).nearest(x, y) == pytest.approx(s)


def test_of_points_equally_near_the_first_is_meant() -> None:
    """There and back: both ways pass (3, 1) at a distance of 1 m."""
    assert Course([(0.0, 0.0, 0.0, 0.0), (10.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)]).nearest(3.0, 1.0) == 3.0


def test_points_that_coincide_are_near_too() -> None:
    assert Course([STANDING[0], STANDING[0]]).nearest(4.0, 4.0) == 0.0
    assert Course(STANDING).nearest(1.0, 1.0) == 0.0
    assert Course([(1.0, 2.0, 0.0, 0.0)]).nearest(4.0, 4.0) == 0.0


TIMES = (2.0, 4.0, 4.0, 7.0)


@pytest.mark.parametrize(
    ("t", "s"),
    [(0.0, 0.0), (2.0, 0.0), (3.0, 2.5), (3.6, 4.0), (4.0, 15.0), (5.5, 18.0), (7.0, 21.0), (8.0, 21.0)],
)
def test_between_time_stamps_the_speed_is_constant(t: float, s: float) -> None:
    """5 m in 2 s, 10 m at once, 6 m in 3 s."""
    assert Course(POINTS, TIMES).s_at(t) == pytest.approx(s)


def test_without_time_stamps_there_is_no_way_and_no_time() -> None:
    course = Course(POINTS)
    assert course.t is None
    assert course.s_at(3.0) == course.time_at(3.0) == course.start_time == course.end_time == 0.0


@pytest.mark.parametrize(
    ("s", "t"), [(-1.0, 2.0), (0.0, 2.0), (0.5, 2.2), (2.5, 3.0), (4.0, 3.6), (10.0, 4.0), (18.0, 5.5), (21.0, 7.0)]
)
def test_the_time_of_a_way_is_the_inverse_of_the_way_of_a_time(s: float, t: float) -> None:
    course = Course(POINTS, TIMES)
    assert (course.start_time, course.end_time) == (2.0, 7.0)
    assert course.time_at(s) == pytest.approx(t)


def line(*ways: float) -> list[tuple[float, float, float, float]]:
    return [(x, 0.0, 0.0, 0.0) for x in ways]


def test_who_has_a_speed_meets_each_stamp_with_constant_acceleration() -> None:
    """s = v t + a t^2 / 2: from 4 m/s 16 m in 2 s with a = 4 to 12 m/s, then 20 m in 2 s with a = -2 to 8 m/s."""
    course = Course(line(0.0, 16.0, 36.0), (1.0, 3.0, 5.0), speed=4.0)
    assert course.s_at(2.0) == pytest.approx(4.0 + 2.0)
    assert course.s_at(3.0) == pytest.approx(16.0)
    assert course.s_at(4.0) == pytest.approx(16.0 + 12.0 - 1.0)
    assert course.s_at(5.0) == course.s_at(6.0) == pytest.approx(36.0)


def test_who_is_too_fast_brakes_to_a_stand_and_waits() -> None:
    """10 m from 10 m/s by a = -v^2 / 2 s = -5 m/s^2 take 2 s of the 5; then 9 m in 3 s from rest, a = 2 m/s^2."""
    course = Course(line(0.0, 10.0, 19.0), (0.0, 5.0, 8.0), speed=10.0)
    assert course.s_at(1.0) == pytest.approx(7.5)
    assert course.s_at(2.0) == course.s_at(4.0) == pytest.approx(10.0)
    assert course.s_at(6.0) == pytest.approx(11.0)


def test_who_is_just_slow_enough_comes_to_a_stand_in_time() -> None:
    course = Course(line(0.0, 10.0, 19.0), (0.0, 2.0, 5.0), speed=10.0)
    assert course.s_at(1.0) == pytest.approx(7.5)
    assert course.s_at(3.0) == pytest.approx(11.0)


def test_a_stay_begins_anew_from_rest() -> None:
    """3 s at x = 10; then 9 m in 3 s from rest."""
    course = Course(line(0.0, 10.0, 10.0, 19.0), (0.0, 1.0, 4.0, 7.0), speed=10.0)
    assert course.s_at(3.0) == pytest.approx(10.0)
    assert course.s_at(5.0) == pytest.approx(11.0)


def test_what_takes_no_time_leaves_the_speed_as_it_is() -> None:
    """From 10 m/s 10 m in 1 s, then 5 m at once, then 10 m in 1 s without acceleration."""
    course = Course(line(0.0, 10.0, 15.0, 25.0), (0.0, 1.0, 1.0, 2.0), speed=10.0)
    assert course.s_at(0.5) == pytest.approx(5.0)
    assert course.s_at(1.5) == pytest.approx(20.0)
    short = Course(line(0.0, 10.0, 10.5, 20.5), (0.0, 1.0, 1.0, 2.0), speed=10.0)  # half a metre is a way too
    assert short.s_at(1.5) == pytest.approx(15.5)
