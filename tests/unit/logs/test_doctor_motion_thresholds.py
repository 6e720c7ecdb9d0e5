"""Over how long a time, and at how many points, the motion of a log is told: each number just short of it and just past
it, by what is found or not found in a log for that reason."""

from __future__ import annotations

from math import degrees

import numpy as np
import pytest
from known_motion import STEP, findings, motion, rate_and_integral, times, way

from pytest_dvp.doctor.redundant_motion import motion_of, rows_between
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

SPEED = 10.0  # m/s


def left_of_a_sine(window: float, period: float) -> float:
    """Share of its amplitude that a mean over a window leaves, both in s."""
    return float(np.sinc(window / period))


@pytest.mark.parametrize(("lateral", "codes"), [(57.0, []), (63.0, ["log.implausible_range"])])
def test_a_gyro_is_read_in_means_over_two_fifths_of_a_second(lateral: float, codes: list[str]) -> None:
    """It swings once a second, and what is left of it decides whether any vehicle turns as hard as that, 60 m/s^2. A
    tenth of the time a sine is above sin(81 degrees) of its amplitude."""
    t = times(60.0)
    amplitude = lateral / SPEED / left_of_a_sine(0.4, 1.0) / np.sin(0.45 * np.pi)
    swing = {"t": t, "v": np.full(len(t), SPEED), "yaw_rate": amplitude * np.sin(2.0 * np.pi * t)}
    assert [each.code for each in findings(swing, "log.implausible_range")] == codes


@pytest.mark.parametrize(("share", "seen"), [(0.95, 1), (1.05, 0)])
def test_the_path_turns_between_two_halves_of_eight_tenths_of_a_second(share: float, seen: int) -> None:
    """A gyro in degrees is told as such if it differs from the path by no more than two and a half times else. The car
    weaves with a period of 1.5 s: each half is a mean of the direction over 0.4 s, and so is the turn from one to the
    other, so that the path loses twice what a mean of the gyro over 0.4 s loses once."""
    t, period = times(60.0), 1.5
    v, angle = np.full(len(t), SPEED), 2.0 * np.pi * t / period
    turn, course = 0.03 * np.cos(angle), 0.03 * period / (2.0 * np.pi) * np.sin(angle)
    gyro = degrees(1.0) * share * 2.5 * left_of_a_sine(0.4, period) * turn
    found = findings({"t": t, "v": v, **way(t, v, course), "yaw_rate": gyro}, "log.implausible_range")
    assert len(found) == seen


def for_a_while(moving: float, rows_per_second: float) -> tuple[FloatArray, FloatArray]:
    """Stamps, and the speed of a car that stands but for a while: its means over 0.4 s move for so many seconds."""
    t = np.arange(round(20.0 * rows_per_second)) / rows_per_second
    return t, np.where((t >= 5.0) & (t < 5.0 + moving - 0.4), SPEED, 0.0)


@pytest.mark.parametrize(("moving", "elements"), [(0.9, []), (1.1, ["column speed_cmd"])])
def test_the_motion_is_told_every_fiftieth_of_a_second_at_most(moving: float, elements: list[str]) -> None:
    """The log has 200 rows a second. The unit of a wish is judged from 50 points on at which the car moves: 1 s."""
    t, v = for_a_while(moving, 200.0)
    found = findings({"t": t, "v": v, "speed_cmd": 3.6 * v}, "log.unit_suspect", "log.speed_not_reached")
    assert [each.element for each in found] == elements


@pytest.mark.parametrize(("moving", "elements"), [(1.8, []), (2.2, ["column yaw_rate"])])
def test_scales_are_judged_by_a_point_each_tenth_of_a_second(moving: float, elements: list[str]) -> None:
    """A gyro in degrees is told from 20 points on at which the car moves: 2 s."""
    t, v = for_a_while(moving, 50.0)
    rate, _ = rate_and_integral(0.2, 1.0, deviation=0.05)
    found = findings({"t": t, "v": v, "yaw_rate": degrees(1.0) * rate(t), "ay": v * rate(t)}, "log.implausible_range")
    assert [each.element for each in found] == elements


@pytest.mark.parametrize(("rows", "every"), [(100_000, 5), (119_000, 6)])
def test_scales_are_judged_by_twenty_thousand_points_at_most(rows: int, every: int) -> None:
    """Of rows each 0.02 s every fifth one is 0.1 s after the last; 20,000 of these are half an hour."""
    assert rows_between(motion(v=np.zeros(rows))) == every


@pytest.mark.parametrize("seconds", [3_800.0, 4_200.0])
def test_a_motion_has_two_hundred_thousand_points_at_most(seconds: float) -> None:
    """At 0.02 s these are 4,000 s; a longer drive has fewer a second. This one has a long break."""
    t = np.concatenate([times(10.0), seconds + STEP * np.arange(-9, 1)])
    found = motion_of(Log({"t": t, "v": np.ones(len(t))}))
    assert found is not None
    assert found.step == pytest.approx(STEP * max(1.0, seconds / 4_000.0))
