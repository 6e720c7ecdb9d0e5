"""Age and order of the sensors' messages, their agreement with the filter, and the width of the lane."""

from __future__ import annotations

import numpy as np
import pytest
from results_logs import log_of, times
from scipy.stats import chi2

from pytest_dvp.metrics import MetricError, compute


def test_age_of_input_is_the_greatest_or_the_least_of_that_sensor() -> None:
    t = times()
    age = np.where((t > 3.0) & (t < 5.6), t - 3.0, 0.0) - 0.3 * (t > 8.0)  # silent for 2.6 s, then 0.3 s ahead
    log = log_of(columns={"ads.age_imu": age, "ads.age_gnss": 0.1})
    greatest = compute("input_age", log, sensor="imu")
    assert greatest.value == pytest.approx(2.6, abs=0.011)
    assert greatest.t == pytest.approx(5.59, abs=0.011)
    assert compute("input_age", log, sensor="imu", statistic="least").value == pytest.approx(-0.3)
    assert compute("input_age", log, sensor="gnss").value == pytest.approx(0.1)
    assert not compute("input_age", log, sensor="lidar").valid
    with pytest.raises(MetricError, match="allowed: greatest, least"):
        compute("input_age", log, sensor="imu", statistic="mean")


def test_messages_out_of_order_are_counted_by_the_stack() -> None:
    assert compute("disordered_inputs", log_of(columns={"ads.disordered": np.floor(times())})).value == 10.0
    assert not compute("disordered_inputs", log_of()).valid


def test_nis_of_a_consistent_filter_is_one() -> None:
    """Squares of normal numbers: 201 ticks, so the mean is 1 within 4 sqrt(2 / 201); held values count once."""
    drawn = chi2.rvs(1, size=201, random_state=3)
    log = log_of(columns={"ads.nis_wheels": np.repeat(drawn, 5)[:1001]})
    assert compute("nis", log, sensor="wheels").value == pytest.approx(float(np.mean(drawn)), rel=1e-9)
    assert compute("nis", log, sensor="wheels").value == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / 201))
    assert compute("nis", log, sensor="wheels", statistic="greatest").value == pytest.approx(drawn.max())
    assert not compute("nis", log, sensor="gnss").valid
    with pytest.raises(MetricError, match="allowed: mean, greatest"):
        compute("nis", log, sensor="wheels", statistic="rms")


def test_lane_width_error_is_the_mean_difference() -> None:
    t = times()
    log = log_of(columns={"lane_width": 3.5, "ads.lane_width": np.where(t < 5.0, np.nan, 3.5 - 0.2 * (t - 5.0))})
    assert compute("lane_width_error", log).value == pytest.approx(0.5, abs=1e-3)
    assert not compute("lane_width_error", log_of(columns={"lane_width": 3.5})).valid
