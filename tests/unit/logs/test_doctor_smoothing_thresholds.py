"""Which time constants are tried on a channel that comes late, and how much better than a delay a filter must be."""

from __future__ import annotations

import dataclasses
from math import atan, exp, pi, sin

import numpy as np
import pytest
from known_motion import STEP, motion, times

from pytest_dvp.doctor.smoothing import time_constant
from pytest_dvp.logs.log_contents import FloatArray

LEVELS = np.repeat(np.random.default_rng(6).normal(size=400), 50)  # a new level each second


def smoothed(signal: FloatArray, tau: float, step: float) -> FloatArray:
    """A signal behind a first-order low-pass."""
    keep, found = exp(-step / tau), [float(signal[0])]
    for value in signal[1:].tolist():
        found.append(keep * found[-1] + (1.0 - keep) * value)
    return np.array(found)


@pytest.mark.parametrize(
    ("tau", "told"), [(9.0, 5.0), (4.0, 4.0), (0.024, 0.03)], ids=["the longest", "a quarter shorter", "the shortest"]
)
def test_time_constants_from_three_hundredths_of_a_second_to_five_are_tried_a_quarter_apart(
    tau: float, told: float
) -> None:
    """The next one that is tried before 5 s is 4 s."""
    step = STEP if tau > 1.0 else 0.1 * STEP
    at = dataclasses.replace(motion(v=LEVELS), t=np.arange(len(LEVELS)) * step, step=step)
    assert time_constant(at, smoothed(LEVELS, tau, step), LEVELS, max(0.2 * tau, step)) == pytest.approx(told, 0.01)


@pytest.mark.parametrize(("noise", "told"), [(0.9, True), (1.1, False)])
def test_a_filter_leaves_half_of_what_a_delay_leaves(noise: float, told: bool) -> None:
    """Two sines behind a low-pass of 1.05 s, and a third one that has nothing to do with either. A filter explains all
    but the third. A delay of 0.4 s is too long for one of them and too short for the other, and leaves the squares of
    the sines of these angles besides. Half of that is left where the third one is as large."""
    t, tau = times(80.0 * pi), 1.05
    late, prompt, missed = np.zeros(len(t)), np.zeros(len(t)), 0.0
    for frequency in (0.5, 4.0):  # rad/s
        angle = atan(frequency * tau)
        late += np.cos(frequency * t)
        prompt += np.cos(frequency * t + angle) / np.cos(angle)
        missed += sin(angle - 0.4 * frequency) ** 2
    late += np.sqrt(noise * missed) * np.sin(9.0 * t)
    assert (time_constant(motion(v=t), late, prompt, 0.4) is not None) is told
