"""The start of each segment taken out of its residuals: one compiled pass over a log."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from machine_code import compiled
from pytest_dvp.logs.log_contents import FloatArray

IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

_STOPPED = 1e-3  # m/s: once the model stands, a wrong start speed has no effect any more
_CREEP = 0.5  # m/s, below which the curvature r/v is not taken from the model


@compiled
def project(output: FloatArray, measured: FloatArray, t: FloatArray, weight: FloatArray, starts: IntArray,
            ends: IntArray, counted: BoolArray, free_speed: bool, values: FloatArray, start: FloatArray,
            chi2: FloatArray, count: IntArray) -> None:  # fmt: skip
    """Fill values (n, 8), start (m, 4), chi2 (8,) as sums and count (8,); see `segments.residuals`, also for the units.

    Two sweeps a segment: the first gathers the normal equations of the start, the second takes its effect out.
    """
    values[:] = np.nan
    reach, left = np.empty((values.shape[0], 5)), np.empty(8)
    for j in range(len(starts)):
        first, end = starts[j], ends[j]
        _reach(output, t, first, end, free_speed, reach)
        p = _start(output, measured, weight, first, end, counted, reach)
        x0, y0 = output[first, 0], output[first, 1]
        for i in range(first, end):
            if not counted[i]:
                continue
            a, b = measured[i], output[i]
            turn = a[2] - b[2]
            turn -= 2.0 * np.pi * np.rint(turn / (2.0 * np.pi))
            left[0] = (a[0] - b[0]) - (p[0] + (y0 - b[1]) * p[2] + reach[i, 0] * p[3])
            left[1] = (a[1] - b[1]) - (p[1] + (b[0] - x0) * p[2] + reach[i, 1] * p[3])
            left[2] = turn - (p[2] + reach[i, 2] * p[3])
            left[3] = (a[3] - b[3]) - reach[i, 3] * p[3]
            left[4] = (a[4] - b[4]) - reach[i, 4] * p[3]
            left[5] = np.nan if _stops(output, i, first, end) else a[5] - b[5]
            left[6] = (a[6] - b[6]) - 2.0 * b[4] * reach[i, 3] * p[3]
            left[7] = a[7] - b[7]
            for k in range(8):
                if np.isfinite(left[k]):
                    values[i, k] = left[k]
                    if weight[k] > 0.0:
                        chi2[k] += (left[k] * weight[k]) ** 2
                        count[k] += 1
        for k in range(4):
            start[j, k] = p[k]


@compiled
def _reach(output: FloatArray, t: FloatArray, first: int, end: int, free_speed: bool, reach: FloatArray) -> None:
    """Fill reach (n, 5), rows first..end: what 1 m/s more at the start has done to x, y, yaw, speed and yaw rate."""
    gx, gy, gyaw = 0.0, 0.0, 0.0
    moving = free_speed
    rate_before, gain_before, speed_before = 0.0, 0.0, 0.0
    yaw_before = output[first, 2]
    for i in range(first, end):
        v, rate = output[i, 3], output[i, 4]
        if abs(v) < _STOPPED and i > first:
            moving = False
        gain = 1.0 if moving else 0.0
        turn = rate / v if moving and abs(v) > _CREEP else 0.0
        if i > first:
            dt = t[i] - t[i - 1]
            mid_yaw = 0.5 * (output[i, 2] + yaw_before)
            mid_gain = 0.5 * (gain + gain_before)
            c, s = np.cos(mid_yaw), np.sin(mid_yaw)
            half = 0.25 * dt * (turn + rate_before)
            gyaw += half
            mid_speed = 0.5 * (v + speed_before)
            gx += dt * (c * mid_gain - s * mid_speed * gyaw)
            gy += dt * (s * mid_gain + c * mid_speed * gyaw)
            gyaw += half
        rate_before, gain_before, speed_before, yaw_before = turn, gain, v, output[i, 2]
        reach[i, 0], reach[i, 1], reach[i, 2], reach[i, 3], reach[i, 4] = gx, gy, gyaw, gain, turn


@compiled
def _start(output: FloatArray, measured: FloatArray, weight: FloatArray, first: int, end: int, counted: BoolArray,
           reach: FloatArray) -> FloatArray:  # fmt: skip
    """(4,) x, y, yaw and speed to add to a segment's start, by least squares over its rows."""
    a, b, p = np.zeros((4, 4)), np.zeros(4), np.zeros(4)
    x0, y0 = output[first, 0], output[first, 1]
    for i in range(first, end):
        if not counted[i]:
            continue
        o = output[i]
        for k in range(7):
            e = measured[i, k] - o[k]
            w = weight[k] * weight[k]
            if k == 5 or not w > 0.0 or not np.isfinite(e):
                continue
            turned = 0.0  # what 1 rad more at the start has done
            if k == 0:
                turned = y0 - o[1]
            elif k == 1:
                turned = o[0] - x0
            elif k == 2:
                e -= 2.0 * np.pi * np.rint(e / (2.0 * np.pi))
                turned = 1.0
            faster = reach[i, k] if k < 5 else 2.0 * o[4] * reach[i, 3]
            if k < 2:
                a[k, k] += w
                a[k, 2] += w * turned
                a[k, 3] += w * faster
                b[k] += w * e
            if k < 3:
                a[2, 2] += w * turned * turned
                a[2, 3] += w * turned * faster
                b[2] += w * turned * e
            a[3, 3] += w * faster * faster
            b[3] += w * faster * e
    _solve(a, b, p)
    return p


@compiled
def _stops(output: FloatArray, i: int, first: int, end: int) -> bool:
    """True within a row of where the model comes to rest: a start speed 1 cm/s off moves that by a row, and one row of
    full deceleration is dozens of sigma."""
    for row in range(max(i - 1, first + 1), min(i + 2, end)):
        if abs(output[row, 3]) < _STOPPED <= abs(output[row - 1, 3]):
            return True
    return False


@compiled
def _solve(a: FloatArray, b: FloatArray, p: FloatArray) -> None:
    """Solve the symmetric system a p = b (upper triangle given); what the data do not determine stays 0."""
    n = len(b)
    low = np.zeros((n, n))
    for i in range(n):
        for j in range(i + 1):
            left = a[j, i]
            for k in range(j):
                left -= low[i, k] * low[j, k]
            if i == j:
                low[i, i] = np.sqrt(left) if left > 1e-9 * a[i, i] and a[i, i] > 0.0 else 0.0
            else:
                low[i, j] = left / low[j, j] if low[j, j] > 0.0 else 0.0
    for i in range(n):
        left = b[i]
        for k in range(i):
            left -= low[i, k] * p[k]
        p[i] = left / low[i, i] if low[i, i] > 0.0 else 0.0
    for i in range(n - 1, -1, -1):
        left = p[i]
        for k in range(i + 1, n):
            left -= low[k, i] * p[k]
        p[i] = left / low[i, i] if low[i, i] > 0.0 else 0.0
