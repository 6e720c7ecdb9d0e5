"""Time off the drivable lanes."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics._presence import check_share, exposed
from pytest_dvp.metrics.metric import Measured, Series, metric


@metric(name="road_departure", unit="s", bigger_is_worse=True)
def road_departure(log: Log) -> Measured:
    """Time during which a corner of the ego's box was not on a drivable lane.

    From the column `on_road`, which the world fills. Raises Undefined where it was never measured, and where none is
    found but it was known for less than half of the drive.
    """
    on_road = log.columns.get("on_road")
    if on_road is None or not np.isfinite(on_road).any():
        raise Undefined("the column on_road was not measured")
    off = on_road < 0.5
    if not off.any():
        check_share(log.t, np.isfinite(on_road), "on_road")
    when = float(log.t[np.argmax(off)]) if off.any() else None
    return Measured(exposed(log.t, off, 0.0), when, "", Series(log.t, np.where(off, 1.0, 0.0)))
