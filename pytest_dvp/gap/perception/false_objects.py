"""Boxes that belong to no object, joined to false objects: one that stays for two seconds has appeared once."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linear_sum_assignment

from pytest_dvp.logs.log_contents import FloatArray

MEMORY = 0.5  # s without a box after which a false object has gone
REACH, FASTEST = 1.0, 10.0  # m, m/s: how far from its last box the next one of a false object may be


def appearances(t: FloatArray, x: FloatArray, y: FloatArray) -> int:
    """How many false objects appeared among boxes at t [s] (not sorted), x, y [m] on the map, arrays (n,).

    A box goes on with a false object if it is within REACH + FASTEST dt of where that one was seen last, dt <= MEMORY
    ago; the nearest ones belong together, and of one stamp each is another object. Two that appear by chance at one
    place so soon count as one: 1 to 2 % of them at 0.5 a second in a field of 1000 m^2, more at higher rates.
    """
    count = 0
    alive = np.zeros((0, 3))  # t, x, y of the last box of each
    for stamp in np.unique(t):
        here = np.column_stack([t, x, y])[t == stamp]
        alive = alive[stamp - alive[:, 0] <= MEMORY + 1e-9]
        far = np.hypot(here[:, None, 1] - alive[None, :, 1], here[:, None, 2] - alive[None, :, 2])
        cost = np.minimum(far / (REACH + FASTEST * (stamp - alive[:, 0])), 1.0)
        pairs = [(a, b) for a, b in zip(*linear_sum_assignment(cost), strict=True) if cost[a, b] < 1.0]
        count += len(here) - len(pairs)
        gone_on = [b for _, b in pairs]
        alive = np.concatenate([np.delete(alive, gone_on, axis=0), here])
    return count
