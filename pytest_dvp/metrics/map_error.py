"""What the stack takes the map to say against the road as it is."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Measured, Series, metric


@metric(name="lane_width_error", unit="m", bigger_is_worse=True, open_loop=True, note="mean")
def lane_width_error(log: Log) -> Measured:
    """Mean size of the difference between the width of the lane that the stack assumes and that of the road.

    From the columns `ads.lane_width`, of the lane of its route, and `lane_width`, of the lane under the reference
    point, which may be another one while it overtakes and in a junction. Source: ISO 19157 quantitative attribute
    accuracy, of the map. Undefined if either was never stated.
    """
    if not {"ads.lane_width", "lane_width"} <= log.columns.keys():
        raise Undefined("the stack does not state how wide it takes its lane to be (ads.lane_width, lane_width)")
    error = np.abs(log["ads.lane_width"] - log["lane_width"])
    if not np.isfinite(error).any():
        raise Undefined("the width of the lane was never known")
    worst = int(np.nanargmax(error))
    return Measured(float(np.nanmean(error)), float(log.t[worst]), "", Series(log.t, error))
