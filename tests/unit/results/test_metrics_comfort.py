"""Jerk and yaw rate against closed forms and scipy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from results_logs import log_of, relaxed, times
from scipy.signal import butter, sosfiltfilt

from pytest_dvp.logs.log import Log
from pytest_dvp.metrics import compute
from pytest_dvp.metrics._low_pass import PAD, low_pass


@relaxed
@given(seed=st.integers(0, 1000), cutoff=st.floats(0.2, 20.0), n=st.integers(200, 500))
def test_low_pass_is_the_butterworth_of_scipy(seed: int, cutoff: float, n: int) -> None:
    values = np.random.default_rng(seed).normal(size=n).cumsum()
    pad = min(n - 1, math.ceil(PAD / (cutoff * 0.01)))
    expected = sosfiltfilt(butter(2, cutoff, fs=100.0, output="sos"), values, padtype="odd", padlen=pad)
    assert low_pass(values, 0.01, cutoff) == pytest.approx(expected, abs=1e-9 * max(1.0, np.abs(values).max()))


@pytest.mark.parametrize("frequency", [0.2, 0.5, 1.0])
def test_jerk_of_a_sinusoid_is_damped_as_the_filter_says(frequency: float) -> None:
    """v = A sin(w t) has a jerk of A w^2; two passes of order 2 leave 1 / (1 + (f / f_c)^4)."""
    amplitude, omega = 2.0, 2.0 * math.pi * frequency
    log = log_of(60.0, columns={"v": amplitude * np.sin(omega * times(60.0))})
    expected = amplitude * omega**2 / (1.0 + frequency**4)
    series = compute("max_jerk", log, cutoff=1.0).series
    assert series is not None
    inner = np.abs(series.value[500:-500])  # away from the ends, where no filter knows the signal
    assert inner.max() == pytest.approx(expected, rel=5e-3)


def test_constant_acceleration_has_no_jerk() -> None:
    log = log_of(20.0, columns={"v": 1.5 * times(20.0)})
    assert compute("max_jerk", log).value == pytest.approx(0.0, abs=1e-6)


def test_sign_does_not_matter_and_the_time_is_that_of_the_worst_moment() -> None:
    t = times(20.0)
    # braking by 3 m/s^2 from 12 s on: the jerk peaks there, downwards
    log = log_of(20.0, columns={"v": 20.0 - 3.0 * np.clip(t - 12.0, 0.0, None)})
    result = compute("max_jerk", log)
    # A step of 3 m/s^2 through H(s) = 1 / (1 + (w/w_c)^4): peak of the impulse response w_c / (2 sqrt 2) * 3
    assert result.value == pytest.approx(3.0 * 2.0 * math.pi / (2.0 * math.sqrt(2.0)), rel=1e-2)
    assert result.t == pytest.approx(12.0, abs=0.02)


def test_filter_is_declared_and_other_cutoffs_are_shown() -> None:
    log = log_of(20.0, columns={"v": np.sin(times(20.0))})
    result = compute("max_jerk", log)
    assert result.note == "speed through a zero-phase Butterworth low pass of order 2, cut-off 1.0 Hz"
    assert list(result.extra) == ["at 0.5 Hz", "at 2 Hz", "at 5 Hz"]


def test_uneven_time_base_is_resampled() -> None:
    t = np.sort(np.concatenate([times(20.0), np.array([3.333, 7.777])]))
    uneven = Log({"t": t, "v": 2.0 * np.sin(t)})
    even = log_of(20.0, columns={"v": 2.0 * np.sin(times(20.0))})
    assert compute("max_jerk", uneven).value == pytest.approx(compute("max_jerk", even).value, rel=1e-3)


def test_gap_in_the_speed_makes_jerk_undefined() -> None:
    v = np.sin(times())
    v[300:310] = np.nan
    assert compute("max_jerk", log_of(columns={"v": v})).reason == "v was not measured throughout"


def test_cutoff_above_half_the_rate_is_undefined() -> None:
    result = compute("max_jerk", log_of(columns={"v": np.sin(times())}), cutoff=60.0)
    assert result.reason == "cut-off 60 Hz is not between 0 and 50 Hz, half the sampling rate"


def test_time_that_goes_back_makes_jerk_undefined() -> None:
    log = log_of(columns={"v": np.sin(times())})
    log.t[500:] -= 2.0
    assert compute("max_jerk", log).reason == "the time of the log does not increase"


def test_yaw_rate_of_a_circle() -> None:
    speed, radius = 5.0, 12.5
    result = compute("max_yaw_rate", log_of(columns={"v": speed, "yaw_rate": -speed / radius}))
    assert result.value == pytest.approx(0.4)


def test_spike_of_the_sensor_shows_in_the_yaw_rate() -> None:
    rate = np.zeros(len(times()))
    rate[742] = 1.6
    result = compute("max_yaw_rate", log_of(columns={"yaw_rate": rate}))
    assert (result.value, result.t) == (1.6, pytest.approx(7.42))


def test_yaw_rate_that_was_never_measured_is_undefined() -> None:
    result = compute("max_yaw_rate", log_of(columns={"yaw_rate": np.nan}))
    assert (result.value, result.valid) == (None, False)
