"""Compiled distance of points to a polyline."""

from __future__ import annotations

import numpy as np

from machine_code import compiled
from pytest_dvp.logs.log_contents import FloatArray

WINDOW = 32  # segments before and behind the nearest one that are looked at while no other can come near
RETRY = 64  # points until a window is looked for again, where the last one did not help; both chosen by measuring
SLACK = 1e-6  # m, far above what rounding does to a distance on a road


@compiled
def least_outside(x: float, y: float, line: FloatArray, low: int, high: int, longest: float) -> float:
    """A distance [m] that no segment of `line` (m, 2) beside those of low to high - 1 comes nearer to a point than."""
    least = np.inf
    for k in range(line.shape[0]):
        if k <= low or k >= high:
            dx, dy = x - line[k, 0], y - line[k, 1]
            least = min(least, dx * dx + dy * dy)
    return float(np.sqrt(least)) - longest


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
    # As seen from (at_x, at_y) [m], all segments but those of low to high - 1 are at least `outside` [m] away.
    at_x, at_y, outside, low, high, retry = 0.0, 0.0, -np.inf, 0, m - 1, 0
    for i in range(n):
        best, nearest, offset = np.inf, np.inf, np.nan
        # The last nearest segment first: it gives a bound that skips almost all others.
        k, end = -1, m - 1
        while k < end:
            here = guess if k < 0 else k
            k += 1
            dx, dy = x[i] - line[here, 0], y[i] - line[here, 1]
            spare = np.sqrt(dx * dx + dy * dy) - nearest - longest
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
                best, nearest = distance2, np.sqrt(distance2)
                guess = here
                beyond = (here == 0 and along < 0.0) or (here == m - 2 and along > 1.0)
                side = 1.0 if ex * dy - ey * dx >= 0.0 else -1.0
                offset = np.nan if beyond else side * nearest
            if k == 0 and outside - np.hypot(x[i] - at_x, y[i] - at_y) > nearest + SLACK:
                k, end = low, high
        result[i] = offset
        if end == m - 1 and i >= retry and m > 4 * WINDOW:
            low, high = max(0, guess - WINDOW), min(m - 1, guess + WINDOW + 1)
            at_x, at_y, retry = x[i], y[i], i + RETRY
            outside = least_outside(at_x, at_y, line, low, high, longest)
    return result
