"""Repeated commands, pedals and what the stack believes of its speed, against closed forms and counts."""

from __future__ import annotations

import math
import os

import numpy as np
import pytest
from results_logs import log_of, times

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.metrics import compute

CASES = int(os.environ.get("DVP_CASES", "200"))  # random ones of each comparison; `make nightly` takes 10,000


def held(values: FloatArray, hold: int = 5) -> FloatArray:
    """One value a tick of 0.05 s, on the 100 Hz of a log of 10 s."""
    return np.repeat(values, hold)[:1001]


def test_repetitions_are_counted_as_they_were_planted() -> None:
    rng = np.random.default_rng(3)
    for _ in range(CASES // 10):
        steer = rng.normal(size=201)
        again = np.sort(rng.choice(np.arange(1, 201), rng.integers(0, 40), replace=False))
        for k in again:
            steer[k] = steer[k - 1]
        found = compute("repeated_commands", log_of(columns={"v": 3.0, "steer_cmd": held(steer)}))
        assert found.value == pytest.approx(len(again) / 200)
        assert found.t == (pytest.approx(0.05 * again[0]) if len(again) else None)


def test_what_is_told_an_ego_that_stands_does_not_count() -> None:
    v = np.where(times() < 5.0, 0.0, 2.0)
    steer = np.where(np.arange(201) < 100, 0.0, np.arange(201.0))
    assert compute("repeated_commands", log_of(columns={"v": v, "steer_cmd": held(steer)})).value == 0.0
    assert not compute("repeated_commands", log_of(columns={"v": 0.0, "steer_cmd": held(steer)})).valid
    assert not compute("repeated_commands", log_of(columns={"v": 2.0})).valid


@pytest.mark.parametrize(("amplitude", "frequency"), [(1.0, 0.1), (0.5, 0.25)])
def test_acceleration_and_deceleration_of_a_swaying_speed(amplitude: float, frequency: float) -> None:
    """v = 8 + a sin(w t): the greatest rate is a w, times the gain of two passes of the Butterworth filter."""
    t, w = times(40.0), 2.0 * math.pi * frequency
    log = log_of(40.0, columns={"v": 8.0 + amplitude * np.sin(w * t)})
    gain = 1.0 / (1.0 + frequency**4)
    for name in ("max_acceleration", "max_deceleration"):
        assert compute(name, log).value == pytest.approx(amplitude * w * gain, rel=0.02)


def test_a_constant_deceleration_is_found_with_its_sign() -> None:
    log = log_of(columns={"v": 30.0 - 2.0 * times()})
    assert compute("max_deceleration", log).value == pytest.approx(2.0, abs=1e-6)
    assert compute("max_acceleration", log).value == pytest.approx(-2.0, abs=1e-6)


def test_roughness_of_a_command_is_that_of_its_fast_part() -> None:
    """A sine of 8 Hz passes the 1 Hz filter by 1 / (1 + 8^4): what is left is a w / sqrt(2)."""
    t = times(20.0)
    slow, fast = np.sin(2.0 * math.pi * 0.05 * t), 0.1 * np.sin(2.0 * math.pi * 8.0 * t)
    found = compute("accel_roughness", log_of(20.0, columns={"accel_cmd": slow + fast}))
    sampled = 0.1 * math.sin(2.0 * math.pi * 8.0 * 0.01) / 0.01 / math.sqrt(2.0)  # by central differences
    assert found.value == pytest.approx(sampled, rel=0.02)
    assert found.series is not None
    assert found.value == pytest.approx(float(np.sqrt(np.mean(found.series.value**2))))  # the course is that of it, too


def estimate(values: FloatArray) -> Log:
    """The ego at 5 m/s, whose stack believes `values` of each tick."""
    t = times()
    return log_of(columns={"x": 5.0 * t, "v": 5.0, "ads.v": held(values)})


def test_speed_error_is_the_root_mean_square_or_the_greatest() -> None:
    rng = np.random.default_rng(4)
    for _ in range(CASES // 10):
        error = rng.normal(size=201)
        log = estimate(5.0 + error)
        assert compute("speed_error", log).value == pytest.approx(math.sqrt(sum(e * e for e in error) / 201))
        assert compute("speed_error", log, statistic="greatest").value == pytest.approx(max(abs(e) for e in error))
    assert not compute("speed_error", log_of()).valid


def test_nees_of_the_position_is_two_for_a_consistent_estimate() -> None:
    rng = np.random.default_rng(5)
    sigma = held(rng.uniform(0.01, 0.5, 201))
    ex, ey = (held(rng.normal(size=201)) * sigma for _ in range(2))
    columns = {"ads.x": ex, "ads.y": ey, "ads.position_sigma": sigma}
    found = compute("localization_nees", log_of(columns=columns)).value
    assert found == pytest.approx(float(np.mean((ex**2 + ey**2)[::5] / sigma[::5] ** 2)))
    assert found == pytest.approx(2.0, abs=4.0 * 2.0 / math.sqrt(201))
    assert not compute("localization_nees", log_of(columns={"ads.x": ex, "ads.y": ey})).valid


def test_another_statistic_is_refused() -> None:
    from pytest_dvp.metrics import MetricError

    with pytest.raises(MetricError, match="allowed: rms, greatest"):
        compute("heading_error", log_of(columns={"ads.yaw": 0.1}), statistic="worst")
