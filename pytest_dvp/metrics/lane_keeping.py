"""How long the ego was outside its lane."""

from __future__ import annotations

import math

import numpy as np

from pytest_dvp.logs.held_values import held
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics._ego_box import ego_size
from pytest_dvp.metrics._presence import exposed
from pytest_dvp.metrics.metric import Measured, Positive, Series, metric


@metric(name="lane_time_outside", unit="s", bigger_is_worse=True, note="overtaking counts")
def lane_time_outside(log: Log, *, width: Positive = math.nan) -> Measured:
    """Time in which a corner of the ego's box was farther from the centre line of the task's lanes than half of them.

    The centre line is the log's reference line; the width of the lane is the column `lane_width`, where the ego is on
    no lane the last one, or `width` [m] where that is declared. Rows beyond an end of the line do not count,
    overtaking does. Source: lane departure of ISO 17361:2017 (a wheel beyond the boundary), with the box for the
    wheels. Undefined without line or width.
    """
    from pytest_dvp.metrics._polyline import lateral_offsets

    if len(log.reference) < 2:
        raise Undefined("the log has no reference line: the task has neither lane nor route")
    if math.isnan(width) and "lane_width" not in log.columns:
        raise Undefined("the log does not tell the width of the lane (lane_width): declare width")
    half = 0.5 * (held(log["lane_width"]) if math.isnan(width) else np.full(len(log.t), width))
    length, across, ahead = ego_size(log)
    cos, sin = np.cos(log["yaw"]), np.sin(log["yaw"])
    line = np.ascontiguousarray(log.reference)
    farthest = np.full(len(log.t), -np.inf)
    for u in (ahead - 0.5 * length, ahead + 0.5 * length):
        for w in (-0.5 * across, 0.5 * across):
            offset = np.abs(lateral_offsets(log["x"] + u * cos - w * sin, log["y"] + u * sin + w * cos, line))
            farthest = np.fmax(farthest, offset)  # a corner beyond an end of the line tells nothing
    over = np.where(np.isfinite(farthest) & (half > 0.0), farthest - half, np.nan)
    if not np.isfinite(over).any():
        raise Undefined("the ego was never beside the line of its lane, or the width of the lane was not measured")
    out = over > 0.0
    worst = int(np.argmax(np.where(out, over, -np.inf))) if out.any() else None
    extra = {"farthest": float(np.nanmax(over))}
    return Measured(
        exposed(log.t, out, 0.0), None if worst is None else float(log.t[worst]), "", Series(log.t, over), extra
    )
