"""Speed against the limit of the road."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Measured, Series, metric


@metric(name="speed_excess", unit="m/s", bigger_is_worse=True)
def speed_excess(log: Log) -> Measured:
    """Greatest speed above the limit of the lane under the reference point; below 0 by how much it was always kept.

    From `v` and the column `speed_limit`, which is what the OpenDRIVE file states for the lane or else for the type of
    its road. Source: ASAM OpenDRIVE 1.8, speed records of lanes and road types. Undefined where no limit is recorded.
    """
    limit = log.columns.get("speed_limit")
    if limit is None:
        raise Undefined("the log does not tell the speed limit (speed_limit)")
    over = np.abs(log["v"]) - limit
    known = np.isfinite(over)
    if not known.any():
        raise Undefined("the road states no speed limit where the ego drove")
    worst = int(np.argmax(np.where(known, over, -np.inf)))
    return Measured(float(over[worst]), float(log.t[worst]), "", Series(log.t, over))
