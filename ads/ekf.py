"""Extended Kalman filter of the car's motion, with measurements kept in the order of their stamps.

State: x, y [m], yaw [rad] of the rear axle in the map, speed v [m/s], yaw rate w [rad/s], gyro bias b [rad/s].
Model: x' = v cos(yaw), y' = v sin(yaw), yaw' = w, v' = measured longitudinal acceleration, w and b random walks.
Source: Thrun, Burgard, Fox, Probabilistic Robotics (2005), table 3.3. Not valid with large side slip at the rear axle.

A measurement row is t, kind, a, b, c, d, e:
  GNSS  x, y, sigma, yaw, yaw_sigma (yaw_sigma <= 0: the receiver gives no heading)
  ODO   speed, its sigma, yaw rate from steering, its sigma
  IMU   yaw rate, its sigma, longitudinal acceleration
"""

from __future__ import annotations

import math

import numpy as np

from ads.compiled import compiled
from ads.transforms import wrap_angle
from vehicle.messages import FloatArray

GNSS, ODO, IMU = 0.0, 1.0, 2.0
ROW = 7
X, Y, YAW, V, W, B = range(6)

# Process noise densities, per sqrt(s): slip of the position, yaw, unmodelled acceleration, yaw acceleration, bias.
NOISE = np.array([0.02, 0.002, 0.25, 0.6, 2e-4])

GATE_2 = 13.82  # chi-square, 2 degrees of freedom, 99.9 %
GATE_1 = 10.83  # chi-square, 1 degree of freedom, 99.9 %


@compiled
def predict(m: FloatArray, p: FloatArray, acceleration: float, dt: float, noise: FloatArray) -> None:
    """Move mean `m` (6,) and covariance `p` (6, 6) forward by `dt` [s], in place."""
    if dt <= 0.0:
        return
    half = m[YAW] + 0.5 * m[W] * dt
    c, s = math.cos(half), math.sin(half)
    step = (m[V] + 0.5 * acceleration * dt) * dt
    m[X] += step * c
    m[Y] += step * s
    m[YAW] += m[W] * dt
    m[V] += acceleration * dt
    # F is the identity but for these entries, so F P F' is a few row sums, then the same with columns
    x_yaw, x_v, x_w = -step * s, dt * c, -0.5 * dt * step * s
    y_yaw, y_v, y_w = step * c, dt * s, 0.5 * dt * step * c
    for k in range(6):
        p[X, k] += x_yaw * p[YAW, k] + x_v * p[V, k] + x_w * p[W, k]
        p[Y, k] += y_yaw * p[YAW, k] + y_v * p[V, k] + y_w * p[W, k]
        p[YAW, k] += dt * p[W, k]
    for k in range(6):
        p[k, X] += x_yaw * p[k, YAW] + x_v * p[k, V] + x_w * p[k, W]
        p[k, Y] += y_yaw * p[k, YAW] + y_v * p[k, V] + y_w * p[k, W]
        p[k, YAW] += dt * p[k, W]
    p[X, X] += noise[0] * noise[0] * dt
    p[Y, Y] += noise[0] * noise[0] * dt
    p[YAW, YAW] += noise[1] * noise[1] * dt
    p[V, V] += noise[2] * noise[2] * dt
    p[W, W] += noise[3] * noise[3] * dt
    p[B, B] += noise[4] * noise[4] * dt


@compiled
def correct(m: FloatArray, p: FloatArray, h: FloatArray, innovation: float, variance: float, gate: float) -> bool:
    """Scalar update with row `h` (6,); False and no change if the squared Mahalanobis distance exceeds `gate`."""
    ph = np.empty(6)
    total = variance
    for i in range(6):
        value = 0.0
        for k in range(6):
            value += p[i, k] * h[k]
        ph[i] = value
    for i in range(6):
        total += h[i] * ph[i]
    if innovation * innovation > gate * total:
        return False
    for i in range(6):
        gain = ph[i] / total
        m[i] += gain * innovation
        for k in range(6):
            p[i, k] -= gain * ph[k]
    return True


