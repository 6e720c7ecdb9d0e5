"""Contact of boxes: when the first touch happens and with which impulse, against hand calculation."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.drive.contact import ContactDetector
from pytest_dvp.drive.world import World
from vehicle.messages import FloatArray, Surroundings


def rows(x: float, speed: float, y: float = 0.0, yaw: float = 0.0) -> FloatArray:
    """0.05 s of straight driving, sampled every 0.01 s, ending at (x, y)."""
    t = np.arange(6) * 0.01
    ahead = x + speed * (t - 0.05)
    zero = np.zeros(6)
    columns = (t, ahead, zero + y, zero, zero + yaw, zero + speed, zero + speed, zero, zero, zero, zero, zero)
    return np.column_stack(columns)  # TRACE_COLUMNS


def box(
    x: float, y: float = 0.0, yaw: float = 0.0, vx: float = 0.0, length: float = 4.0, width: float = 2.0
) -> FloatArray:
    return np.array([[x, y, 0.75, yaw, length, width, 1.5, vx, 0.0]])


def detector(**masses: float) -> ContactDetector:
    return ContactDetector(4.0, 2.0, 1.0, 1000.0, masses)


def test_a_gap_is_no_contact() -> None:
    # front at 1 + 2 = 3 m ahead of the reference point, the other's rear at 10 - 2 = 8 m
    assert detector().check(rows(4.99, 10.0), ["car"], box(10.0), box(10.0)) == []


def test_the_first_touch_is_found_between_two_ticks() -> None:
    # the front reaches x = 8 m when the reference point passes 5 m: 0.02 s before the end at 10 m/s
    (contact,) = detector().check(rows(5.205, 10.0), ["car"], box(10.0), box(10.0))
    assert contact.t == pytest.approx(0.03)
    assert contact.x == pytest.approx(8.0, abs=0.05)


def test_the_impulse_is_reduced_mass_times_closing_speed() -> None:
    # 1000 kg and 3000 kg: reduced mass 750 kg; 10 m/s against 4 m/s the same way
    (contact,) = detector(car=3000.0).check(rows(5.5, 10.0), ["car"], box(9.9, vx=4.0), box(10.1, vx=4.0))
    assert contact.impulse == pytest.approx(750.0 * 6.0)


def test_a_lasting_contact_is_reported_once() -> None:
    watch = detector()
    first = watch.check(rows(5.5, 10.0), ["car"], box(10.0), box(10.0))
    second = watch.check(rows(6.0, 10.0), ["car"], box(10.0), box(10.0))
    assert (len(first), len(second)) == (1, 0)


def test_a_second_hit_after_separation_is_a_new_contact() -> None:
    watch = detector()
    hits = [len(watch.check(rows(x, 1.0), ["car"], box(10.0), box(10.0))) for x in (5.5, -20.0, 5.5)]
    assert hits == [1, 0, 1]


def test_crossing_boxes_touch_although_no_corner_is_inside() -> None:
    # a long thin bar across the ego
    (contact,) = detector().check(
        rows(0.0, 0.0), ["bar"], box(1.0, length=0.2, width=20.0), box(1.0, length=0.2, width=20.0)
    )
    assert contact.name == "bar"


def test_diagonal_neighbours_do_not_touch_although_their_circles_do() -> None:
    assert detector().check(rows(0.0, 0.0), ["car"], box(1.0 + 4.1, 2.1), box(1.0 + 4.1, 2.1)) == []


def test_contact_is_as_sharp_far_from_the_map_origin() -> None:
    far = 4.0e6
    touching = detector().check(rows(far, 0.0), ["car"], box(far + 4.999), box(far + 4.999))
    apart = detector().check(rows(far, 0.0), ["car"], box(far + 5.001), box(far + 5.001))
    assert (len(touching), len(apart)) == (1, 0)


@pytest.mark.parametrize("yaw", [0.0, 0.7, 1.5707963, 3.0, -2.0])
def test_contact_does_not_depend_on_where_the_ego_heads(yaw: float) -> None:
    cos, sin = np.cos(yaw), np.sin(yaw)
    gap = [4.99, 5.01]  # centre distance along the heading: 1 + 2 + 2 touches
    found = [
        len(detector().check(rows(0.0, 0.0, yaw=yaw), ["car"], box(d * cos, d * sin, yaw), box(d * cos, d * sin, yaw)))
        for d in gap
    ]
    assert found == [1, 0]


def test_random_pairs_agree_with_clipping() -> None:
    # oracle: the boxes overlap if clipping one polygon by the other's four half planes leaves an area
    def corners(x: float, y: float, yaw: float, length: float, width: float) -> list[tuple[float, float]]:
        c, s = np.cos(yaw), np.sin(yaw)
        sides = ((1, 1), (-1, 1), (-1, -1), (1, -1))
        return [
            (x + c * i * length / 2 - s * j * width / 2, y + s * i * length / 2 + c * j * width / 2) for i, j in sides
        ]

    def clipped_area(subject: list[tuple[float, float]], clip: list[tuple[float, float]]) -> float:
        for (ax, ay), (bx, by) in zip(clip, clip[1:] + clip[:1], strict=True):
            inside = [(bx - ax) * (py - ay) - (by - ay) * (px - ax) for px, py in subject]
            out = []
            for i, (p, d) in enumerate(zip(subject, inside, strict=True)):
                q, e = subject[i - 1], inside[i - 1]
                if (d >= 0) != (e >= 0):
                    out.append((q[0] + (p[0] - q[0]) * e / (e - d), q[1] + (p[1] - q[1]) * e / (e - d)))
                if d >= 0:
                    out.append(p)
            subject = out
        return 0.5 * abs(sum(subject[i - 1][0] * p[1] - p[0] * subject[i - 1][1] for i, p in enumerate(subject)))

    generator = np.random.default_rng(7)
    for _ in range(300):
        yaw, x, y, other = generator.uniform((-3.1, -5, -5, -3.1), (3.1, 5, 5, 3.1))
        length, width = generator.uniform((0.3, 0.3), (6.0, 3.0))
        c, s = np.cos(yaw), np.sin(yaw)
        area = clipped_area(corners(c, s, yaw, 4.0, 2.0), corners(x, y, other, length, width))
        if 0.0 < area < 0.02:
            continue  # too near to touching for the solver's tolerance
        target = box(x, y, other, length=length, width=width)
        assert bool(detector().check(rows(0.0, 0.0, yaw=yaw), ["o"], target, target)) == (area > 0.0)


def test_who_is_put_elsewhere_touches_nobody_on_the_way() -> None:
    """From 9 m behind the ego to 20 m ahead of it: by a teleport, or, one tick later, as a missile."""
    entities = {name: SimpleNamespace(name=name, kind="vehicle", teleports=0) for name in ("Ego", "car")}
    car: Any = SimpleNamespace(length=4.0, width=2.0, center_x=1.0, mass=1000.0)
    storyboard: Any = SimpleNamespace(entities=entities)
    world = World(storyboard, "Ego", car, {})
    behind, ahead = (Surroundings(box(x), np.zeros(1, dtype=np.int64), ("car",)) for x in (-9.0, 20.0))
    assert world.contacts(rows(0.0, 0.0), behind, behind) == []
    entities["car"].teleports = 1
    assert world.contacts(rows(0.0, 0.0), behind, ahead) == []
    assert [contact.name for contact in world.contacts(rows(0.0, 0.0), behind, ahead)] == ["car"]


@pytest.mark.parametrize(("gap", "touch"), [(0.05, 0.01), (0.15, 0.01), (0.3, 0.02), (0.5, 0.03), (0.95, 0.05)])
def test_what_moves_is_where_it_was_at_each_row_of_the_tick(gap: float, touch: float) -> None:
    """At 20 m/s towards a standing ego it touches after gap/20 s, seen at the next row; rows begin 0.01 s into a tick.

    The ego's front is at 3 m, so that the other's middle begins at 5 m and the gap.
    """
    before, after = box(5.0 + gap, vx=-20.0), box(5.0 + gap - 20.0 * 0.05, vx=-20.0)
    (contact,) = detector().check(rows(0.0, 0.0)[1:], ["car"], before, after, 0.0)
    assert contact.t == pytest.approx(touch)
    here: Any = SimpleNamespace(active=False, teleports=0, name="car", kind="vehicle")
    storyboard: Any = SimpleNamespace(entities={"Ego": here, "car": here})
    car: Any = SimpleNamespace(length=4.0, width=2.0, center_x=1.0, mass=1000.0)
    world = World(storyboard, "Ego", car, {})
    world.look(0.0)
    world.look(0.05)
    old, new = (Surroundings(each, np.zeros(1, dtype=np.int64), ("car",)) for each in (before, after))
    assert [each.t for each in world.contacts(rows(0.0, 0.0)[1:], old, new)] == pytest.approx([touch])


def test_what_turns_has_turned_by_its_share_at_each_row() -> None:
    """A bar of 10 m sweeps by 0.2 rad in a tick; its end, 5 m away, comes down to the ego's side at its 0.1 rad."""
    side = 1.0 + 0.1 + 5.0 * np.sin(0.1)  # the bar is 0.2 m wide; its middle is 5 m ahead of the ego's
    before, after = (box(1.0 + 5.0, side, yaw, length=10.0, width=0.2) for yaw in (0.0, 0.2))
    (contact,) = detector().check(rows(0.0, 0.0), ["bar"], before, after)
    assert contact.t == pytest.approx(0.03)  # 0.1 rad is at 0.025 s, between two rows
