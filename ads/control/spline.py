"""Cubic spline through waypoints, sampled to a dense path.

Source: de Boor, A Practical Guide to Splines (1978), ch. IV: natural cubic spline, chord-length parameter.
"""

from __future__ import annotations

import math

import numpy as np

from machine_code import compiled
from vehicle.messages import FloatArray

COLUMNS = 6  # as named below
S, X, Y, YAW, KAPPA, SPEED = range(COLUMNS)
"""Columns of a path: arc length [m], position [m], heading [rad], curvature [1/m], speed limit [m/s]."""


@compiled
def second_derivatives(u: FloatArray, f: FloatArray) -> FloatArray:
    """Second derivatives (n,) at the knots `u` (n,) of the natural cubic spline through `f` (n,).

    In the unit of f divided by that of u squared.
    """
    n = len(u)
    m, c, d = np.zeros(n), np.zeros(n), np.zeros(n)
    for i in range(1, n - 1):
        h0, h1 = u[i] - u[i - 1], u[i + 1] - u[i]
        rhs = 6.0 * ((f[i + 1] - f[i]) / h1 - (f[i] - f[i - 1]) / h0)
        pivot = 2.0 * (h0 + h1) - h0 * c[i - 1]
        c[i] = h1 / pivot
        d[i] = (rhs - h0 * d[i - 1]) / pivot
    for i in range(n - 2, 0, -1):
        m[i] = d[i] - c[i] * m[i + 1]
    return m


@compiled
def at_knot(h: float, a: float, f0: float, f1: float, m0: float, m1: float) -> tuple[float, float, float]:
    """Value, first and second derivative at distance `a` into an interval of length `h` between two knots."""
    slope = (f1 - f0) / h - h * (2.0 * m0 + m1) / 6.0
    jerk = (m1 - m0) / h
    value = f0 + a * (slope + a * (0.5 * m0 + a * jerk / 6.0))
    return value, slope + a * (m0 + 0.5 * a * jerk), m0 + a * jerk


@compiled
def spline_path(waypoints: FloatArray, step: float) -> FloatArray:
    """Dense path (n, COLUMNS), spacing about `step` [m], through `waypoints` (k, 2) [m], k >= 2, all distinct.

    Heading is continuous (unwrapped). Curvature at both ends is zero (natural spline). The speed column is zero.
    """
    k = len(waypoints)
    u = np.zeros(k)
    for i in range(1, k):
        u[i] = u[i - 1] + math.hypot(waypoints[i, 0] - waypoints[i - 1, 0], waypoints[i, 1] - waypoints[i - 1, 1])
    wx, wy = np.empty(k), np.empty(k)
    for i in range(k):
        wx[i], wy[i] = waypoints[i, 0], waypoints[i, 1]
    mx, my = second_derivatives(u, wx), second_derivatives(u, wy)
    n = max(int(u[k - 1] / step + 0.5), 1) + 1
    path = np.zeros((n, COLUMNS))
    j = 0
    for i in range(n):
        a = u[k - 1] * i / (n - 1)
        while j < k - 2 and a > u[j + 1]:
            j += 1
        h = u[j + 1] - u[j]
        x, dx, ddx = at_knot(h, a - u[j], wx[j], wx[j + 1], mx[j], mx[j + 1])
        y, dy, ddy = at_knot(h, a - u[j], wy[j], wy[j + 1], my[j], my[j + 1])
        path[i, X], path[i, Y] = x, y
        yaw = math.atan2(dy, dx)
        if i > 0:
            path[i, S] = path[i - 1, S] + math.hypot(x - path[i - 1, X], y - path[i - 1, Y])
            yaw += 2.0 * math.pi * math.floor((path[i - 1, YAW] - yaw) / (2.0 * math.pi) + 0.5)
        path[i, YAW] = yaw
        path[i, KAPPA] = (dx * ddy - dy * ddx) / max((dx * dx + dy * dy) ** 1.5, 1e-9)
    return path


