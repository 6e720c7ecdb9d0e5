"""Profile: a quantity that varies along a road as piecewise cubics `a + b ds + c ds^2 + d ds^3`.

OpenDRIVE writes elevation, superelevation, lane offset, lane width and lane border this way. All records of a network
lie in one array, rows `(s, a, b, c, d)`; a profile is a half-open range of rows, sorted by s [m].
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from machine_code import compiled

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@compiled
def record_at(cubics: Floats, first: int, last: int, s: float) -> int:
    """Row that holds at s: the last one of [first, last) that begins at or before s, else the first."""
    low = first
    high = last
    while high - low > 1:
        middle = (low + high) // 2
        if cubics[middle, 0] <= s:
            low = middle
        else:
            high = middle
    return low


@compiled
def profile(cubics: Floats, first: int, last: int, s: float) -> tuple[float, float, float]:
    """Value, first and second derivative by s of a profile; zeros for an empty range or before its first record."""
    if last <= first or s < cubics[first, 0] - 1e-9:
        return 0.0, 0.0, 0.0
    row = record_at(cubics, first, last, s)
    ds = s - cubics[row, 0]
    a, b, c, d = cubics[row, 1], cubics[row, 2], cubics[row, 3], cubics[row, 4]
    value = a + ds * (b + ds * (c + ds * d))
    slope = b + ds * (2.0 * c + 3.0 * d * ds)
    return value, slope, 2.0 * c + 6.0 * d * ds