@compiled
def correct_gnss(m: FloatArray, p: FloatArray, row: FloatArray, lever: float, counts: FloatArray) -> None:
    """Antenna position, `lever` [m] ahead of the rear axle, and heading; counts: rejected in a row, rejected in all."""
    c, s = math.cos(m[YAW]), math.sin(m[YAW])
    hx, hy = np.zeros(6), np.zeros(6)
    hx[X], hx[YAW] = 1.0, -lever * s
    hy[Y], hy[YAW] = 1.0, lever * c
    dx = row[2] - (m[X] + lever * c)
    dy = row[3] - (m[Y] + lever * s)
    r = row[4] * row[4]
    sxx = p[X, X] + 2.0 * hx[YAW] * p[X, YAW] + hx[YAW] * hx[YAW] * p[YAW, YAW] + r
    syy = p[Y, Y] + 2.0 * hy[YAW] * p[Y, YAW] + hy[YAW] * hy[YAW] * p[YAW, YAW] + r
    sxy = p[X, Y] + hy[YAW] * p[X, YAW] + hx[YAW] * p[Y, YAW] + hx[YAW] * hy[YAW] * p[YAW, YAW]
    distance = (syy * dx * dx - 2.0 * sxy * dx * dy + sxx * dy * dy) / (sxx * syy - sxy * sxy)
    if distance > GATE_2:
        counts[0] += 1.0
        counts[1] += 1.0
        if counts[0] >= 30.0:  # fixes that agree with each other for seconds: the filter is lost, not they
            for i in range(3):
                p[i, i] += (dx * dx + dy * dy) if i < 2 else 0.5
            counts[0] = 0.0
        return
    counts[0] = 0.0
    correct(m, p, hx, dx, r, 1e18)
    # the second component sees the state that the first one moved
    correct(m, p, hy, row[3] - (m[Y] + lever * math.sin(m[YAW])), r, 1e18)
    if row[6] > 0.0:
        h = np.zeros(6)
        h[YAW] = 1.0
        correct(m, p, h, wrap_angle(row[5] - m[YAW]), row[6] * row[6], GATE_1)


@compiled
def digest(
    m: FloatArray, p: FloatArray, hold: FloatArray, row: FloatArray, lever: float, noise: FloatArray, counts: FloatArray
) -> None:
    """Predict to the stamp of `row`, then update by it. `hold` is (time, acceleration) of the filter, in place."""
    predict(m, p, hold[1], row[0] - hold[0], noise)
    hold[0] = max(hold[0], row[0])
    if row[1] == GNSS:
        correct_gnss(m, p, row, lever, counts)
        return
    h = np.zeros(6)
    if row[1] == ODO:
        h[V] = 1.0
        correct(m, p, h, row[2] - m[V], row[3] * row[3], 25.0)
        h[V], h[W] = 0.0, 1.0
        correct(m, p, h, row[4] - m[W], row[5] * row[5], 25.0)
    else:
        h[W], h[B] = 1.0, 1.0
        correct(m, p, h, row[2] - m[W] - m[B], row[3] * row[3], 25.0)
        hold[1] = row[4]


@compiled
def copy_row(source: FloatArray, i: int, target: FloatArray, k: int) -> None:
    """Copy row `i` of `source` to row `k` of `target`; a loop compiles faster than an assignment of slices."""
    for j in range(source.shape[1]):
        target[k, j] = source[i, j]


@compiled
def advance(
    m: FloatArray,
    p: FloatArray,
    hold: FloatArray,
    rows: FloatArray,
    n: int,
    t_keep: float,
    t_now: float,
    lever: float,
    noise: FloatArray,
    counts: FloatArray,
    m_out: FloatArray,
    p_out: FloatArray,
) -> int:
    """Fuse `rows[:n]` and give the state at `t_now` [s] in m_out (6,), p_out (6, 6).

    Rows stamped up to `t_keep` go into (m, p, hold) for good; newer ones stay in `rows`, sorted, and are replayed on
    every call, so that a late measurement takes its place in time. Returns how many rows stay.
    """
    held = np.empty((1, ROW))
    for i in range(1, n):  # insertion sort: nearly sorted already
        copy_row(rows, i, held, 0)
        k = i - 1
        while k >= 0 and (rows[k, 0] > held[0, 0] or (rows[k, 0] == held[0, 0] and rows[k, 1] > held[0, 1])):
            copy_row(rows, k, rows, k + 1)
            k -= 1
        copy_row(held, 0, rows, k + 1)
    done = 0
    while done < n and rows[done, 0] <= t_keep:
        if rows[done, 0] >= hold[0] - 1e-9:
            digest(m, p, hold, rows[done], lever, noise, counts)
        done += 1
    left = n - done
    for i in range(left):
        copy_row(rows, done + i, rows, i)
    for i in range(6):
        m_out[i] = m[i]
        for k in range(6):
            p_out[i, k] = p[i, k]
    last, scratch = np.empty(2), np.empty(2)
    for i in range(2):
        last[i], scratch[i] = hold[i], counts[i]
    for i in range(left):
        digest(m_out, p_out, last, rows[i], lever, noise, scratch)
    predict(m_out, p_out, last[1], t_now - last[0], noise)
    return left
