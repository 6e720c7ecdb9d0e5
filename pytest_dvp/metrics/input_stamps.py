"""Age and order of the sensors' messages, as the stack got them."""

from __future__ import annotations

from typing import Literal

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Measured, MetricError, Series, metric


@metric(name="input_age", unit="s", bigger_is_worse=True, open_loop=True, note="{sensor}, {statistic}")
def input_age(log: Log, *, sensor: str, statistic: Literal["greatest", "least"] = "greatest") -> Measured:
    """Age of the newest message of a sensor that the stack had at its ticks: time of the tick minus the newest stamp.

    sensor: gnss, odometry, imu, lidar, camera, or another one of which the stack states a column `ads.age_SENSOR` [s].
    `statistic` is greatest, which messages that come late or stop make greater, or least, which is below 0 where stamps
    lie ahead. Source: age of information, Kaul, Yates and Gruteser, IEEE INFOCOM 2012. Undefined if the stack states no
    such column. Raises MetricError for another `statistic`.
    """
    if statistic not in ("greatest", "least"):
        raise MetricError(f"option 'statistic' of metric 'input_age': found {statistic!r}, allowed: greatest, least")
    age = log.columns.get(f"ads.age_{sensor}")
    if age is None or not np.isfinite(age).any():
        raise Undefined(f"the stack does not state how old its input is (ads.age_{sensor})")
    worst = int(np.nanargmax(age) if statistic == "greatest" else np.nanargmin(age))
    return Measured(float(age[worst]), float(log.t[worst]), "", Series(log.t, age), {"mean": float(np.nanmean(age))})


@metric(name="disordered_inputs", unit="-", bigger_is_worse=True, open_loop=True, note="number of messages")
def disordered_inputs(log: Log) -> Measured:
    """How many messages reached the stack whose stamp was not newer than all before of that sensor.

    Repeated messages count too. From the column `ads.disordered`, which counts them. Source: reordered packets, IETF
    RFC 4737, section 3, with duplicates of RFC 5560. Undefined if the stack does not state that column.
    """
    count = log.columns.get("ads.disordered")
    if count is None or not np.isfinite(count).any():
        raise Undefined("the stack does not state whether its input is in order (ads.disordered)")
    worst = int(np.nanargmax(count))
    return Measured(float(count[worst]), float(log.t[worst]), "", Series(log.t, count))
