"""Compiled distance of points to a polyline."""

from __future__ import annotations

import numpy as np

from machine_code import compiled
from pytest_dvp.logs.log_contents import FloatArray


@compiled
def lateral_offsets(x: FloatArray, y: FloatArray, line: FloatArray) -> FloatArray:
    """Signed offset [m] of n points to the nearest point of a polyline (m, 2); positive to its left.

    NaN where the nearest point is an open end and the point lies beyond it: there the line has nothing to say.
    Exact: the nearest segment of all, not a walk along the line.
    """
    n, m = x.shape[0], line.shape[0]
    result = np.full(n, np.nan)
    if m < 2:
        return result
    longest = 0.0
    for k in range(m - 1):
        longest = max(longest, np.hypot(line[k + 1, 0] - line[k, 0], line[k + 1, 1] - line[k, 1]))
    if longest == 0.0:
        return result
    guess = 0
    for i in range(n):
        best, offset = np.inf, np.nan
        # The last nearest segment first: it gives a bound that skips almost all others.
        k = guess
        first = True
        while k < m - 1:
            here = k
            k = 0 if first else k + 1
            first = False
            dx, dy = x[i] - line[here, 0], y[i] - line[here, 1]
            spare = np.sqrt(dx * dx + dy * dy) - np.sqrt(best) - longest
            if spare > 0.0:
                # Each segment comes at most `longest` nearer, so this many more cannot be the nearest either.
                k += int(min(spare / longest, float(m)))
                continue
            ex, ey = line[here + 1, 0] - line[here, 0], line[here + 1, 1] - line[here, 1]
            length2 = ex * ex + ey * ey
            if length2 == 0.0:
                continue
            along = (dx * ex + dy * ey) / length2
            clipped = min(1.0, max(0.0, along))
            rx, ry = dx - clipped * ex, dy - clipped * ey
            distance2 = rx * rx + ry * ry
            if distance2 < best:
                best = distance2
                guess = here
                beyond = (here == 0 and along < 0.0) or (here == m - 2 and along > 1.0)
                side = 1.0 if ex * dy - ey * dx >= 0.0 else -1.0
                offset = np.nan if beyond else side * np.sqrt(distance2)
        result[i] = offset
    return result
