"""Lag to a fraction of a sample, its sign, and when there is none."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.gap.compare.time_alignment import alike, common_lag

STEP = 0.02
T = np.arange(0.0, 60.0, STEP)


def wave(t: np.ndarray) -> np.ndarray:
    return np.sin(1.3 * t) + 0.4 * np.sin(3.1 * t + 1.0) + 0.2 * np.sin(0.2 * t)


@pytest.mark.parametrize("late", [-0.205, -0.04, 0.0, 0.007, 0.113, 0.35])
def test_lag_is_found_to_an_eighth_of_a_sample(late: float) -> None:
    assert alike(wave(T - late), wave(T), STEP).lag == pytest.approx(late, abs=0.0025)


def test_lag_is_positive_where_the_measurement_comes_later() -> None:
    assert (alike(wave(T - 0.3), wave(T), STEP).lag or 0.0) > 0.0


def test_gain_is_measured_over_model() -> None:
    assert alike(1.2 * wave(T), wave(T), STEP).gain == pytest.approx(1.2)


def test_constant_signal_has_neither() -> None:
    found = alike(np.ones(500), wave(T[:500]), STEP)
    assert (found.mncc, found.lag, found.gain) == (None, None, None)


def test_lag_beyond_the_search_is_not_reported() -> None:
    pulse = np.exp(-(((T - 20.0) / 4.0) ** 2))
    assert alike(np.exp(-(((T - 30.0) / 4.0) ** 2)), pulse, STEP).lag is None


def test_common_lag_ignores_slow_drift() -> None:
    pairs = [(wave(T - 0.1) + 0.5 * T, wave(T)), (wave(T - 0.1), wave(T))]
    assert common_lag(pairs, STEP) == pytest.approx(0.1, abs=0.004)


def test_nothing_that_varies_has_no_lag() -> None:
    assert common_lag([(np.ones(500), np.ones(500))], STEP) == 0.0


def test_a_slow_signal_that_is_late_is_not_drawn_to_no_lag() -> None:
    """A speed that rises and falls over ten seconds: over whole norms a shift loses more than it mends."""
    t = np.arange(0.0, 40.0, 0.05)
    speed = 10.0 + 5.0 * np.sin(2.0 * np.pi * t / 11.0) + 0.1 * t
    late = np.interp(t - 0.4, t, speed)
    found = alike(late, speed, 0.05)
    assert found.lag == pytest.approx(0.4, abs=0.01)
    assert found.gain == pytest.approx(1.0, abs=0.005)
