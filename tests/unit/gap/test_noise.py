"""The noise floor: within 20 % of the truth, never below what a filter or a quantiser left."""

from __future__ import annotations

import numpy as np
import pytest
from gap_logs import NOISE, drive

from pytest_dvp.gap.compare.noise_floor import sigma

T = np.arange(0.0, 60.0, 0.02)
MOTION = 5.0 * np.sin(0.7 * T) + 0.3 * T


@pytest.mark.parametrize("level", [0.003, 0.03, 0.3])
def test_white_noise_on_a_motion_is_found_within_20_percent(level: float) -> None:
    y = MOTION + level * np.random.default_rng(2).normal(size=len(T))
    assert sigma(T, y) == pytest.approx(level, rel=0.2)


@pytest.mark.parametrize("scale", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("name", NOISE)
def test_every_channel_of_a_drive_is_found_within_20_percent(name: str, scale: float) -> None:
    log = drive(noise=scale)
    assert sigma(log.t, log[name]) == pytest.approx(scale * NOISE[name], rel=0.2)


def test_single_jumps_do_not_count_as_noise() -> None:
    y = MOTION + 0.03 * np.random.default_rng(2).normal(size=len(T))
    y[1500:] += 4.0
    assert sigma(T, y) == pytest.approx(0.03, rel=0.2)


def test_samples_not_measured_are_left_out() -> None:
    y = MOTION + 0.03 * np.random.default_rng(2).normal(size=len(T))
    y[::7] = np.nan
    assert sigma(T, y) == pytest.approx(0.03, rel=0.25)


@pytest.mark.parametrize("stamped", [True, False])
def test_a_gap_is_no_noise(stamped: bool) -> None:
    # Without a fix for 10 s, or a log that pauses: the car is 150 m on when the position is back
    y = 15.0 * T + 0.02 * np.random.default_rng(2).normal(size=len(T))
    gap = (T >= 20.0) & (T < 30.0)
    y[gap] = np.nan
    kept = np.ones(len(T), dtype=bool) if stamped else ~gap
    assert sigma(T[kept], y[kept], filtered=True) == pytest.approx(0.02, rel=0.2)


def test_filtered_signal_gets_a_floor_instead_of_none() -> None:
    smooth = np.convolve(MOTION + 0.3 * np.random.default_rng(2).normal(size=len(T)), np.ones(9) / 9.0, mode="valid")
    bend = np.subtract(*np.percentile(smooth[50:] - 2.0 * smooth[25:-25] + smooth[:-50], [99.0, 1.0]))
    assert sigma(T[: len(smooth)], smooth) >= 0.005 * bend


def test_noiseless_signal_gets_a_floor() -> None:
    assert sigma(T, MOTION) > 0.0


def test_quantised_signal_is_never_better_than_its_step() -> None:
    y = np.round(MOTION / 0.1) * 0.1
    assert sigma(T, y) >= 0.1 / 12.0**0.5 * 0.99


def test_jitter_of_the_command_is_not_noise_where_the_model_explains_it() -> None:
    rng = np.random.default_rng(4)
    jitter = 0.05 * rng.normal(size=len(T))
    y = MOTION + jitter + 0.01 * rng.normal(size=len(T))
    assert sigma(T, y) > 0.04
    assert sigma(T, y, y - MOTION - jitter) == pytest.approx(0.01, rel=0.2)


def test_too_few_samples_have_no_noise_floor() -> None:
    assert np.isnan(sigma(T[:10], MOTION[:10]))
