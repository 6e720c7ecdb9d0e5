"""Assignment: the pairing of rows and columns with the least total cost.

Source: Kuhn, The Hungarian method for the assignment problem, Naval Research Logistics 2 (1955), in the O(n^2 m) form
with potentials.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ads.compiled import compiled
from vehicle.messages import FloatArray

FORBIDDEN = 1e6


@compiled
def assign(cost: FloatArray) -> NDArray[np.int64]:
    """Column (n,) for each row of `cost` (n, m), -1 for none; pairs that cost FORBIDDEN or more are never made."""
    rows, columns = cost.shape
    n, m = rows, max(rows, columns)
    result = np.full(rows, -1, np.int64)
    if rows == 0 or columns == 0:
        return result
    u, v = np.zeros(n + 1), np.zeros(m + 1)
    p, way = np.zeros(m + 1, np.int64), np.zeros(m + 1, np.int64)
    for i in range(1, n + 1):
        p[0] = i
        j0 = 0
        least = np.full(m + 1, 1e300)
        used = np.zeros(m + 1, np.uint8)
        while True:
            used[j0] = 1
            i0, delta, j1 = p[j0], 1e300, 0
            for j in range(1, m + 1):
                if used[j] == 1:
                    continue
                c = cost[i0 - 1, j - 1] if j <= columns else FORBIDDEN
                value = min(c, FORBIDDEN) - u[i0] - v[j]
                if value < least[j]:
                    least[j] = value
                    way[j] = j0
                if least[j] < delta:
                    delta = least[j]
                    j1 = j
            for j in range(m + 1):
                if used[j] == 1:
                    u[p[j]] += delta
                    v[j] -= delta
                else:
                    least[j] -= delta
            j0 = j1
            if p[j0] == 0:
                break
        while j0 != 0:
            p[j0] = p[way[j0]]
            j0 = way[j0]
    for j in range(1, columns + 1):
        if p[j] > 0 and cost[p[j] - 1, j - 1] < FORBIDDEN:
            result[p[j] - 1] = j - 1
    return result
