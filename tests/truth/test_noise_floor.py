"""The noise of a signal against closed forms: what a filter, a quantiser and a smooth motion leave is known on paper.

Expected values come from the autocorrelation of the noise and from trigonometry, never from the code.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from pytest_dvp.gap.compare.compare import BEST_SENSOR_SIGMA, noise_floor
from pytest_dvp.gap.compare.noise_floor import sigma
from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.logs.log_contents import FloatArray

STEP = 0.02  # s
AMPLITUDE, OMEGA = 3.0, 0.7  # of a slow motion, in rad/s
T = np.arange(10_000) * STEP
MOTION = AMPLITUDE * np.sin(OMEGA * T)
BEND = 8.0 * AMPLITUDE * np.sin(OMEGA * 0.5 / 2.0) ** 2 * np.cos(0.01 * np.pi)
"""How far a sine leaves a straight line over two half seconds, y(t+1) - 2 y(t+0.5) + y(t), is a sine of amplitude
4 A sin^2(w 0.5 / 2); between its 1st and 99th percentile lie 2 cos(0.01 pi) of its amplitudes."""


def white(size: int, level: float = 1.0) -> FloatArray:
    return level * np.random.default_rng(3).normal(size=size)


def twice_filtered(pole: float, size: int = 30_000) -> FloatArray:
    """White noise through two equal low passes of first order, of standard deviation 1."""
    variance = (1.0 + pole**2) / (1.0 - pole**2) ** 3
    return np.asarray(lfilter([1.0], [1.0, -2.0 * pole, pole**2], white(size))) / variance**0.5


def level_at(stride: int, pole: float) -> tuple[float, float]:
    """Standard deviation that third differences over `stride` samples of that noise stand for (those of white noise
    have sqrt(20) of it), and the correlation of neighbouring ones.

    Autocorrelation of the noise: pole^n (1 + n (1 - pole^2) / (1 + pole^2)). A third difference is the noise weighted
    by 1, -3, 3, -1, so its own covariance has the autocorrelation of these weights: -1, 6, -15, 20, -15, 6, -1.
    """

    def noise(n: int) -> float:
        return float(pole**n * (1.0 + n * (1.0 - pole**2) / (1.0 + pole**2)))

    weights = (20, -15, 6, -1)
    own, next_one = (sum(weights[abs(j)] * noise(abs(shift - j) * stride) for j in range(-3, 4)) for shift in (0, 1))
    return float(np.sqrt(own / 20.0)), next_one / own


@pytest.mark.parametrize(("pole", "stride"), [(0.3, 1), (0.4, 1), (0.5, 2), (0.6, 3), (0.75, 6), (0.8, None)])
def test_noise_of_a_filter_is_read_at_the_first_stride_at_which_it_looks_white(pole: float, stride: int | None) -> None:
    """At 50 Hz strides of 1, 2, 3, 4 and 6 samples are within 0.12 s; white is a correlation of -0.6 or less (-0.75
    for white noise). Noise that stays smooth within 0.12 s is read at one sample: longer ones would take the motion
    of a car for it."""
    found = sigma(np.arange(30_000) * STEP, twice_filtered(pole))
    looks_white = [k for k in (1, 2, 3, 4, 6) if level_at(k, pole)[1] <= -0.6]
    assert looks_white[:1] == ([] if stride is None else [stride])
    assert found == pytest.approx(level_at(stride or 1, pole)[0], rel=0.04)


def test_white_noise_is_its_standard_deviation() -> None:
    assert sigma(T, white(len(T), 0.2)) == pytest.approx(0.2, rel=0.03)


def test_events_among_the_noise_count_as_little_as_a_median_lets_them() -> None:
    """A shock a second, 30 times the noise, spoils 4 of 50 differences: the median of the rest moves by less than 10 %,
    a mean would by a factor of 6; and the noise is still seen to be white, for shocks are cut at 2.5 sigma."""
    y = white(len(T), 0.2)
    y[::50] += 6.0 * np.sign(white(len(y[::50])))
    assert sigma(T, MOTION + y) == pytest.approx(0.2, rel=0.12)


def test_a_few_smooth_events_do_not_make_white_noise_look_filtered() -> None:
    """Two bumps of half a second, 20,000 times the noise: 1 % of all differences are large and smooth."""
    at = np.arange(len(T))
    bumps = sum(np.exp(-0.5 * ((at - centre) / 5.0) ** 2) for centre in (3000, 7000))
    assert sigma(T, 20.0 * bumps + white(len(T), 1e-3)) == pytest.approx(1e-3, rel=0.05)


def test_a_smooth_motion_gets_half_a_percent_of_its_bend() -> None:
    assert sigma(T, MOTION) == pytest.approx(0.005 * BEND, rel=1e-3)


def test_white_noise_far_below_the_motion_gets_a_fiftieth_of_a_percent_of_its_bend() -> None:
    """The noise is a tenth of that floor; the differences of the motion itself, A (w h)^3, are less still."""
    y = MOTION + white(len(T), 1.5e-5)
    assert sigma(T, y) == pytest.approx(0.0002 * BEND, rel=0.01)
    assert sigma(T, y, filtered=True) == pytest.approx(0.005 * BEND, rel=0.01)


@pytest.mark.parametrize("window", [4, 6, 10, 20, 32])
def test_a_moving_mean_is_a_filter_though_its_differences_look_white(window: int) -> None:
    """A mean over `window` samples changes by (n[i] - n[i - window]) / window, whose differences are white, but come
    back with the other sign `window` samples later."""
    noise = np.convolve(white(len(T) + window - 1, 1e-3), np.ones(window) / window, mode="valid")
    assert sigma(T, MOTION + noise) == pytest.approx(0.005 * BEND, rel=0.02)


@pytest.mark.parametrize("quantum", [0.01, 0.5])
def test_a_quantised_signal_has_the_noise_of_its_quantum(quantum: float) -> None:
    """What rounding takes away is spread evenly over a quantum: its standard deviation is quantum / sqrt(12)."""
    slow = np.floor(0.02 * np.arange(len(T)) + 0.3) * quantum  # a step each 50 samples: differences are mostly 0
    assert sigma(T, slow) == pytest.approx(quantum / np.sqrt(12.0), rel=1e-9)


def test_a_quantum_is_seen_though_a_few_samples_are_off_the_grid() -> None:
    """One sample among 200 steps was interpolated: it is no reason to take the signal for a smooth one."""
    slow = np.floor(0.02 * np.arange(len(T)) + 0.3) * 0.5
    slow[1000] += 0.15
    assert sigma(T, slow) == pytest.approx(0.5 / np.sqrt(12.0), rel=1e-9)


def test_a_quantum_of_uneven_steps_is_the_smallest_of_them() -> None:
    """Steps of 1 and 3 quanta in turn, 50 samples apart."""
    counts = np.cumsum(np.where(np.arange(len(T)) % 50 == 0, np.where(np.arange(len(T)) % 100 == 0, 1, 3), 0))
    assert sigma(T, 0.2 * counts) == pytest.approx(0.2 / np.sqrt(12.0), rel=1e-9)


@pytest.mark.parametrize("noise", [1e-5, 1e-4])
def test_a_signal_without_a_quantum_gets_no_floor_from_one(noise: float) -> None:
    """A steady climb, as a position at constant speed: all its changes are alike, and no grid made them so."""
    assert sigma(T, T + white(len(T), noise)) == pytest.approx(noise, rel=0.05)
    braked = T - 2.0 * np.clip(T - 0.98 * T[-1], 0.0, None) ** 2  # and at the end no longer steady
    assert sigma(T, braked + white(len(T), noise)) < 0.1 * STEP / np.sqrt(12.0)


def test_a_model_that_explains_more_than_the_filter_left_does_not_lower_a_white_signals_noise() -> None:
    """The signal is white; the residual is so smooth that it cannot be what a white sensor left."""
    y = white(len(T), 0.2)
    smooth_rest = 0.01 * np.sin(3.0 * T)
    assert sigma(T, y, smooth_rest) == pytest.approx(0.2, rel=0.03)
    assert sigma(T, y, white(len(T), 0.1)) == pytest.approx(0.1, rel=0.03)
    assert sigma(T, y, white(len(T), 0.4)) == pytest.approx(0.2, rel=0.03)


def test_no_sensor_is_taken_to_be_better_than_the_best_ones() -> None:
    """A simulator's log has no noise; what is not judged has no weight at all."""
    measured = np.zeros((len(T), len(CHANNELS)))
    found = noise_floor(T, measured, ("x", "v"))
    wanted = {"x": 0.01, "v": 0.01}  # m of an RTK receiver, m/s of an optical sensor
    assert [found[k] for k, name in enumerate(CHANNELS) if name in wanted] == list(wanted.values())
    assert all(np.isinf(found[k]) for k, name in enumerate(CHANNELS) if name not in wanted)
    assert len(BEST_SENSOR_SIGMA) == len(CHANNELS)


def test_white_noise_on_a_position_is_a_filters_last_digit() -> None:
    """A position comes out of somebody's filter: half a percent of the bend, however white what is left looks."""
    measured = np.tile((10.0 * MOTION)[:, None], (1, len(CHANNELS))) + white(len(T), 1e-4)[:, None]
    found = dict(zip(CHANNELS, noise_floor(T, measured, ("x", "v")), strict=True))
    assert found["x"] == pytest.approx(0.05 * BEND, rel=0.01)
    assert found["v"] == pytest.approx(max(0.002 * BEND, 0.01), rel=0.01)
