"""How a car answers its commands."""

from __future__ import annotations

import numpy as np
import pytest
from results_logs import log_of, times

from pytest_dvp.logs.log import Log
from pytest_dvp.metrics import compute

T = times(40.0)


def asked(t: np.ndarray) -> np.ndarray:
    """Zero at both ends, so that a shift costs nothing."""
    return (np.sin(0.9 * t) + 0.5 * np.sin(2.3 * t + 1.0)) * np.exp(-(((t - 20.0) / 6.0) ** 2))


def driven(delay: float, gain: float) -> Log:
    return log_of(40.0, columns={"steer_cmd": asked(T), "steer": gain * asked(T - delay)})


@pytest.mark.parametrize(("delay", "gain"), [(0.0, 1.0), (0.3, 0.92), (0.123, 1.25)])
def test_lag_and_gain_of_the_wheel_are_those_of_its_actuator(delay: float, gain: float) -> None:
    log = driven(delay, gain)
    assert compute("response_lag", log).value == pytest.approx(delay, abs=0.005)
    assert compute("response_gain", log).value == pytest.approx(gain, rel=0.01)


def test_it_is_undefined_for_what_never_moves_or_was_not_measured() -> None:
    still = log_of(40.0, columns={"steer_cmd": 0.1, "steer": 0.1})
    assert compute("response_lag", still).reason == "the signal is constant"
    assert not compute("response_lag", log_of(40.0, columns={"steer_cmd": asked(T)})).valid
