"""Noise that repeats itself from sample to sample: seen at standstill, and taken out of residuals."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from pytest_dvp.gap.compare.coloured_noise import ORDER, first_rows, whitening
from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.logs.log_contents import FloatArray

STEP, V, AX = 0.02, CHANNELS.index("v"), CHANNELS.index("ax")


def noise(n: int, phi: float, seed: int) -> FloatArray:
    """An autoregressive process of first order, of variance 1."""
    white = np.random.default_rng(seed).standard_normal(n + 2000) * np.sqrt(1.0 - phi * phi)
    return np.asarray(lfilter([1.0], [1.0, -phi], white)[2000:])


def parked(phi: float, *, seconds: float = 20.0, seed: int = 1) -> tuple[FloatArray, FloatArray]:
    """A car that stands, whose accelerometer has noise of 0.1 m/s^2."""
    t = np.arange(0.0, seconds, STEP)
    measured = np.full((len(t), len(CHANNELS)), np.nan)
    measured[:, :5] = 0.0
    measured[:, AX] = 0.1 * noise(len(t), phi, seed)
    return t, measured


def judged(sigma: float) -> FloatArray:
    found = np.full(len(CHANNELS), np.inf)
    found[AX] = sigma
    return found


def test_white_noise_stays_as_it_is() -> None:
    t, measured = parked(0.0)
    found = whitening(t, measured, judged(0.1))
    assert found.independent[AX] == 1.0
    assert found.sigma[AX] == 0.1
    whitened = found.of(measured, first_rows(t, np.array([0]))).reshape(-1, len(CHANNELS))
    assert whitened[:, AX] == pytest.approx(measured[:, AX] / 0.1)
    assert not whitened[:, V].any()


@pytest.mark.parametrize("phi", [0.6, 0.9])
def test_coloured_noise_becomes_white(phi: float) -> None:
    """A process of first order has (1 - phi)/(1 + phi) independent samples for each that it has."""
    t, measured = parked(phi, seconds=200.0)
    found = whitening(t, measured, judged(0.02))
    assert found.independent[AX] == pytest.approx((1.0 - phi) / (1.0 + phi), rel=0.2)
    assert found.sigma[AX] == pytest.approx(0.1, rel=0.1)
    others = np.full((20_000, len(CHANNELS)), np.nan)
    others[:, AX] = 0.1 * noise(20_000, phi, 2)
    white = found.of(others, np.arange(20_000) % 250 == 0).reshape(-1, len(CHANNELS))[:, AX]
    assert np.mean(white**2) == pytest.approx(1.0, rel=0.15)
    assert abs(np.mean(white[1:] * white[:-1])) < 0.05


@pytest.mark.parametrize("white", ["v", "x"])
def test_one_channel_that_is_white_or_quiet_leaves_the_others_as_coloured_as_they_are(white: str) -> None:
    """A speed that shows 0 at standstill, and a position of white noise of 0.1 m."""
    t, measured = parked(0.9, seconds=100.0)
    alone = whitening(t, measured, judged(0.02))
    both = judged(0.02)
    both[CHANNELS.index(white)] = 0.1
    if white == "x":
        measured[:, 0] = 0.1 * noise(len(t), 0.0, 3)
    found = whitening(t, measured, both)
    assert found.independent[AX] == alone.independent[AX] < 0.1
    assert found.independent[CHANNELS.index(white)] == 1.0


def test_a_gap_and_a_start_have_no_neighbour() -> None:
    t, measured = parked(0.9, seconds=100.0)
    found = whitening(t, measured, judged(0.02))
    rows = np.full((10, len(CHANNELS)), np.nan)
    rows[:, AX] = 0.1
    stamps = STEP * np.arange(10.0)
    stamps[6:] += 1.0
    white = found.of(rows, first_rows(stamps, np.array([0, 3]))).reshape(-1, len(CHANNELS))[:, AX]
    alone = 0.1 / found.sigma[AX]
    assert white[[0, 3, 6]] == pytest.approx(alone)
    assert (np.abs(white[[1, 2, 4, 5, 7, 8, 9]] - alone) > 0.1).all()


@pytest.mark.parametrize("seconds", [3.0, 100.0])
def test_too_short_a_standstill_says_nothing(seconds: float) -> None:
    """The first and the last second of a standstill do not count; 50 samples are left of 3 s."""
    t, measured = parked(0.8, seconds=seconds)
    found = whitening(t, measured, judged(0.05))
    assert (found.independent[AX] == 1.0) == (seconds == 3.0)
    assert found.weights[AX].any() == (seconds != 3.0)
    assert found.weights.shape == (len(CHANNELS), ORDER + 1, ORDER)


def test_a_car_that_never_stands_counts_as_white() -> None:
    t, measured = parked(0.9, seconds=100.0)
    measured[:, V] = 5.0
    measured[:, 0] = 5.0 * t
    assert (whitening(t, measured, judged(0.05)).independent == 1.0).all()


def test_another_noise_at_standstill_is_not_that_of_the_road() -> None:
    """An engine that shakes the body a little, and a road that shakes it ten times as much."""
    t, measured = parked(0.9, seconds=100.0)
    assert whitening(t, measured, judged(1.0)).independent[AX] == 1.0


def creeping(speed: FloatArray, seed: int) -> FloatArray:
    """A log whose white noise is 0.01 m, 0.015 m/s and 0.03 m/s^2, of a car that drives straight at `speed` (n,)."""
    rng = np.random.default_rng(seed)
    measured = np.zeros((len(speed), len(CHANNELS)))
    measured[:, 0] = STEP * np.cumsum(speed) + 0.01 * rng.standard_normal(len(speed))
    measured[:, 1] = 0.01 * rng.standard_normal(len(speed))
    measured[:, V] = speed + 0.015 * rng.standard_normal(len(speed))
    measured[:, AX] = np.gradient(speed, STEP) + 0.03 * rng.standard_normal(len(speed))
    return measured


@pytest.mark.parametrize("seed", range(5))
def test_a_car_that_creeps_to_its_stop_shows_no_coloured_noise(seed: int) -> None:
    """From 0.25 m/s it rolls out within three seconds, stands for two, and sets off again."""
    t = np.arange(0.0, 20.0, STEP)
    speed = np.interp(t, [0.0, 8.0, 10.0, 13.0, 15.0, 17.0, 20.0], [8.0, 8.0, 0.25, 0.0, 0.0, 0.25, 5.0])
    sigma = np.full(len(CHANNELS), np.inf)
    sigma[[0, 1, V, AX]] = 0.01, 0.01, 0.015, 0.03
    found = whitening(t, creeping(speed, seed), sigma)
    assert found.sigma[[0, V, AX]] == pytest.approx(sigma[[0, V, AX]])
    assert found.independent[[0, V, AX]] == pytest.approx(1.0)


def test_a_receiver_that_drifts_while_the_car_stands_is_still_seen() -> None:
    t = np.arange(0.0, 60.0, STEP)
    measured = creeping(np.interp(t, [0.0, 40.0, 45.0, 60.0], [0.0, 0.0, 8.0, 8.0]), 3)
    measured[:, 0] += 0.05 * noise(len(t), 0.95, 4)
    measured[:, V] += 0.05 * noise(len(t), 0.95, 5)
    sigma = np.full(len(CHANNELS), np.inf)
    sigma[[0, 1, V]] = 0.01, 0.01, 0.015
    found = whitening(t, measured, sigma)
    assert found.independent[0] < 0.2
    assert found.independent[V] < 0.2
