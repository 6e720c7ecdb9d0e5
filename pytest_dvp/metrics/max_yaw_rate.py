"""Greatest yaw rate."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics._presence import check_share
from pytest_dvp.metrics.metric import Measured, Series, metric


@metric(name="max_yaw_rate", unit="rad/s", bigger_is_worse=True, note="not filtered")
def max_yaw_rate(log: Log) -> Measured:
    """Greatest magnitude of the yaw rate, as measured: spikes of a sensor show. Source: Arango et al. 2026.

    Raises Undefined if it was measured for less than half of the drive.
    """
    rate = log["yaw_rate"]
    measured = np.isfinite(rate)
    if not measured.any():
        raise Undefined("yaw_rate was not measured")
    check_share(log.t, measured, "yaw_rate")
    worst = int(np.argmax(np.where(measured, np.abs(rate), -1.0)))
    return Measured(float(abs(rate[worst])), float(log.t[worst]), "", Series(log.t, rate))
