"""A drive that was hardly measured keeps no bound: what was not seen did not stay within it."""

from __future__ import annotations

import numpy as np
import pytest
from results_logs import log_of, times

from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.max_yaw_rate import max_yaw_rate
from pytest_dvp.metrics.road_departure import road_departure

T = times()
VALUES = {"on_road": 1.0, "yaw_rate": 0.1}


def seen(share: float, every: int = 1) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    return (share * 10.0 > T) & (np.arange(len(T)) % every == 0)


@pytest.mark.parametrize(("share", "every"), [(0.001, 1), (0.4, 1), (0.4, 5)])
def test_less_than_half_of_a_drive_says_nothing_of_it(share: float, every: int) -> None:
    log = log_of(columns={name: np.where(seen(share, every), value, np.nan) for name, value in VALUES.items()})
    with pytest.raises(Undefined, match="on_road was measured for"):
        road_departure(log)
    with pytest.raises(Undefined, match="yaw_rate was measured for"):
        max_yaw_rate(log)


@pytest.mark.parametrize(("share", "every"), [(0.6, 1), (1.0, 1), (1.0, 10)])
def test_a_slow_sensor_and_a_short_loss_do(share: float, every: int) -> None:
    log = log_of(columns={name: np.where(seen(share, every), value, np.nan) for name, value in VALUES.items()})
    assert road_departure(log).value == 0.0
    assert max_yaw_rate(log).value == 0.1


def test_a_departure_that_was_seen_is_one_however_little_was() -> None:
    on_road = np.where(T > 9.5, 0.0, np.nan)
    assert road_departure(log_of(columns={"on_road": on_road})).value == pytest.approx(0.49, abs=0.02)
