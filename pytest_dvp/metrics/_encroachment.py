"""The compiled part of the post-encroachment time."""

from __future__ import annotations

import numpy as np

from machine_code import compiled
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.metrics._box_touch import touch


@compiled
def least_time(t: FloatArray, ego: FloatArray, box: FloatArray, longest: float) -> tuple[float, float]:
    """Least |t_i - t_j| [s] of rows i of the ego and j of the other one whose boxes overlap, and when the second one
    came; inf and nan if none is within `longest` [s].

    t: shape (n,) [s]; ego, box: shape (n, 5), x, y [m], yaw [rad], length, width [m].
    """
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
