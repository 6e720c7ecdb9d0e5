"""Jerk from stamps that are not even, against the jerk of a sine: a filter needs an even time base."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.metrics import compute
from pytest_dvp.metrics._even_time import uniform

AMPLITUDE, FREQUENCY, CUTOFF = 1.5, 0.2, 1.0  # m/s, Hz, Hz
OMEGA = 2.0 * math.pi * FREQUENCY
JERK = AMPLITUDE * OMEGA**2 / (1.0 + (FREQUENCY / CUTOFF) ** 4)
"""A speed A sin(w t) has a jerk of A w^2; two passes of a Butterworth filter of order 2 leave 1 / (1 + (f/f_c)^4)."""


def alternating(short: float, long: float, duration: float = 60.0) -> FloatArray:
    """Stamps [s] that are `short` and `long` apart in turn, the first ones `short`."""
    steps = np.tile((short, long), round(duration / (short + long)))
    return np.concatenate(([0.0], np.cumsum(steps)))


def jittered() -> FloatArray:
    stamps = np.arange(6001) * 0.01
    return stamps + np.random.default_rng(2).uniform(-0.004, 0.004, len(stamps))


def with_a_gap() -> FloatArray:
    """100 Hz, 2 s without a sample from 30 s on."""
    stamps = np.arange(6001) * 0.01
    return stamps[(stamps < 30.0) | (stamps > 32.0)]


@pytest.mark.parametrize(
    "stamps",
    [alternating(0.002, 0.018), alternating(0.018, 0.002), jittered(), np.arange(6001) * 0.01],
    ids=["short step first", "long step first", "jitter", "even"],
)
def test_jerk_does_not_depend_on_when_the_samples_came(stamps: FloatArray) -> None:
    found = compute("max_jerk", Log({"t": stamps, "v": AMPLITUDE * np.sin(OMEGA * stamps)}), cutoff=CUTOFF)
    assert found.series is not None
    inner = (found.series.t > 5.0) & (found.series.t < 55.0)  # away from the ends, where no filter knows the signal
    assert np.abs(found.series.value[inner]).max() == pytest.approx(JERK, rel=0.01)
    assert found.value == pytest.approx(JERK, rel=0.15)


def test_the_even_base_has_the_rate_of_most_steps_and_the_ends_of_the_log() -> None:
    """Rows lost here and there make the rate no coarser: 60 s at 100 Hz are 6001 samples, not the 5701 that came."""
    stamps = np.delete(np.arange(6001) * 0.01, np.s_[10:6000:20])
    t, v = uniform(Log({"t": stamps, "v": 3.0 * stamps}), "v")
    assert t == pytest.approx(np.arange(6001) * 0.01, abs=1e-9)
    assert v == pytest.approx(3.0 * t, abs=1e-9)


def test_a_hole_of_seconds_is_not_bridged() -> None:
    stamps = with_a_gap()
    assert "a hole of 2.0 s from t=29.99 s on" in compute("max_jerk", Log({"t": stamps, "v": np.sin(stamps)})).reason


def test_the_step_of_the_even_base_is_the_same_throughout() -> None:
    t, _ = uniform(Log({"t": jittered(), "v": jittered()}), "v")
    assert np.diff(t) == pytest.approx(float(t[1] - t[0]), rel=1e-6)


@pytest.mark.parametrize(("jitter", "kept"), [(0.9e-3, True), (2.1e-3, False)])
def test_a_thousandth_of_a_step_is_what_clocks_differ_by(jitter: float, kept: bool) -> None:
    """Steps that differ from their mean by less than 0.1 % are left as they were logged; more is resampled."""
    stamps = alternating(0.01 * (1.0 - jitter), 0.01 * (1.0 + jitter))
    t, v = uniform(Log({"t": stamps, "v": 3.0 * stamps}), "v")
    assert np.array_equal(t, stamps) is kept
    assert v == pytest.approx(3.0 * t, abs=1e-9)


def test_four_samples_are_the_fewest() -> None:
    t = np.array([0.0, 0.1, 0.3, 0.4])
    assert len(uniform(Log({"t": t, "v": t}), "v")[0]) == 5  # the median step is 0.1 s
    assert compute("max_jerk", Log({"t": t[:3], "v": t[:3]})).reason == "too few samples"


def test_stamps_that_stand_still_have_no_jerk() -> None:
    t = np.arange(100) * 0.01
    t[50] = t[49]
    assert compute("max_jerk", Log({"t": t, "v": t})).reason == "the time of the log does not increase"
