"""Angles, turned vectors and lane ids: what a position is made of."""

from __future__ import annotations

import math

import pytest

from openscenario.storyboard.places import turned_in_plane, wrap, yaw_in_plane
from openscenario.storyboard.positions import shifted_lane, turned


@pytest.mark.parametrize(
    ("angle", "wrapped"),
    [(0.0, 0.0), (3.0, 3.0), (-3.0, -3.0), (math.pi, math.pi), (-math.pi, math.pi), (4.0, 4.0 - math.tau),
     (-4.0, math.tau - 4.0), (7.0, 7.0 - math.tau), (-7.0, math.tau - 7.0), (10.0, 10.0 - 2.0 * math.tau),
     (-10.0, 2.0 * math.tau - 10.0), (100.0, 100.0 - 16.0 * math.tau), (3.0 * math.pi, math.pi),
     (-3.0 * math.pi, math.pi)],
)  # fmt: skip
def test_an_angle_is_wrapped_into_a_turn_that_ends_with_pi(angle: float, wrapped: float) -> None:
    assert wrap(angle) == pytest.approx(wrapped, abs=1e-12)


def test_on_level_ground_a_yaw_is_a_heading() -> None:
    assert turned_in_plane(0.4, 0.0, 0.0, 0.7) == (pytest.approx(1.1), 0.0, 0.0)
    assert yaw_in_plane(0.0, 0.0, 0.7) == 0.7


def test_across_a_slope_pitch_becomes_roll() -> None:
    """A quarter turn to the left on a plane that falls ahead by 0.2 rad: its right side is now the lower one."""
    assert turned_in_plane(0.4, 0.2, 0.0, 0.5 * math.pi) == pytest.approx((0.4 + 0.5 * math.pi, 0.0, 0.2))


def test_across_a_bank_roll_becomes_pitch() -> None:
    """On a plane that falls to the right by 0.2 rad the left is uphill: the nose goes up, which is negative pitch."""
    assert turned_in_plane(0.4, 0.0, 0.2, 0.5 * math.pi) == pytest.approx((0.4 + 0.5 * math.pi, -0.2, 0.0))


@pytest.mark.parametrize(("pitch", "roll"), [(0.3, 0.0), (0.0, 0.3), (0.3, -0.4), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0),
                                             (0.0, -1.0)])  # fmt: skip
@pytest.mark.parametrize("yaw", [0.5, -2.0])
def test_a_yaw_in_a_plane_is_found_again_from_the_heading(pitch: float, roll: float, yaw: float) -> None:
    heading, _, _ = turned_in_plane(0.0, pitch, roll, yaw)
    assert yaw_in_plane(pitch, roll, heading) == pytest.approx(yaw)
    assert abs(heading - yaw) > 1e-3  # seen from above it is another angle


def test_a_body_that_has_turned_round_looks_uphill_instead_of_downhill() -> None:
    h, pitch, roll = turned_in_plane(0.0, 0.3, -0.1, math.pi)
    assert (math.cos(h), pitch, roll) == pytest.approx((-1.0, -0.3, 0.1))


@pytest.mark.parametrize(
    ("angles", "seen"),
    [
        ((0.0, 0.0, 0.0), (1.0, 2.0, 3.0)),
        ((0.5 * math.pi, 0.0, 0.0), (-2.0, 1.0, 3.0)),  # heading: x to y
        ((0.0, 0.5 * math.pi, 0.0), (3.0, 2.0, -1.0)),  # pitch: z to x, the nose down
        ((0.0, 0.0, 0.5 * math.pi), (1.0, -3.0, 2.0)),  # roll: y to z
        ((0.5 * math.pi, 0.5 * math.pi, 0.0), (-2.0, 3.0, -1.0)),
        ((0.5 * math.pi, 0.0, 0.5 * math.pi), (3.0, 1.0, 2.0)),
    ],
)
def test_quarter_turns_of_a_body(angles: tuple[float, float, float], seen: tuple[float, float, float]) -> None:
    """ISO 8855: first roll, then pitch, then heading."""
    assert turned(*angles, 1.0, 2.0, 3.0) == pytest.approx(seen)


def test_a_turned_vector_keeps_its_length() -> None:
    assert math.hypot(*turned(0.3, -0.4, 1.1, 1.0, 2.0, 3.0)) == pytest.approx(math.sqrt(14.0))


@pytest.mark.parametrize(
    ("lane", "by", "new"),
    [(-1, 0, -1), (-2, 1, -1), (-1, 1, 1), (-1, 2, 2), (-2, 2, 1), (-1, -1, -2), (1, 1, 2), (1, -1, -1), (1, -2, -2),
     (2, -1, 1), (2, -2, -1), (3, -5, -3), (0, 0, 0), (0, 1, 1), (0, -1, -1)],
)  # fmt: skip
def test_counting_lanes_leaves_out_the_middle_one(lane: int, by: int, new: int) -> None:
    """Lane 0 has no width; from it the next ones are 1 and -1."""
    assert shifted_lane(lane, by) == new
