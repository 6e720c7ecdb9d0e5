"""Shapes: the elements of a reference line as rows of numbers; plain Python, for the reader, the rules and the tables.

A geometry element becomes one or more rows, so that every evaluation costs the same: a long spiral or polynomial is cut
into panels, each short enough for a fixed quadrature or interpolation (`geometry.py` evaluates them, compiled).

Columns: s, x, y, heading at the row's start; length; kind; cos and sin of the heading; then by kind
    LINE   -
    SPIRAL curvature at the start [1/m], curvature rate [1/m^2] (an arc has rate 0)
    PARAM  aU bU cU dU aV bV cV dV; p at start and end; dp/ds at start and end
Source: ASAM OpenDRIVE 1.8, 9.3-9.7.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from openscenario.road.elements import Geometry

Floats = NDArray[np.float64]

S, X, Y, HEADING, LENGTH, KIND, COS, SIN, DATA = range(9)
P0, P1, RATE0, RATE1 = 16, 17, 18, 19
COLUMNS = 20  # of a geometry row, named above and below
LINE, SPIRAL, PARAM = 0.0, 1.0, 2.0

# Six-point Gauss-Legendre nodes and weights on [0, 1]: over 1 rad of turning the error is below 1e-14 of the way.
NODES = (
    0.03376524289842398609,
    0.16939530676686774318,
    0.38069040695840154568,
    0.61930959304159845432,
    0.83060469323313225682,
    0.96623475710157601391,
)
WEIGHTS = (
    0.08566224618958517252,
    0.18038078652406930378,
    0.23395696728634552370,
    0.23395696728634552370,
    0.18038078652406930378,
    0.08566224618958517252,
)
MAX_TURN = 1.0  # rad, turning of one spiral panel
MAX_PANELS = 4096  # of one geometry row; chosen, not measured: it bounds memory
MAX_PARAM_ERROR = 1e-7  # m, error of the arc length inversion at a panel's middle


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


def geometry_rows(geometry: Geometry) -> list[list[float]]:
    """Rows of one geometry element."""
    start = (geometry.s, geometry.x, geometry.y, geometry.hdg, geometry.length)
    values = geometry.values
    match geometry.kind:
        case "line":
            return line_rows(*start)
        case "arc":
            return arc_rows(*start, values[0])
        case "spiral":
            return spiral_rows(*start, values[0], values[1])
        case "poly3":
            return poly3_rows(*start, (values[0], values[1], values[2], values[3]))
        case "paramPoly3":
            return param_rows(*start, values, 1.0 if geometry.normalized else geometry.length)


def row_end(row: list[float]) -> tuple[float, float, float]:
    """x, y [m] and heading [rad] at the end of a row."""
    x, y, heading, length, c, sn = row[X], row[Y], row[HEADING], row[LENGTH], row[COS], row[SIN]
    if row[KIND] == PARAM:
        a_u, b_u, c_u, d_u, a_v, b_v, c_v, d_v = row[DATA : DATA + 8]
        p = row[P1]
        u, v = a_u + p * (b_u + p * (c_u + p * d_u)), a_v + p * (b_v + p * (c_v + p * d_v))
        turn = math.atan2(b_v + p * (2.0 * c_v + 3.0 * p * d_v), b_u + p * (2.0 * c_u + 3.0 * p * d_u))
    else:
        kappa, rate = (0.0, 0.0) if row[KIND] == LINE else (row[DATA], row[DATA + 1])
        u, v = clothoid(kappa, rate, length)
        turn = length * (kappa + 0.5 * rate * length)
    return x + c * u - sn * v, y + sn * u + c * v, heading + turn


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
        u, v = clothoid(kappa, rate, part)
        x, y = x + c * u - sn * v, y + sn * u + c * v
        heading += part * (kappa + 0.5 * rate * part)
    return rows


def _speeds(coefficients: Floats, p: Floats) -> Floats:
    """|d(u, v)/dp| at the parameters p."""
    _, bu, cu, du, _, bv, cv, dv = coefficients
    return np.asarray(np.hypot(bu + p * (2.0 * cu + 3.0 * du * p), bv + p * (2.0 * cv + 3.0 * dv * p)))


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
        [
            *(float(starts[i]), x, y, heading, float(parts[i]), PARAM, c, sn),
            *map(float, coefs),
            *(float(ends[i]), float(ends[i + 1]), float(rates[i]), float(rates[i + 1])),
        ]
        for i in range(panels)
    ]


def poly3_rows(
    s: float, x: float, y: float, heading: float, length: float, coefficients: tuple[float, float, float, float]
) -> list[list[float]]:
    """Rows of a poly3 `v = a + b u + c u^2 + d u^3` with coefficients a, b, c, d; u runs until the curve is `length`
    [m] long."""
    coefs = (0.0, 1.0, 0.0, 0.0, *coefficients)
    low, high = 0.0, length  # the curve is never shorter than its projection on u
    for _ in range(60):
        middle = 0.5 * (low + high)
        if _arc_lengths(np.asarray(coefs), np.linspace(0.0, middle, 33)).sum() < length:
            low = middle
        else:
            high = middle
    return param_rows(s, x, y, heading, length, coefs, 0.5 * (low + high))
