"""Compiled geometry of pairs of oriented boxes that move at constant velocity without turning.

A box is a row of x, y [m] of its middle, yaw [rad], length, width [m], vx, vy [m/s].
"""

from __future__ import annotations

import math

import numpy as np

from machine_code import compiled
from pytest_dvp.logs.log_contents import FloatArray

EDGE_TOLERANCE = 1e-9
"""m; a corner this far beyond the end of an edge still touches it, or rounding lets two flush boxes miss each other."""


@compiled(inline="always")
def _first_hit(x: float, y: float, wx: float, wy: float, a: float, b: float, best: float) -> float:
    """Least time >= 0 at which a corner at x, y with velocity wx, wy meets an edge of the box |x| <= a, |y| <= b.

    The corner starts outside; of two parallel edges only the one that faces the motion can be met first.
    """
    if wx != 0.0:
        time = ((-a if wx > 0.0 else a) - x) / wx
        if 0.0 <= time < best and abs(y + wy * time) <= b + EDGE_TOLERANCE:
            best = time
    if wy != 0.0:
        time = ((-b if wy > 0.0 else b) - y) / wy
        if 0.0 <= time < best and abs(x + wx * time) <= a + EDGE_TOLERANCE:
            best = time
    return best


@compiled
def pair_ttc(
    dx: float,
    dy: float,
    wx: float,
    wy: float,
    yaw_i: float,
    yaw_j: float,
    a: float,
    b: float,
    c: float,
    d: float,
) -> float:
    """Time [s] to the first contact of box i (half sizes a, b) and box j (half sizes c, d); inf if there is none.

    dx, dy [m], wx, wy [m/s]: position and velocity of j relative to i in the map frame. 0 if the boxes overlap.
    """
    # Circles round the boxes: who does not meet the circle meets no box. Exact, and it spares the trigonometry.
    reach = math.sqrt(a * a + b * b) + math.sqrt(c * c + d * d) + EDGE_TOLERANCE
    distance2 = dx * dx + dy * dy
    speed2 = wx * wx + wy * wy
    if distance2 > reach * reach:
        closing = dx * wx + dy * wy
        if closing >= 0.0:
            return math.inf
        cross = dx * wy - dy * wx
        if cross * cross > reach * reach * speed2:
            return math.inf
    ci, si = math.cos(yaw_i), math.sin(yaw_i)
    cj, sj = math.cos(yaw_j), math.sin(yaw_j)
    # Everything as seen from i (px, qx) and, from j, the way back (py, qy).
    px, py = ci * dx + si * dy, -si * dx + ci * dy
    qx, qy = -(cj * dx + sj * dy), sj * dx - cj * dy
    cr, sr = ci * cj + si * sj, ci * sj - si * cj  # yaw of j relative to i
    ac, as_ = abs(cr), abs(sr)
    if (
        abs(px) <= a + c * ac + d * as_
        and abs(py) <= b + c * as_ + d * ac
        and abs(qx) <= c + a * ac + b * as_
        and abs(qy) <= d + a * as_ + b * ac
    ):
        return 0.0
    if speed2 == 0.0:
        return math.inf
    best = math.inf
    # Every corner of j against every edge of i.
    ux, uy = ci * wx + si * wy, -si * wx + ci * wy
    e0, e1, f0, f1 = c * cr, c * sr, -d * sr, d * cr
    best = _first_hit(px + e0 + f0, py + e1 + f1, ux, uy, a, b, best)
    best = _first_hit(px + e0 - f0, py + e1 - f1, ux, uy, a, b, best)
    best = _first_hit(px - e0 + f0, py - e1 + f1, ux, uy, a, b, best)
    best = _first_hit(px - e0 - f0, py - e1 - f1, ux, uy, a, b, best)
    # Every corner of i against every edge of j, which sees i come with the opposite velocity.
    ux, uy = -(cj * wx + sj * wy), sj * wx - cj * wy
    e0, e1, f0, f1 = a * cr, -a * sr, b * sr, b * cr
    best = _first_hit(qx + e0 + f0, qy + e1 + f1, ux, uy, c, d, best)
    best = _first_hit(qx + e0 - f0, qy + e1 - f1, ux, uy, c, d, best)
    best = _first_hit(qx - e0 + f0, qy - e1 + f1, ux, uy, c, d, best)
    return _first_hit(qx - e0 - f0, qy - e1 - f1, ux, uy, c, d, best)


@compiled
def time_to_collision(boxes_i: FloatArray, boxes_j: FloatArray) -> FloatArray:
    """Time to collision [s] of n pairs: arrays (n, 7) of boxes -> (n,); inf if they never meet, 0 if they overlap.

    Source: Arango et al., Sensors 2026, 26, 1338 (corner against edge, both ways); a separating-axis overlap test goes
    before it, because crossing boxes may have no corner inside each other.
    """
    n = boxes_i.shape[0]
    result = np.empty(n)
    for k in range(n):
        result[k] = pair_ttc(
            boxes_j[k, 0] - boxes_i[k, 0],
            boxes_j[k, 1] - boxes_i[k, 1],
            boxes_j[k, 5] - boxes_i[k, 5],
            boxes_j[k, 6] - boxes_i[k, 6],
            boxes_i[k, 2],
            boxes_j[k, 2],
            0.5 * boxes_i[k, 3],
            0.5 * boxes_i[k, 4],
            0.5 * boxes_j[k, 3],
            0.5 * boxes_j[k, 4],
        )
    return result
