"""Manoeuvres: speeds, durations and shapes of what a driver is asked for."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.manoeuvres.catalogue import MANOEUVRES
from pytest_dvp.gap.manoeuvres.circle_manoeuvres import HELD, SHARES, circles_both, circles_left, tight_circles
from pytest_dvp.gap.manoeuvres.driving_limits import Envelope
from pytest_dvp.gap.manoeuvres.pedal_manoeuvres import (
    both_directions,
    brake_ramps,
    brake_steps,
    city,
    coast_down,
    full_throttle,
    held_steps,
    lift_offs,
    pedal_steps,
    small_pedal,
    standing_starts,
)
from pytest_dvp.gap.manoeuvres.steering_manoeuvres import (
    _doublet,
    _dwell,
    _sweep,
    _triangle,
    _wave,
    full_lock,
    growing_steps,
    sine_sweep,
    sine_with_dwell,
    slalom,
    slow_ramp,
    small_steer,
    small_steps,
    step_steer,
)
from tests.unit.gap.drivers import ENVELOPE, listened


def test_speeds_and_durations_of_the_pedal_tests() -> None:
    d = listened(coast_down)
    fast, half = d.fitting(2.5), d.fitting(5.0, share=0.5)
    assert [(t.speed, t.seconds, t.end) for t in d.wanted] == [(fast, 2.5, None)] * 2 + [(half, 5.0, None)] * 2 + [
        (2.5, 6.0, 0.15)
    ]
    assert all(t.pedal is not None and t.pedal(1.0) == 0.0 for t in d.wanted)
    d = listened(full_throttle)
    assert [t.seconds for t in d.wanted] == [1.5, 12.0, 2.0] * 2
    assert {t.speed for t in d.wanted} == {0.0}
    assert [t.pedal(0.5) for t in d.wanted] == pytest.approx([-1.0, d.push, -1.0, -1.0, 0.5 * d.push, -1.0])  # type: ignore[misc]
    d = listened(standing_starts)
    assert [(t.speed, t.seconds) for t in d.wanted] == [(0.0, 3.0), (0.0, 2.5), (d.slow, 4.0)] * 3
    assert [t.pedal(0.5) for t in d.wanted[1::3]] == pytest.approx([0.25 * d.push, 0.5 * d.push, d.push])  # type: ignore[misc]
    assert all(t.pedal(0.5) == -1.0 for t in d.wanted[::3])  # type: ignore[misc]
    assert all(t.pedal(0.5) == pytest.approx(-0.5 * d.brake) and t.end == 0.1 for t in d.wanted[2::3])  # type: ignore[misc]
    d = listened(both_directions)
    assert [(t.speed, t.seconds, t.pedal) for t in d.wanted] == [
        (d.fitting(3.5, share=s), 3.5, None) for s in (0.35, 0.35, 1.0, 1.0)
    ]
    d = listened(lift_offs)
    assert [t.speed for t in d.wanted] == [d.fitting(3.5, share=s) for s in (0.3, 0.5, 0.7, 0.85)]
    assert [t.pedal(0.99) for t in d.wanted] == pytest.approx([0.5 * d.push] * 4)  # type: ignore[misc]
    assert [t.pedal(1.0) for t in d.wanted] == [0.0] * 4  # type: ignore[misc]
    assert {t.seconds for t in d.wanted} == {3.5}


def test_brake_steps_grow_to_the_hardest_and_are_released_once() -> None:
    d = listened(brake_steps)
    assert [(t.speed, t.seconds, t.end) for t in d.wanted] == [(d.fitting(2.5, share=0.9), 3.0, 0.5)] * 4
    for test, size in zip(d.wanted, (0.25, 0.5, 0.75, 1.0), strict=True):
        assert test.pedal is not None
        assert [test.pedal(tau) for tau in (0.0, 0.69, 0.7, 1.2, 1.21)] == pytest.approx(
            [-size * d.brake, -size * d.brake, 0.0, 0.0, -size * d.brake]
        )
    d = listened(brake_ramps)
    assert [(t.speed, t.seconds, t.end) for t in d.wanted] == [(d.fitting(3.0, share=0.9), 5.0, 0.15)] * 2
    for test, seconds in zip(d.wanted, (3.0, 1.0), strict=True):
        assert test.pedal is not None
        assert [test.pedal(tau) for tau in (0.0, 0.5, 5.0)] == pytest.approx([0.0, -d.brake * 0.5 / seconds, -d.brake])


def test_pedal_steps_are_equal_to_both_sides() -> None:
    for manoeuvre, speed, seconds, hold, sizes in (
        (pedal_steps, 0.45, 6.0, 1.0, (0.3, 0.6, 1.0)), (held_steps, 0.4, 8.0, 2.0, (0.5, 1.0)),
    ):  # fmt: skip
        d = listened(manoeuvre)
        assert [(t.speed, t.seconds) for t in d.wanted] == [(speed * d.top, seconds)] * len(sizes)
        for test, size in zip(d.wanted, sizes, strict=True):
            assert test.pedal is not None
            signs = [test.pedal((k + 0.5) * hold) / (size * d.push) for k in range(5)]
            assert signs == pytest.approx([1.0, 0.0, -1.0, 0.0, 1.0])
    d = listened(small_pedal)
    assert [t.pedal(0.5) for t in d.wanted] == pytest.approx([0.08, 0.16, 0.3, 0.5])  # type: ignore[misc]
    assert {(t.speed, t.seconds) for t in d.wanted} == {(min(5.0, d.fitting(6.0)), 6.0)}


def test_a_drive_about_town_is_gentle() -> None:
    d = listened(city)
    v = min(7.0, d.fitting(5.0))
    assert [(t.speed, t.seconds) for t in d.wanted] == [(v, 5.0), (v, 3.0), (0.5 * v, 4.0)]
    swerve = d.wanted[0].steer
    assert swerve is not None
    assert swerve(1.25) == pytest.approx(d.angle(v, 0.2 * d.lateral))
    assert swerve(2.5) == pytest.approx(0.0, abs=1e-12)
    wide = listened(city, envelope=Envelope(max_speed=40.0, length=2000.0))
    assert wide.wanted[0].speed == 7.0  # 25 km/h, however much room there is
    narrow = listened(city, envelope=Envelope(max_speed=40.0, length=70.0))
    assert narrow.wanted[0].speed == narrow.fitting(5.0) < min(7.0, narrow.fitting(4.0))


def test_shapes_of_the_steering() -> None:
    step = _doublet(0.1, 1.3)
    assert [step(t) for t in (0.0, 1.29, 1.3, 2.59, 2.6)] == [0.1, 0.1, -0.1, -0.1, 0.0]
    wave = _wave(0.1, 0.5)
    assert [wave(t) for t in (0.0, 0.5, 1.0, 2.0)] == pytest.approx([0.1, 0.0, -0.1, 0.1], abs=1e-12)
    sweep = _sweep(0.1, 0.4, 2.5, 6.0)
    phase = 0.4 * 3.0 + 0.5 * 2.1 / 6.0 * 9.0
    assert sweep(3.0) == pytest.approx(0.1 * math.cos(2.0 * math.pi * phase))
    assert sweep(0.0) == 0.1
    triangle = _triangle(0.1, 4.0)
    assert [triangle(t) for t in (0.0, 0.5, 1.0, 2.0, 2.5, 3.0)] == pytest.approx(
        [0.0, 0.05, 0.1, 0.0, -0.05, -0.1], abs=1e-12
    )
    dwell = _dwell(0.1)
    peak = 0.75 / 0.7
    assert dwell(0.25 / 0.7) == pytest.approx(0.1)
    assert [dwell(t / 0.7) for t in (0.125, 0.625)] == pytest.approx([0.1 / math.sqrt(2.0), -0.1 / math.sqrt(2.0)])
    assert [dwell(peak + t) for t in (-1e-9, 0.0, 0.25, 0.5)] == pytest.approx([-0.1] * 4)
    assert dwell(peak + 0.5 + 0.125 / 0.7) == pytest.approx(-0.1 * math.sin(math.pi / 4.0))
    assert dwell(1.0 / 0.7 + 0.5) == 0.0


def test_speeds_and_sizes_of_the_steering_tests() -> None:
    d = listened(step_steer)
    v = d.fitting(4.0)
    assert [t.speed for t in d.wanted] == [3.0, 0.55 * d.top, v, v]
    assert [t.steer(0.5) for t in d.wanted] == pytest.approx(  # type: ignore[misc]
        [d.angle(s, 0.6 * d.lateral) * side for s, side in ((3.0, 1), (0.55 * d.top, 1), (v, 1), (v, -1))]
    )
    assert {t.seconds for t in d.wanted} == {4.0}
    d = listened(growing_steps)
    assert [t.steer(0.5) for t in d.wanted] == pytest.approx(  # type: ignore[misc]
        [min(s, d.angle(3.0, 0.6 * d.lateral)) * side for s in (0.05, 0.1, 0.2, 0.35) for side in (1.0, -1.0)]
    )
    assert {(t.speed, t.seconds) for t in d.wanted} == {(3.0, 3.2)}
    d = listened(full_lock)
    assert {t.speed for t in d.wanted} == {min(2.0, math.sqrt(0.8 * d.lateral * 2.5 / d.lock))}
    for test, side in zip(d.wanted, (1.0, -1.0), strict=True):
        assert test.steer is not None
        shown = [test.steer(tau) / d.lock * side for tau in (0.0, 1.25, 2.5, 4.0, 6.0, 7.0, 8.0, 9.0)]
        assert shown == pytest.approx([0.0, 0.5, 1.0, 1.0, 1.0, 0.5, 0.0, 0.0])
    d = listened(slow_ramp)
    for test, (share, side) in zip(d.wanted, [(s, k) for s in (0.6, 1.0) for k in (1.0, -1.0)], strict=True):
        v = d.fitting(6.0, share=share)
        assert (test.speed, test.seconds) == (v, 6.0)
        assert test.steer is not None
        assert test.steer(1.4) == pytest.approx(side * d.angle(v, 0.95 * d.lateral))
    d = listened(sine_sweep)
    assert [t.speed for t in d.wanted] == [d.fitting(6.0, share=s) for s in (0.6, 0.6, 1.0, 1.0)]
    d = listened(slalom)
    assert [(t.speed, t.seconds) for t in d.wanted] == [(d.fitting(s), s) for s in (5.0, 5.0, 4.0, 4.0)]
    assert [t.steer(0.0) for t in d.wanted] == pytest.approx(
        [d.angle(d.fitting(s), 0.8 * d.lateral) for s in (5.0, 5.0, 4.0, 4.0)]
    )  # type: ignore[misc]
    assert [t.steer(h / 4.0) for t, h in zip(d.wanted, (2.0, 2.0, 1.0, 1.0), strict=True)] == pytest.approx(
        [0.0] * 4, abs=1e-12
    )  # type: ignore[misc]
    d = listened(small_steer)
    assert [t.steer(1.25 / 4.0) for t in d.wanted] == pytest.approx([0.006, 0.012, 0.025, 0.05])  # type: ignore[misc]
    d = listened(small_steps)
    for test, size in zip(d.wanted, (0.004, 0.01, 0.02, 0.04), strict=True):
        assert test.steer is not None
        stairs = [test.steer(0.8 * k + 0.4) / size for k in range(9)]
        assert stairs == pytest.approx([1.0, 2.0, 1.0, 0.0, -1.0, -2.0, -1.0, 0.0, 0.0])


def test_circles_grow_in_speed_by_shares_of_the_lateral_acceleration() -> None:
    d = listened(circles_left, round_about=True)
    radius = 0.5 * 60.0 - 1.6 * 4.0
    circles = [note for note in d.notes if note[0] == "circle"]
    assert d.notes[0] == ("stand", 1.0)
    assert d.notes[-1] == ("halt",)
    assert circles == [
        (
            "circle",
            min(math.sqrt(share * d.lateral * radius), d.top),
            pytest.approx(math.atan(2.5 / radius)),
            math.inf,
            HELD,
        )
        for share in SHARES
    ]
    assert SHARES == (0.08, 0.3, 0.6, 0.9)


def test_circles_to_both_sides_leave_room_for_the_turn() -> None:
    d = listened(circles_both, round_about=True)
    radius = max(min(0.5 * (60.0 - 2.0 * d.radius - 12.0), 50.0 - 8.0), d.radius)
    names = [note[0] for note in d.notes]
    assert names == ["stand", *["circle"] * 4, "close", "other side", *["circle"] * 4, "halt"]
    assert d.notes[5][1] == pytest.approx(math.atan(2.5 / radius))
    angles = [note[2] for note in d.notes if note[0] == "circle"]
    assert angles == pytest.approx([math.atan(2.5 / radius)] * 4 + [-math.atan(2.5 / radius)] * 4)


def test_tight_circles_make_a_figure_of_eight_at_walking_speed() -> None:
    d = listened(tight_circles)
    radius = 1.1 * 2.5 / math.tan(0.9 * d.lock)
    v = min(2.0, math.sqrt(0.7 * d.lateral * radius))
    assert d.notes[:3] == [("stand", 1.0), ("reach", d.slow), ("other side",)]
    assert [note[1:4] for note in d.notes[3:5]] == [
        (v, pytest.approx(s * math.atan(2.5 / radius)), 1.0) for s in (1.0, -1.0)
    ]
    assert len({m.name for m in MANOEUVRES}) == len(MANOEUVRES)


WHEN = tuple(0.05 * k + 0.01 for k in range(180))


def same(shown: Any, expected: Any, seconds: float) -> None:
    """Two shapes at all times of a test."""
    times = [tau for tau in WHEN if tau < seconds]
    assert [shown(tau) for tau in times] == pytest.approx([expected(tau) for tau in times], abs=1e-9)


def step(size: float, hold: float) -> Any:
    return lambda tau: size if tau < hold else -size if tau < 2.0 * hold else 0.0


def test_growing_steps_end_at_the_angle_that_is_allowed_at_their_speed() -> None:
    """Of 1 m/s^2 a driver uses 0.85 m/s^2, a step of it 0.6: 2.5 m * 0.51 m/s^2 / (3 m/s)^2 = 0.1417 rad."""
    d = listened(growing_steps, envelope=dataclasses.replace(ENVELOPE, max_lateral=1.0))
    sizes = [t.steer(0.5) for t in d.wanted[::2]]  # type: ignore[misc]
    assert sizes == pytest.approx([0.05, 0.1, 0.1417, 0.1417], abs=1e-4)


def test_each_steering_test_has_its_shape_to_its_end() -> None:
    d = listened(step_steer)
    v = d.fitting(4.0)
    for test, (speed, side) in zip(d.wanted, ((3.0, 1.0), (0.55 * d.top, 1.0), (v, 1.0), (v, -1.0)), strict=True):
        same(test.steer, step(side * d.angle(speed, 0.6 * d.lateral), 1.3), test.seconds)
    d = listened(growing_steps)
    for test, (size, side) in zip(d.wanted, [(s, k) for s in (0.05, 0.1, 0.2, 0.35) for k in (1.0, -1.0)], strict=True):
        same(test.steer, step(side * min(size, d.angle(3.0, 0.6 * d.lateral)), 1.0), 3.2)
    d = listened(full_lock)
    assert {test.seconds for test in d.wanted} == {8.0}
    d = listened(slow_ramp)
    for test, (share, side) in zip(d.wanted, [(s, k) for s in (0.6, 1.0) for k in (1.0, -1.0)], strict=True):
        size = side * d.angle(d.fitting(6.0, share=share), 0.95 * d.lateral)
        corners = ((0.0, 0.0), (1.4, size), (4.2, -size), (6.0, -size + 1.8 * size / 1.4))
        same(test.steer, lambda tau, c=corners: np.interp(tau, *zip(*c, strict=True)), 6.0)
    d = listened(sine_sweep)
    assert {test.seconds for test in d.wanted} == {6.0}
    for test in d.wanted:
        size = d.angle(test.speed, 0.6 * d.lateral)
        same(test.steer, lambda t, s=size: s * math.cos(2.0 * math.pi * (0.4 * t + (2.5 - 0.4) * t * t / 12.0)), 6.0)
    d = listened(sine_with_dwell)
    assert {(test.speed, test.seconds) for test in d.wanted} == {(d.fitting(3.5), 3.5)}
    for test, (share, side) in zip(d.wanted, [(s, k) for s in (0.4, 0.85) for k in (1.0, -1.0)], strict=True):
        same(test.steer, _dwell(side * d.angle(d.fitting(3.5), share * d.lateral)), 3.5)
    d = listened(slalom)
    for test, hertz in zip(d.wanted, (0.5, 0.5, 1.0, 1.0), strict=True):
        size = d.angle(test.speed, 0.8 * d.lateral)
        same(test.steer, lambda t, s=size, h=hertz: s * math.cos(2.0 * math.pi * h * t), test.seconds)
    d = listened(small_steer)
    assert {(test.speed, test.seconds) for test in d.wanted} == {(min(8.0, d.fitting(5.0)), 5.0)}
    for test, size in zip(d.wanted, (0.006, 0.012, 0.025, 0.05), strict=True):
        same(test.steer, _triangle(size, 1.25), 5.0)
    d = listened(small_steps)
    assert {(test.speed, test.seconds) for test in d.wanted} == {(min(7.0, d.fitting(6.5)), 6.5)}
    assert all(test.pedal is None for test in d.wanted)


def test_on_long_ground_small_steering_is_at_walking_pace() -> None:
    wide = Envelope(max_speed=20.0, length=2000.0, width=60.0)
    assert {t.speed for t in listened(small_steer, envelope=wide).wanted} == {8.0}
    assert {t.speed for t in listened(small_steps, envelope=wide).wanted} == {7.0}
    assert {t.speed for t in listened(small_pedal, envelope=wide).wanted} == {5.0}
    assert listened(full_lock, envelope=wide).wanted[0].speed == 2.0
    assert listened(city, envelope=wide).wanted[0].speed == 7.0


@pytest.mark.parametrize(
    ("manoeuvre", "seconds", "most"),
    [(small_steps, 6.5, 7.0), (small_steer, 5.0, 8.0), (small_pedal, 6.0, 5.0), (city, 5.0, 7.0)],
)
def test_on_short_ground_small_steps_are_as_fast_as_there_is_room(manoeuvre: Any, seconds: float, most: float) -> None:
    d = listened(manoeuvre, envelope=Envelope(max_speed=20.0, length=56.0, width=20.0))
    assert d.wanted[0].speed == d.fitting(seconds) < most
    assert d.fitting(seconds + 1.0) < d.fitting(seconds) < d.fitting(seconds - 1.0)


def test_each_pedal_test_has_its_shape_to_its_end() -> None:
    for manoeuvre, hold, sizes in ((pedal_steps, 1.0, (0.3, 0.6, 1.0)), (held_steps, 2.0, (0.5, 1.0))):
        d = listened(manoeuvre)
        for test, size in zip(d.wanted, sizes, strict=True):
            signs = (1.0, 0.0, -1.0, 0.0) * 3
            same(test.pedal, lambda tau, a=size * d.push, h=hold, s=signs: a * s[int(tau / h)], test.seconds)
    d = listened(small_pedal)
    for test, size in zip(d.wanted, (0.08, 0.16, 0.3, 0.5), strict=True):
        same(test.pedal, lambda tau, a=size: a * (1.0, 0.0, -1.0, 0.0, 1.0, 0.0)[int(tau)], 6.0)
    d = listened(brake_ramps)
    for test, seconds in zip(d.wanted, (3.0, 1.0), strict=True):
        same(test.pedal, lambda tau, s=seconds: -d.brake * min(tau / s, 1.0), 5.0)
    d = listened(lift_offs)
    for test in d.wanted:
        same(test.pedal, lambda tau: 0.5 * d.push if tau < 1.0 else 0.0, 3.5)
    d = listened(city)
    swerve = d.wanted[0]
    same(swerve.steer, lambda t: d.angle(swerve.speed, 0.2 * d.lateral) * math.sin(0.4 * math.pi * t), 5.0)
    assert [t.steer for t in d.wanted[1:]] == [None, None]
