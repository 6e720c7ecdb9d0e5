"""Lateral offset to the lane and to the planned path."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Measured, Series, metric
from pytest_dvp.metrics.task_outcome import first_time

MIN_COVERAGE = 0.5
"""Least share of the time in which the offset must be defined; an RMSE of less is no statement about the run."""


@metric(name="lateral_rmse", unit="m", bigger_is_worse=True, note="to the centre line of the task's lane")
def lateral_rmse(log: Log) -> Measured:
    """Root mean square of the lateral offset of the ego's reference point to the fixed centre line of its lane.

    From start to goal. Overtaking counts as offset here; `lateral_rmse_path` is the one to the planned path. Source:
    Arango et al., Sensors 2026, 26, 1338. Undefined without a reference line.
    """
    from pytest_dvp.metrics._polyline import lateral_offsets

    if len(log.reference) < 2:
        raise Undefined("the log has no reference line: the task has neither lane nor route")
    rows = _rows_of_task(log)
    return _rms(log.t[rows], lateral_offsets(log["x"][rows], log["y"][rows], np.ascontiguousarray(log.reference)))


@metric(name="lateral_rmse_path", unit="m", bigger_is_worse=True, note="to the path planned at that time")
def lateral_rmse_path(log: Log) -> Measured:
    """Root mean square of the lateral offset of the ego's reference point to the path that was planned at that time.

    From start to goal. Undefined without planned paths.
    """
    from pytest_dvp.metrics._polyline import lateral_offsets

    if not log.paths:
        raise Undefined("no planned path in the log")
    rows = _rows_of_task(log)
    t, x, y = log.t[rows], log["x"][rows], log["y"][rows]
    offsets = np.full(len(t), np.nan)
    # A path planned in a tick holds from that instant on, as commands do.
    starts = np.searchsorted(t, np.array([time for time, _ in log.paths]) - 1e-6)
    for (_, path), a, b in zip(log.paths, starts, [*starts[1:], len(t)], strict=True):
        offsets[a:b] = lateral_offsets(x[a:b], y[a:b], np.ascontiguousarray(path))
    return _rms(t, offsets)


def _rows_of_task(log: Log) -> slice:
    start, goal = first_time(log, "start"), first_time(log, "goal")
    low = 0 if start is None else int(np.searchsorted(log.t, start - 1e-6))
    high = len(log.t) if goal is None else int(np.searchsorted(log.t, goal + 1e-6))
    if high - low < 2:
        raise Undefined("no samples between start and goal")
    return slice(low, high)


def _rms(t: FloatArray, offsets: FloatArray) -> Measured:
    known = np.isfinite(offsets)
    share = float(known.mean())
    if share < MIN_COVERAGE:
        raise Undefined(f"the ego is beside the line for {100 * share:.0f} % of the time only")
    rms = float(np.sqrt(np.mean(offsets[known] ** 2)))
    worst = int(np.argmax(np.where(known, np.abs(offsets), -1.0)))
    extra = {"greatest": float(abs(offsets[worst])), "coverage": share}
    return Measured(rms, float(t[worst]), "", Series(t, offsets), extra)
