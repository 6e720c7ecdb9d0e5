"""Post-encroachment time: how shortly after one another ego and others were at one place."""

from __future__ import annotations

import numpy as np

from machine_code import compiled
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics._box_touch import touch
from pytest_dvp.metrics._pairs import pairs
from pytest_dvp.metrics.metric import Measured, metric

LONGEST = 10.0  # s


@metric(name="pet", unit="s", bigger_is_worse=False, note="looked for up to {longest} s; resolved to a step of a track")
def pet(log: Log, *, longest: float = LONGEST) -> Measured:
    """Post-encroachment time: least time between one leaving a place and the other one coming to it; 0 at a contact.

    Over all places that the oriented boxes of the ego and another road user both covered, so also of one that follows
    the other. Source: Allen, Shin and Cooper, Transportation Research Record 667 (1978) 67. The value is too great by
    a step of the tracks at most. t is when the second one came. Undefined if no place was shared within `longest` [s].
    """
    best, when, who = np.inf, np.nan, ""
    for name, t, ego, box in pairs(log):
        apart, at = _least_time(t, ego, box, min(best, longest))
        if apart < best:
            best, when, who = apart, at, name
    if np.isinf(best):
        raise Undefined(f"no road user was within {longest:g} s where the ego was")
    return Measured(best, when, who)


@compiled
def _least_time(t: FloatArray, ego: FloatArray, box: FloatArray, longest: float) -> tuple[float, float]:
    """Least |t_i - t_j| [s] of rows i of the ego and j of the other one whose boxes overlap, and when the second one
    came; inf and nan if none is within."""
    best, at = np.inf, np.nan
    n = len(t)
    reach2 = (0.5 * np.hypot(ego[0, 3], ego[0, 4]) + 0.5 * np.hypot(box[0, 3], box[0, 4])) ** 2
    for lag in range(n):
        shortest = np.inf
        for i in range(n - lag):
            later = t[i + lag] - t[i]
            shortest = min(shortest, later)
            if later > longest or later >= best:
                continue
            for ego_first in (True, False):
                a, b = (i, i + lag) if ego_first else (i + lag, i)
                if (ego[a, 0] - box[b, 0]) ** 2 + (ego[a, 1] - box[b, 1]) ** 2 > reach2 or later >= best:
                    continue
                if touch(ego[a], box[b]):
                    best, at = later, t[i + lag]
        if shortest > min(best, longest):
            break  # rows farther apart are only later
    return best, at