@compiled
def project(path: FloatArray, x: float, y: float, hint: int, window: int) -> tuple[int, float, float]:
    """Nearest point of a path (n, COLUMNS): index of its segment, arc length [m] and lateral offset [m], left positive.

    Looks at `window` points on both sides of `hint`; hint < 0 looks everywhere. Before the first and after the last
    point the path goes on straight.
    """
    n = len(path)
    first, last = 0, n - 1
    if hint >= 0:
        first, last = max(0, hint - window), min(n - 1, hint + window)
    best, where = 1e300, first
    for i in range(first, last + 1):
        dx, dy = x - path[i, X], y - path[i, Y]
        d = dx * dx + dy * dy
        if d < best:
            best, where = d, i
    i = min(where, n - 2)
    if where > 0:  # the foot may lie on the segment before the nearest point
        ahead = (x - path[where, X]) * math.cos(path[where, YAW]) + (y - path[where, Y]) * math.sin(path[where, YAW])
        if ahead < 0.0:
            i = where - 1
    ex, ey = path[i + 1, X] - path[i, X], path[i + 1, Y] - path[i, Y]
    length = max(math.hypot(ex, ey), 1e-9)
    dx, dy = x - path[i, X], y - path[i, Y]
    along = (dx * ex + dy * ey) / length
    if i > 0:
        along = max(along, 0.0)
    if i < n - 2:
        along = min(along, length)
    ds = path[i + 1, S] - path[i, S]
    px, py = path[i, X] + ex * along / length, path[i, Y] + ey * along / length
    side = (ex * (y - py) - ey * (x - px)) / length
    return i, path[i, S] + along * ds / length, side


@compiled
def sample(path: FloatArray, index: int, s: float) -> tuple[float, float, float, float, float]:
    """x, y [m], heading [rad], curvature [1/m], speed [m/s] of a path (n, COLUMNS) at arc length `s` [m].

    `index` is a segment near `s`, where the search begins.
    """
    n = len(path)
    i = min(max(index, 0), n - 2)
    while i < n - 2 and s > path[i + 1, S]:
        i += 1
    while i > 0 and s < path[i, S]:
        i -= 1
    r = (s - path[i, S]) / max(path[i + 1, S] - path[i, S], 1e-9)
    q = min(max(r, 0.0), 1.0)
    return (
        path[i, X] + r * (path[i + 1, X] - path[i, X]),
        path[i, Y] + r * (path[i + 1, Y] - path[i, Y]),
        path[i, YAW] + q * (path[i + 1, YAW] - path[i, YAW]),
        path[i, KAPPA] + q * (path[i + 1, KAPPA] - path[i, KAPPA]),
        path[i, SPEED] + q * (path[i + 1, SPEED] - path[i, SPEED]),
    )


@compiled
def shifted(reference: FloatArray, first: int, offsets: FloatArray) -> FloatArray:
    """A copy of a path moved sideways by `offsets` (k,) [m], left positive, from point `first` on.

    Keeps the arc length of the reference as its own column S, so that distances stay those along the reference.
    """
    path = reference.copy()
    n, k = len(path), len(offsets)
    last = min(n, first + k)
    for i in range(first, last):
        o = offsets[i - first]
        path[i, X] = reference[i, X] - o * math.sin(reference[i, YAW])
        path[i, Y] = reference[i, Y] + o * math.cos(reference[i, YAW])
    for i in range(max(first - 2, 1), min(last + 2, n - 1)):
        ax, ay = path[i, X] - path[i - 1, X], path[i, Y] - path[i - 1, Y]
        bx, by = path[i + 1, X] - path[i, X], path[i + 1, Y] - path[i, Y]
        a, b = math.hypot(ax, ay), math.hypot(bx, by)
        turn = math.atan2(ax * by - ay * bx, ax * bx + ay * by)
        path[i, KAPPA] = 2.0 * turn / max(a + b, 1e-9)
        yaw = math.atan2(ay / max(a, 1e-9) + by / max(b, 1e-9), ax / max(a, 1e-9) + bx / max(b, 1e-9))
        path[i, YAW] = yaw + 2.0 * math.pi * math.floor((reference[i, YAW] - yaw) / (2.0 * math.pi) + 0.5)
    return path
