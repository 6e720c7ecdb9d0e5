"""Whether the sensors agree with what the stack's filter expects of them."""

from __future__ import annotations

from typing import Literal

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Measured, MetricError, Series, metric


@metric(name="nis", unit="-", bigger_is_worse=None, open_loop=True, ideal=1.0, note="{sensor}, {statistic}")
def nis(log: Log, *, sensor: str, statistic: Literal["mean", "greatest"] = "mean") -> Measured:
    """Normalised squared innovation of a sensor, per degree of freedom: 1 on average of a consistent filter.

    sensor: gnss, heading, wheels, or another one of which the stack states a column `ads.nis_SENSOR`: the squared
    difference of a measurement from what the filter expects, over the variance that it expects, before outliers are
    rejected. `statistic` is mean, or greatest, which a short fault shows in. Source: Bar-Shalom, Li and Kirubarajan
    2001, section 5.4.2. Undefined if the stack states no such column. Raises MetricError for another `statistic`.
    """
    if statistic not in ("mean", "greatest"):
        raise MetricError(f"option 'statistic' of metric 'nis': found {statistic!r}, allowed: mean, greatest")
    column = log.columns.get(f"ads.nis_{sensor}")
    if column is None or not np.isfinite(column).any():
        raise Undefined(f"the stack does not state how its filter agrees with that sensor (ads.nis_{sensor})")
    new = np.isfinite(column) & (np.diff(column, prepend=np.nan) != 0.0)  # it holds in the log until the next one
    t, values = log.t[new], column[new]
    worst = int(np.argmax(values))
    value = values.mean() if statistic == "mean" else values[worst]
    return Measured(float(value), float(t[worst]), "", Series(t, values), {"greatest": float(values[worst])})
