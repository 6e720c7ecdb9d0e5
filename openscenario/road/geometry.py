"""Geometry: where a reference line runs in the plane, evaluated at an arc length.

A geometry element becomes one or more rows of a flat array, so that every evaluation costs the same: a long spiral or
polynomial is cut into panels, each short enough for a fixed quadrature or interpolation.

Columns: s, x, y, heading at the row's start; length; kind; cos and sin of the heading; then by kind
    LINE   -
    SPIRAL curvature at the start [1/m], curvature rate [1/m^2] (an arc has rate 0)
    PARAM  aU bU cU dU aV bV cV dV; p at start and end; dp/ds at start and end
Sources: ASAM OpenDRIVE 1.8, 9.3-9.7. Achieved error: line, arc 1e-12 m; spiral 1e-10 m against adaptive quadrature;
polynomials 1e-6 m along the curve, 1e-12 m across it.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from openscenario.road.profile import Floats

S, X, Y, HEADING, LENGTH, KIND, COS, SIN, DATA = range(9)
P0, P1, RATE0, RATE1 = 16, 17, 18, 19
COLUMNS = 20
LINE, SPIRAL, PARAM = 0.0, 1.0, 2.0

# Six-point Gauss-Legendre nodes and weights on [0, 1]: over at most 1 rad of turning the error is below 1e-14 of the length.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(6)
NODES = tuple(float(0.5 * (node + 1.0)) for node in _NODES)
WEIGHTS = tuple(float(0.5 * weight) for weight in _WEIGHTS)
MAX_TURN = 1.0  # rad, turning of one spiral panel
MAX_PANELS = 4096
MAX_PARAM_ERROR = 1e-7  # m, error of the arc length inversion at a panel's middle


@njit(cache=True, error_model="numpy")
def clothoid(kappa: float, rate: float, s: float) -> tuple[float, float]:
    """Displacement (along, across) [m] of a curve that starts along x with curvature kappa and rate, after s [m].

    Valid while the heading turns by at most about 1 rad.
    """
    if rate == 0.0:
        half = 0.5 * kappa * s
        chord = s if abs(half) < 1e-9 else s * math.sin(half) / half
        return chord * math.cos(half), chord * math.sin(half)
    x = 0.0
    y = 0.0
    for i in range(6):
        u = NODES[i] * s
        angle = u * (kappa + 0.5 * rate * u)
        x += WEIGHTS[i] * math.cos(angle)
        y += WEIGHTS[i] * math.sin(angle)
    return x * s, y * s


@njit(cache=True, error_model="numpy")
def parameter_at(row: Floats, ds: float) -> float:
    """Polynomial parameter p after the arc length ds [m] of a PARAM row (cubic Hermite between the panel's ends)."""
    length = row[LENGTH]
    u = ds / length
    p0, p1 = row[P0], row[P1]
    m0, m1 = row[RATE0] * length, row[RATE1] * length
    rise = p1 - p0
    return float(p0 + u * (m0 + u * (3.0 * rise - 2.0 * m0 - m1 + u * (m0 + m1 - 2.0 * rise))))


@njit(cache=True, error_model="numpy")
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


@njit(cache=True, error_model="numpy")
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


def line_rows(s: float, x: float, y: float, heading: float, length: float) -> list[list[float]]:
    """Rows of a straight line."""
    return [[s, x, y, heading, length, LINE, math.cos(heading), math.sin(heading)] + [0.0] * (COLUMNS - DATA)]


def arc_rows(s: float, x: float, y: float, heading: float, length: float, curvature: float) -> list[list[float]]:
    """Rows of a circular arc, curvature [1/m] > 0 to the left."""
    row = [s, x, y, heading, length, SPIRAL, math.cos(heading), math.sin(heading), curvature]
    return [row + [0.0] * (COLUMNS - len(row))]


def spiral_rows(
    s: float, x: float, y: float, heading: float, length: float, start: float, end: float
) -> list[list[float]]:
    """Rows of an Euler spiral whose curvature goes linearly from `start` to `end` [1/m], any signs."""
    rate = (end - start) / length
    if rate == 0.0:
        return arc_rows(s, x, y, heading, length, start)
    # |turning| is bounded by the larger end curvature over the whole length, also when the sign changes between
    panels = min(MAX_PANELS, max(1, math.ceil(max(abs(start), abs(end)) * length / MAX_TURN)))
    part = length / panels
    rows = []
    for index in range(panels):
        kappa = start + rate * part * index
        c, sn = math.cos(heading), math.sin(heading)
        row = [s + part * index, x, y, heading, part, SPIRAL, c, sn, kappa, rate]
        rows.append(row + [0.0] * (COLUMNS - len(row)))
        u, v = clothoid.py_func(kappa, rate, part)
        x, y = x + c * u - sn * v, y + sn * u + c * v
        heading += part * (kappa + 0.5 * rate * part)
    return rows


def _speeds(coefficients: Floats, p: Floats) -> Floats:
    """|d(u, v)/dp| at the parameters p."""
    _, bu, cu, du, _, bv, cv, dv = coefficients
    return np.hypot(bu + p * (2.0 * cu + 3.0 * du * p), bv + p * (2.0 * cv + 3.0 * dv * p))


def _arc_lengths(coefficients: Floats, ends: Floats) -> Floats:
    """Arc length [m] of each panel between successive parameters."""
    nodes = ends[:-1, None] + np.diff(ends)[:, None] * np.asarray(NODES)
    return np.asarray((_speeds(coefficients, nodes) * np.asarray(WEIGHTS)).sum(axis=1) * np.diff(ends))


def param_rows(
    s: float, x: float, y: float, heading: float, length: float, coefficients: tuple[float, ...], p_end: float
) -> list[list[float]]:
    """Rows of a paramPoly3 with coefficients aU bU cU dU aV bV cV dV over p in [0, p_end].

    s is the arc length: p follows from it by inverting the length integral. Where the polynomial's length is not the
    element's `length` [m], s is scaled, so that the element ends where the polynomial ends.
    """
    coefs = np.asarray(coefficients, dtype=np.float64)
    panels = 4
    while True:
        ends = np.linspace(0.0, p_end, panels + 1)
        lengths = _arc_lengths(coefs, ends)
        total = float(lengths.sum())
        scale = length / total if total > 0.0 else 1.0
        speeds = np.maximum(_speeds(coefs, ends), 1e-12)
        rates = 1.0 / (speeds * scale)
        parts = np.maximum(lengths * scale, 1e-12)
        middle = 0.5 * (ends[:-1] + ends[1:]) + (rates[:-1] - rates[1:]) * parts / 8.0
        halves = np.empty(2 * panels + 1)
        halves[::2] = ends
        halves[1::2] = middle
        error = np.abs(_arc_lengths(coefs, halves)[::2] - 0.5 * lengths).max()
        if error < MAX_PARAM_ERROR or panels >= MAX_PANELS // 4:
            break
        panels *= 2
    c, sn = math.cos(heading), math.sin(heading)
    starts = s + np.concatenate(([0.0], np.cumsum(parts)[:-1]))
    return [
        [float(starts[i]), x, y, heading, float(parts[i]), PARAM, c, sn, *map(float, coefs)]
        + [float(ends[i]), float(ends[i + 1]), float(rates[i]), float(rates[i + 1])]
        for i in range(panels)
    ]


def poly3_rows(
    s: float, x: float, y: float, heading: float, length: float, a: float, b: float, c: float, d: float
) -> list[list[float]]:
    """Rows of a poly3 `v = a + b u + c u^2 + d u^3`; u runs until the curve is `length` [m] long."""
    coefs = (0.0, 1.0, 0.0, 0.0, a, b, c, d)
    low, high = 0.0, length  # the curve is never shorter than its projection on u
    for _ in range(60):
        middle = 0.5 * (low + high)
        if _arc_lengths(np.asarray(coefs), np.linspace(0.0, middle, 33)).sum() < length:
            low = middle
        else:
            high = middle
    return param_rows(s, x, y, heading, length, coefs, 0.5 * (low + high))
