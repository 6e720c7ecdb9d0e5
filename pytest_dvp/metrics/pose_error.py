"""What the stack believes of its own pose against what is true."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Measured, Series, metric


@metric(
    name="localization_error", unit="m", bigger_is_worse=True, open_loop=True, note="root mean square of the position"
)
def localization_error(log: Log) -> Measured:
    """Root mean square of the distance between the position the stack estimates (`ads.x`, `ads.y`) and the true one.

    Undefined if the stack tells no estimate, or before its first one only.
    """
    if "ads.x" not in log.columns or "ads.y" not in log.columns:
        raise Undefined("the stack tells no estimate of its position (ads.x, ads.y)")
    # The estimate of a tick holds in the log until the next; it was true at the instant of the tick.
    fresh = np.flatnonzero(np.diff(log["ads.x"], prepend=np.nan) != 0.0)
    t = log.t[fresh]
    error = np.hypot(log["ads.x"][fresh] - log["x"][fresh], log["ads.y"][fresh] - log["y"][fresh])
    known = np.isfinite(error)
    if not known.any():
        raise Undefined("the stack never had an estimate of its position")
    worst = int(np.argmax(np.where(known, error, -1.0)))
    rms = float(np.sqrt(np.mean(error[known] ** 2)))
    return Measured(rms, float(t[worst]), "", Series(t, error), {"greatest": float(error[worst])})


@metric(name="heading_error", unit="rad", bigger_is_worse=True, open_loop=True, note="root mean square")
def heading_error(log: Log) -> Measured:
    """Root mean square of the difference between the heading the stack estimates (`ads.yaw`) and the true one.

    Its mean, which a wrongly mounted antenna shifts, is in `extra`. Undefined if the stack tells no estimate.
    """
    if "ads.yaw" not in log.columns:
        raise Undefined("the stack tells no estimate of its heading (ads.yaw)")
    fresh = np.flatnonzero(np.diff(log["ads.yaw"], prepend=np.nan) != 0.0)
    error = np.remainder(log["ads.yaw"][fresh] - log["yaw"][fresh] + np.pi, 2.0 * np.pi) - np.pi
    known = np.isfinite(error)
    if not known.any():
        raise Undefined("the stack never had an estimate of its heading")
    t = log.t[fresh]
    worst = int(np.argmax(np.where(known, np.abs(error), -1.0)))
    rms = float(np.sqrt(np.mean(error[known] ** 2)))
    return Measured(rms, float(t[worst]), "", Series(t, error), {"mean": float(np.mean(error[known]))})
