"""Which angles boxes fill as seen from the ego, by complex numbers, and which share of them is behind others."""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest

from vehicle.model.occlusion import RAYS, _angles, hidden_share
from vehicle.model.perception_effects import Tracks

Box = tuple[float, float, float, float, float]  # x, y, yaw, length, width


def seen(*boxes: Box, ego: tuple[float, float] = (0.0, 0.0), t: tuple[float, ...] = ()) -> Tracks:
    rows = np.array(boxes, dtype=float).reshape(-1, 5)
    n = len(rows)
    zero = np.zeros(n)
    return Tracks(np.array(t) if t else zero, np.arange(n), rows[:, 0], rows[:, 1], rows[:, 2], zero, zero,
                  np.full(n, ego[0]), np.full(n, ego[1]), zero, rows[:, 3], rows[:, 4])  # fmt: skip


@pytest.mark.parametrize("ego", [(0.0, 0.0), (3.0, -7.0)])
@pytest.mark.parametrize(
    ("x", "y", "yaw", "length", "width"),
    [
        (10.0, 2.0, 0.3, 4.0, 2.0),
        (-9.0, 0.5, 1.2, 4.0, 2.0),  # behind, across the seam of the angles
        (-9.0, -0.5, -0.4, 4.0, 2.0),
        (1.0, 6.0, 2.5, 5.0, 1.0),
        (2.0, -5.0, 0.0, 1.0, 3.0),
        (4.0, -5.0, -2.0, 6.0, 2.0),
    ],
)
def test_a_box_fills_the_angles_of_its_outermost_corners(
    x: float, y: float, yaw: float, length: float, width: float, ego: tuple[float, float]
) -> None:
    """The angle of a corner from the middle of the box is that of their quotient."""
    middle, half = _angles(seen((x + ego[0], y + ego[1], yaw, length, width), ego=ego))
    centre, turn = complex(x, y), cmath.exp(1j * yaw)
    corners = [centre + turn * complex(a * length / 2.0, b * width / 2.0) for a in (1, -1) for b in (1, -1)]
    off = [cmath.phase(corner / centre) for corner in corners]
    assert half[0] == pytest.approx(0.5 * (max(off) - min(off)))
    away = middle[0] - cmath.phase(centre) - 0.5 * (max(off) + min(off))
    assert math.remainder(away, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("x", "y", "yaw", "inside"),
    [
        (0.0, 0.0, 0.0, True),
        (1.99, 0.99, 0.0, True),
        (2.01, 0.0, 0.0, False),
        (-2.01, 0.0, 0.0, False),
        (0.0, 1.01, 0.0, False),
        (0.0, -1.01, 0.0, False),
        (2.0, 1.0, 0.0, True),  # its corner
        (0.0, 1.9, 0.5 * math.pi, True),  # turned, its length lies along y
        (1.1, 0.0, 0.5 * math.pi, False),
        (1.2, 1.2, 0.25 * math.pi, True),  # 1.7 m ahead of the middle along the diagonal
        (1.2, -1.2, 0.25 * math.pi, False),  # and 1.7 m beside it
        (1.2, -1.2, -0.25 * math.pi, True),
    ],
)
def test_from_within_a_box_there_is_no_angle(x: float, y: float, yaw: float, inside: bool) -> None:
    _, half = _angles(seen((x, y, yaw, 4.0, 2.0)))
    assert (float(half[0]) == 0.0) is inside


def plate(distance: float, low: float, high: float) -> Box:
    """A thin plate across the line of sight, whose ends are seen at these angles [rad] from the x axis."""
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    return (distance * math.cos(middle), distance * math.sin(middle), middle, 0.0, 2.0 * distance * math.tan(half))


@pytest.mark.parametrize("about", [0.0, 1.5, math.pi, -2.0])
@pytest.mark.parametrize(
    ("low", "high", "share"),
    [
        (-0.4, 0.4, 1.0),
        (-0.32, 0.0, 0.5),
        (0.0, 0.32, 0.5),
        (0.16, 0.9, 0.25),
        (-0.9, -0.16, 0.25),
        (-0.08, 0.08, 0.25),
        (0.33, 0.5, 0.0),
        (-0.5, -0.33, 0.0),
    ],
)
def test_what_is_behind_another_box_is_the_part_of_its_angle_that_both_fill(
    low: float, high: float, share: float, about: float
) -> None:
    """The farther one fills 0.64 rad; a ray is a 64th of that, so a border may be off by one."""
    rows = seen(plate(30.0, about - 0.32, about + 0.32), plate(10.0, about + low, about + high))
    found = hidden_share(rows)
    assert found[0] == pytest.approx(share, abs=1.01 / RAYS)
    assert found[1] == 0.0


def test_rays_stand_in_the_middles_of_equal_parts() -> None:
    """A screen that ends a quarter of a ray's part beyond a border of it hides a whole number of rays."""
    for count in (1, 16, 63):
        edge = -0.32 + 0.64 * (count + 0.25) / RAYS
        found = hidden_share(seen(plate(30.0, -0.32, 0.32), plate(10.0, -0.5, edge)))
        assert found[0] == count / RAYS
    none = hidden_share(seen(plate(30.0, -0.32, 0.32), plate(10.0, -0.5, -0.32 + 0.64 * 0.25 / RAYS)))
    assert none[0] == 0.0


def test_of_two_as_far_as_each_other_neither_hides_the_other() -> None:
    assert hidden_share(seen((0.0, 20.0, 0.0, 4.0, 2.0), (0.0, 20.0, 0.0, 4.0, 2.0))).tolist() == [0.0, 0.0]
    nearer = hidden_share(seen((0.0, 20.0, 0.0, 4.0, 2.0), (0.0, 19.9, 0.0, 4.2, 2.0)))
    assert nearer.tolist() == [1.0, 0.0]


def test_only_what_is_there_at_the_same_stamp_hides() -> None:
    far, near = plate(30.0, -0.2, 0.2), plate(10.0, -0.3, 0.3)
    assert hidden_share(seen(near, far, near, far, t=(0.0, 1.0, 2.0, 2.0))).tolist() == [0.0, 0.0, 0.0, 1.0]
    assert hidden_share(seen(far, near, far, t=(0.0, 0.0, 1.0))).tolist() == [1.0, 0.0, 0.0]
    assert hidden_share(seen()).tolist() == []
