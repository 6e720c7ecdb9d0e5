"""Compiled distance of points to a polyline."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from machine_code import compiled
from pytest_dvp.logs.log_contents import FloatArray

Indices: TypeAlias = NDArray[np.int64]

NEAR = 1.0  # m that a point may move until the segments that could be nearest to it are gathered anew
RETRY = 64  # points until they are gathered again, where those before served no other point
# Both chosen by measuring, on lines of 0.2 to 10 km in steps of 0.5 and 1 m with rows at 100 Hz: 0.7 to 1.1 times the
# time of a window of 65 segments, and a quarter of it on a line of 2 km that lies on itself.
SLACK = 1e-6  # m, far above what rounding does to a distance on a road


@compiled
def gather(x: float, y: float, line: FloatArray, reach: float, longest: float, close: Indices) -> int:
    """How many segments of `line` (m, 2) begin within `reach` [m] of a point; `close` (m - 1,) gets which, in order.
    longest: of the segments [m], more than 0."""
    count, k = 0, 0
    while k < line.shape[0] - 1:
        beyond = np.hypot(x - line[k, 0], y - line[k, 1]) - reach
        if beyond <= 0.0:
            close[count] = k
            count += 1
            k += 1
        else:  # each segment comes at most `longest` nearer
            k += max(1, int(min(beyond / longest, float(line.shape[0]))))
    return count


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
    # Seen from within NEAR of (at_x, at_y) [m], the nearest segment is among the first `count` of `close`.
    close, count = np.empty(m - 1, dtype=np.int64), 0
    at_x, at_y, guess, retry = np.nan, np.nan, 0, 0
    for i in range(n):
        best, nearest, offset = np.inf, np.inf, np.nan
        known = (x[i] - at_x) ** 2 + (y[i] - at_y) ** 2 <= NEAR * NEAR
        if known:
            retry = 0
        # The last nearest segment first: it gives a bound that skips almost all others.
        k, end = -1, count if known else m - 1
        while k < end:
            here = guess if k < 0 else close[k] if known else k
            k += 1
            dx, dy = x[i] - line[here, 0], y[i] - line[here, 1]
            spare = np.sqrt(dx * dx + dy * dy) - nearest - longest
            if spare > 0.0:
                if not known:
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
        result[i] = offset
        if not known and i >= retry and nearest < np.inf:
            at_x, at_y, retry = x[i], y[i], i + RETRY
            # Until the point has moved by NEAR, others come that much nearer, and what is nearest goes that far away.
            count = gather(at_x, at_y, line, nearest + longest + 2.0 * NEAR + SLACK, longest, close)
    return result
