"""Assignment: the pairing of rows and columns with the least total cost."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from vehicle.messages import FloatArray

FORBIDDEN = 1e6  # cost above that of every allowed pair


def assign(cost: FloatArray) -> NDArray[np.int64]:
    """Column (n,) for each row of `cost` (n, m), -1 for none; pairs that cost FORBIDDEN or more are never made."""
    result = np.full(len(cost), -1, np.int64)
    if cost.size:
        rows, columns = linear_sum_assignment(cost)
        allowed = cost[rows, columns] < FORBIDDEN
        result[rows[allowed]] = columns[allowed]
    return result
