"""Where the ego stopped, and whether it stood still there."""

from __future__ import annotations

import math

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Measured, Positive, metric

STANDING = 0.05  # m/s; slower is standing, as where a run waits at its goal
SLOW, LEAST = 0.3, 1.0  # m/s and s: a stretch that was meant as a standstill


@metric(name="stop_error", unit="m", bigger_is_worse=True, note="slower than 0.05 m/s at the end")
def stop_error(log: Log) -> Measured:
    """Distance along the lane between the goal of the task and the reference point of the ego that stopped there.

    The goal is the end of the reference line, and its last segment the direction. `extra` holds the signed value
    (beyond: > 0) and the offset to the left. Source: definition, of this project.
    Undefined if the task has no goal or the ego does not stand at the end of the log.
    """
    task = log.meta.get("task")
    if not isinstance(task, dict) or not task.get("goal") or len(log.reference) < 2:
        raise Undefined("the task has no goal")
    v, x, y = (float(log[name][-1]) for name in ("v", "x", "y"))
    if not abs(v) <= STANDING:
        raise Undefined(f"the ego did not stand at the end of the log: {v:.2f} m/s")
    end = log.reference[-1]
    before = log.reference[np.flatnonzero((log.reference != end).any(axis=1))]
    if not len(before):
        raise Undefined("the reference line has no direction at the goal")
    dx, dy = end - before[-1]
    length = math.hypot(dx, dy)
    along = ((x - end[0]) * dx + (y - end[1]) * dy) / length
    left = ((y - end[1]) * dx - (x - end[0]) * dy) / length
    stopped = int(np.flatnonzero(np.abs(log["v"]) > STANDING)[-1]) + 1 if (np.abs(log["v"]) > STANDING).any() else 0
    return Measured(abs(along), float(log.t[stopped]), "", extra={"beyond": along, "left": left})


@metric(name="creep", unit="m", bigger_is_worse=True, note="slower than {slow} m/s for {least} s")
def creep(log: Log, *, slow: Positive = SLOW, least: Positive = LEAST) -> Measured:
    """Greatest distance rolled within one standstill: a stretch slower than `slow` [m/s] for at least `least` [s].

    Its places, the integral of v over the whole stretch, from the hindmost to the foremost: a car that rocks counts
    once, and the noise of a measured speed does not add up, as its path length would. Coming to rest from `slow`
    counts, by `slow`^2 / (2 a): 2 cm at 2 m/s^2. Source: definition, of this project. t is when the stretch began.
    Undefined if the ego never stood so.
    """
    v = log["v"]
    still = np.abs(v) < slow  # what is not measured is no standstill
    edge = np.diff(np.concatenate([[False], still, [False]]).astype(np.int64))
    best, when = -1.0, None
    for a, b in zip(np.flatnonzero(edge == 1), np.flatnonzero(edge == -1), strict=True):
        t = log.t[a:b]
        if t[-1] - t[0] >= least - 1e-9:
            place = np.cumsum(0.5 * (v[a + 1 : b] + v[a : b - 1]) * np.diff(t))
            rolled = float(max(place.max(), 0.0) - min(place.min(), 0.0))
            if rolled > best:
                best, when = rolled, float(t[0])
    if when is None:
        raise Undefined(f"the ego was never slower than {slow:g} m/s for {least:g} s")
    return Measured(best, when)
