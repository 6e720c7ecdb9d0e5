"""What the stack believes of its own pose and speed against what is true.

True is what the log holds of the motion: of a car what its reference system measured, as long as that had its fix.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.lost_fix import with_fix
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Measured, MetricError, Series, metric
from vehicle.messages import TICK

STATISTICS = ("rms", "greatest")


@metric(name="localization_error", unit="m", bigger_is_worse=True, open_loop=True, note="{statistic} of the position")
def localization_error(log: Log, *, statistic: Literal["rms", "greatest"] = "rms") -> Measured:
    """Distance between the position the stack estimates (`ads.x`, `ads.y`) and the true one, at the ticks.

    `statistic` is rms, its root mean square, or greatest, which a short fault shows in. Undefined if the stack tells no
    estimate, or before its first one only. Raises MetricError for another `statistic`.
    """
    if "ads.x" not in log.columns or "ads.y" not in log.columns:
        raise Undefined("the stack tells no estimate of its position (ads.x, ads.y)")
    fresh = _fresh(log, "ads.x")
    x, y = with_fix(log.columns, "x")[fresh], with_fix(log.columns, "y")[fresh]
    error = np.hypot(log["ads.x"][fresh] - x, log["ads.y"][fresh] - y)
    return _figure("localization_error", statistic, log.t[fresh], error, "an estimate of its position")


@metric(name="heading_error", unit="rad", bigger_is_worse=True, open_loop=True, note="{statistic}")
def heading_error(log: Log, *, statistic: Literal["rms", "greatest"] = "rms") -> Measured:
    """Difference between the heading the stack estimates (`ads.yaw`) and the true one, at the ticks.

    `statistic` is rms or greatest. Its mean, which a wrongly mounted antenna shifts, is in `extra`. Undefined if the
    stack tells no estimate. Raises MetricError for another `statistic`.
    """
    if "ads.yaw" not in log.columns:
        raise Undefined("the stack tells no estimate of its heading (ads.yaw)")
    fresh = _fresh(log, "ads.yaw")
    error = np.remainder(log["ads.yaw"][fresh] - with_fix(log.columns, "yaw")[fresh] + np.pi, 2.0 * np.pi) - np.pi
    return _figure("heading_error", statistic, log.t[fresh], error, "an estimate of its heading")


@metric(name="speed_error", unit="m/s", bigger_is_worse=True, open_loop=True, note="{statistic}")
def speed_error(log: Log, *, statistic: Literal["rms", "greatest"] = "rms") -> Measured:
    """Difference between the speed the stack estimates (`ads.v`) and the true one, at the ticks.

    `statistic` is rms or greatest. Undefined if the stack tells no estimate. Raises MetricError for another one.
    """
    if "ads.v" not in log.columns:
        raise Undefined("the stack tells no estimate of its speed (ads.v)")
    fresh = _fresh(log, "ads.v")
    error = log["ads.v"][fresh] - with_fix(log.columns, "v")[fresh]
    return _figure("speed_error", statistic, log.t[fresh], error, "an estimate of its speed")


@metric(
    name="localization_nees", unit="-", bigger_is_worse=None, open_loop=True, ideal=2.0, note="mean; 2 is consistent"
)
def localization_nees(log: Log) -> Measured:
    """Mean of the squared position error over the variance that the stack states (`ads.position_sigma`, of an axis).

    Two axes, so 2 where the stack is as sure as it may be and its axes are equally sure; greater: too sure. Source:
    Bar-Shalom, Li and Kirubarajan 2001, section 5.4.2. Undefined if the stack tells no estimate or no deviation.
    """
    if not {"ads.x", "ads.y", "ads.position_sigma"} <= log.columns.keys():
        raise Undefined("the stack tells no deviation of its position (ads.position_sigma)")
    fresh = _fresh(log, "ads.x")
    x, y = with_fix(log.columns, "x")[fresh], with_fix(log.columns, "y")[fresh]
    error = np.hypot(log["ads.x"][fresh] - x, log["ads.y"][fresh] - y)
    sigma = log["ads.position_sigma"][fresh]
    known = np.isfinite(error) & (sigma > 0.0)
    if not known.any():
        raise Undefined("the stack never stated how sure it is of its position")
    t, share = log.t[fresh][known], (error[known] / sigma[known]) ** 2
    return Measured(float(share.mean()), float(t[int(np.argmax(share))]), "", Series(t, share))


def _fresh(log: Log, name: str) -> NDArray[np.int64]:
    """Rows of the ticks: an estimate holds in the log until the next; it was true at the instant of the tick.

    A tick is where the estimate changes. One that stays over a tick is still believed at it, and counts again there: in
    a run of ours each TICK, else, where nobody knows when the stack looked, each usual time between two changes. A
    change may come up to half a tick late.
    """
    changed = np.diff(log[name], prepend=np.nan) != 0.0
    told = np.diff(log.t[changed & np.isfinite(log[name])])
    period = TICK if log.meta.get("stage") or not len(told) else float(np.median(told))
    since = np.flatnonzero(changed)
    begin, end = log.t[since], np.append(log.t[since[1:]], log.t[-1] + period)
    missed = np.maximum(np.floor((end - begin) / period + 0.5).astype(int) - 1, 0)
    due = [begin[k] + period * np.arange(1, missed[k] + 1) for k in np.flatnonzero(missed)]
    at = np.searchsorted(log.t, np.concatenate([[], *due]) - 1e-6)
    return np.unique(np.concatenate([since, at[at < len(log.t)]]))


def _figure(name: str, statistic: str, t: FloatArray, error: FloatArray, what: str) -> Measured:
    if statistic not in STATISTICS:
        raise MetricError(f"option 'statistic' of metric {name!r}: found {statistic!r}, allowed: rms, greatest")
    known = np.isfinite(error)
    if not known.any():
        raise Undefined(f"the stack never had {what}")
    size = np.where(known, np.abs(error), -1.0)
    worst = int(np.argmax(size))
    rms = float(np.sqrt(np.mean(error[known] ** 2)))
    extra = {"greatest": float(size[worst]), "mean": float(np.mean(error[known]))}
    return Measured(rms if statistic == "rms" else float(size[worst]), float(t[worst]), "", Series(t, error), extra)
