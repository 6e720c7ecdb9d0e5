"""Time off the drivable lanes."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Measured, Series, metric


@metric(name="road_departure", unit="s", bigger_is_worse=True)
def road_departure(log: Log) -> Measured:
    """Time during which a corner of the ego's box was not on a drivable lane.

    From the column `on_road`, which the world fills. Raises Undefined where it was never measured.
    """
    on_road = log.columns.get("on_road")
    if on_road is None or not np.isfinite(on_road).any():
        raise Undefined("the column on_road was not measured")
    off = on_road < 0.5
    step = np.diff(log.t, append=log.t[-1])
    when = float(log.t[np.argmax(off)]) if off.any() else None
    # A departure in the very last sample has no step of its own but is one all the same.
    value = max(float(step[off].sum()), float(np.median(np.diff(log.t)))) if off.any() else 0.0
    return Measured(value, when, "", Series(log.t, np.where(off, 1.0, 0.0)))
