"""The start of each segment taken out of its residuals: one compiled pass over a log."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from pytest_dvp.log import FloatArray

IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

_STOPPED = 1e-3  # m/s: once the model stands, a wrong start speed has no effect any more
_CREEP = 0.5  # m/s, below which the curvature r/v is not taken from the model


@njit(cache=True, error_model="numpy")
def project(output: FloatArray, measured: FloatArray, t: FloatArray, weight: FloatArray, starts: IntArray,
             ends: IntArray, counted: BoolArray, free_speed: bool, values: FloatArray, start: FloatArray,
             chi2: FloatArray, count: IntArray) -> None:  # fmt: skip
    """Fill values (n, 8), start (m, 4), chi2 (8,) as sums and count (8,); see `segments.residuals`.

    Two sweeps a segment: the first gathers the normal equations of the start, the second takes its effect out.
    """
    g = np.zeros(3)  # what 1 m/s more at the start has done to x, y, yaw so far
    for i in range(values.shape[0]):
        for k in range(8):
            values[i, k] = np.nan
    for j in range(len(starts)):
        a = np.zeros((4, 4))
        b = np.zeros(4)
        x0, y0 = output[starts[j], 0], output[starts[j], 1]
        p = np.zeros(4)
        for sweep in range(2):
            g[:] = 0.0
            moving = free_speed
            rate_before, gain_before, speed_before = 0.0, 0.0, 0.0
            yaw_before = output[starts[j], 2]
            for i in range(starts[j], ends[j]):
                v, rate = output[i, 3], output[i, 4]
                if abs(v) < _STOPPED and i > starts[j]:
                    moving = False
                gain = 1.0 if moving else 0.0
                turn = rate / v if moving and abs(v) > _CREEP else 0.0
                if i > starts[j]:
                    dt = t[i] - t[i - 1]
                    mid_yaw = 0.5 * (output[i, 2] + yaw_before)
                    mid_gain = 0.5 * (gain + gain_before)
                    c, s = np.cos(mid_yaw), np.sin(mid_yaw)
                    half = 0.25 * dt * (turn + rate_before)
                    g[2] += half
                    mid_speed = 0.5 * (v + speed_before)
                    g[0] += dt * (c * mid_gain - s * mid_speed * g[2])
                    g[1] += dt * (s * mid_gain + c * mid_speed * g[2])
                    g[2] += half
                rate_before, gain_before, speed_before, yaw_before = turn, gain, v, output[i, 2]
                if not counted[i]:
                    continue
                stops = _stops(output, i, starts[j], ends[j])
                for k in range(8):
                    e = measured[i, k] - output[i, k]
                    if k == 2:
                        e -= 2.0 * np.pi * np.rint(e / (2.0 * np.pi))
                    if not np.isfinite(e) or (k == 5 and stops):
                        continue
                    q0 = q1 = q2 = q3 = 0.0
                    if k == 0:
                        q0, q2, q3 = 1.0, y0 - output[i, 1], g[0]
                    elif k == 1:
                        q1, q2, q3 = 1.0, output[i, 0] - x0, g[1]
                    elif k == 2:
                        q2, q3 = 1.0, g[2]
                    elif k == 3:
                        q3 = gain
                    elif k == 4:
                        q3 = turn
                    elif k == 6:
                        q3 = 2.0 * rate * gain
                    if sweep == 0:
                        w = weight[k]
                        if w > 0.0 and k != 5 and k != 7:
                            w = w * w
                            a[0, 0] += w * q0 * q0
                            a[0, 2] += w * q0 * q2
                            a[0, 3] += w * q0 * q3
                            a[1, 1] += w * q1 * q1
                            a[1, 2] += w * q1 * q2
                            a[1, 3] += w * q1 * q3
                            a[2, 2] += w * q2 * q2
                            a[2, 3] += w * q2 * q3
                            a[3, 3] += w * q3 * q3
                            b[0] += w * q0 * e
                            b[1] += w * q1 * e
                            b[2] += w * q2 * e
                            b[3] += w * q3 * e
                    else:
                        e -= q0 * p[0] + q1 * p[1] + q2 * p[2] + q3 * p[3]
                        values[i, k] = e
                        if weight[k] > 0.0:
                            chi2[k] += (e * weight[k]) ** 2
                            count[k] += 1
            if sweep == 0:
                _solve(a, b, p)
        for k in range(4):
            start[j, k] = p[k]


@njit(cache=True, error_model="numpy")
def _stops(output: FloatArray, i: int, first: int, end: int) -> bool:
    """True within a row of where the model comes to rest: a start speed 1 cm/s off moves that by a row, and one row of
    full deceleration is dozens of sigma."""
    for row in range(max(i - 1, first + 1), min(i + 2, end)):
        if abs(output[row, 3]) < _STOPPED <= abs(output[row - 1, 3]):
            return True
    return False


@njit(cache=True, error_model="numpy")
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
