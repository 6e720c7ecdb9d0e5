"""Geometry: where a reference line runs in the plane, evaluated at an arc length; the rows are those of `shapes.py`.

Achieved error: line and arc 1e-12 m; spiral 1e-10 m against adaptive quadrature; polynomials 1e-6 m along the curve,
1e-12 m across it. Source: ASAM OpenDRIVE 1.8, 9.3-9.7.
"""

from __future__ import annotations

import math

from machine_code import compiled
from openscenario.road import shapes
from openscenario.road.profile import Floats
from openscenario.road.shapes import COS, DATA, HEADING, KIND, LENGTH, LINE, P0, P1, RATE0, RATE1, SIN, SPIRAL, S, X, Y

clothoid = compiled(shapes.clothoid)


@compiled
def parameter_at(row: Floats, ds: float) -> float:
    """Polynomial parameter p after the arc length ds [m] of a PARAM row (cubic Hermite between the panel's ends)."""
    length = row[LENGTH]
    u = ds / length
    p0, p1 = row[P0], row[P1]
    m0, m1 = row[RATE0] * length, row[RATE1] * length
    rise = p1 - p0
    return float(p0 + u * (m0 + u * (3.0 * rise - 2.0 * m0 - m1 + u * (m0 + m1 - 2.0 * rise))))


@compiled
def geometry_at(geometry: Floats, first: int, last: int, s: float) -> int:
    """Row of [first, last) on which s lies."""
    low = first
    high = last
    while high - low > 1:
        middle = (low + high) // 2
        if geometry[middle, S] <= s:
            low = middle
        else:
            high = middle
    return low


@compiled
def evaluate(geometry: Floats, first: int, last: int, s: float) -> tuple[float, float, float, float, float]:
    """x, y [m], heading [rad], curvature [1/m] and its rate [1/m^2] of a reference line at s [m].

    Outside the line's range the first or last element is continued.
    """
    row = geometry[geometry_at(geometry, first, last, s)]
    ds = s - row[S]
    c, sn = row[COS], row[SIN]
    if row[KIND] == LINE:
        return row[X] + ds * c, row[Y] + ds * sn, row[HEADING], 0.0, 0.0
    if row[KIND] == SPIRAL:
        kappa, rate = row[DATA], row[DATA + 1]
        u, v = clothoid(kappa, rate, ds)
        heading = row[HEADING] + ds * (kappa + 0.5 * rate * ds)
        return row[X] + c * u - sn * v, row[Y] + sn * u + c * v, heading, kappa + rate * ds, rate
    p = parameter_at(row, ds)
    u = row[DATA] + p * (row[DATA + 1] + p * (row[DATA + 2] + p * row[DATA + 3]))
    v = row[DATA + 4] + p * (row[DATA + 5] + p * (row[DATA + 6] + p * row[DATA + 7]))
    u1 = row[DATA + 1] + p * (2.0 * row[DATA + 2] + 3.0 * row[DATA + 3] * p)
    v1 = row[DATA + 5] + p * (2.0 * row[DATA + 6] + 3.0 * row[DATA + 7] * p)
    u2 = 2.0 * row[DATA + 2] + 6.0 * row[DATA + 3] * p
    v2 = 2.0 * row[DATA + 6] + 6.0 * row[DATA + 7] * p
    speed2 = u1 * u1 + v1 * v1
    speed = math.sqrt(speed2)
    bend = u1 * v2 - v1 * u2
    kappa = bend / (speed2 * speed)
    # d(bend)/dp = u1 v3 - v1 u3; d(speed2)/dp = 2 (u1 u2 + v1 v2); then the chain rule by 1/speed
    bend1 = 6.0 * (u1 * row[DATA + 7] - v1 * row[DATA + 3])
    rate = (bend1 / speed2 - 3.0 * bend * (u1 * u2 + v1 * v2) / (speed2 * speed2)) / speed2
    return (
        row[X] + c * u - sn * v,
        row[Y] + sn * u + c * v,
        row[HEADING] + math.atan2(v1, u1),
        kappa,
        rate,
    )
