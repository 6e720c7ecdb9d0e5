"""Extended Kalman filter of the car's motion, with measurements kept in the order of their stamps.

State: x, y [m], yaw [rad] of the rear axle in the map, speed v [m/s], bias b of the yaw rate [rad/s], scale k of the
wheels' speed [-], side slip c of the rear axle per lateral acceleration [rad s^2/m], slow error gx, gy of the GNSS [m].
Model: w = measured yaw rate - b; course = yaw - c v w; x' = v cos(course), y' = v sin(course), yaw' = w, v' = measured
longitudinal acceleration; b, k and c random walks, gx and gy first-order Gauss-Markov.
Sources: Thrun, Burgard, Fox, Probabilistic Robotics (2005), table 3.3; slow errors as states: P. Groves, Principles of
GNSS, Inertial and Multisensor Integrated Navigation Systems, 2nd ed., sec. 3.4; side slip of a linear tyre in steady
turning: Rajamani, Vehicle Dynamics and Control, 2nd ed., sec. 3.3. Not valid when the tyres slide.

A measurement row is t, kind, a, b, c, d, e:
  GNSS  x, y, sigma, yaw, yaw_sigma (yaw_sigma <= 0: the receiver gives no heading)
  ODO   speed, its sigma, yaw rate from steering (used while no IMU speaks)
  IMU   yaw rate, longitudinal acceleration
"""

from __future__ import annotations

import math

import numpy as np

from ads.transforms import wrap_angle
from machine_code import compiled
from vehicle.messages import FloatArray

GNSS, ODO, IMU = 0.0, 1.0, 2.0
ROW = 7  # columns of a measurement, see above
STATES = 9  # as named below
X, Y, YAW, V, B, K, C, GX, GY = range(STATES)

NOISES = 9  # as named below
(SLIP_NOISE, GYRO_NOISE, STEER_NOISE, ACCEL_NOISE, BIAS_WALK, SCALE_WALK, COMPLIANCE_WALK, SLOW_SHARE,
 SLOW_TIME) = range(NOISES)  # fmt: skip
"""Densities per sqrt(s): transient slip of the position [m], yaw by the gyro and by the steering [rad], speed [m/s],
walks of b, k, c; then the slow part of a fix's sigma (0..1) and how long it lasts [s]."""

HOLD = 6  # as named below
HT, HA, HW, HIMU, HYAW, HSLOW = range(HOLD)
"""Input that the filter holds: time, acceleration, yaw rate, time of the last IMU row, density of the yaw's noise,
slow part of the sigma of the last fix [m]."""

COUNTS = 12  # as named below
(STREAK, REJECTED, ACCEPTED, SINCE, OFF_X, OFF_Y, FIX_NIS, FIXES, YAW_NIS, YAWS, WHEEL_NIS, WHEELS) = range(COUNTS)
"""Of GNSS fixes: rejected in a row, rejected and accepted in all, since when the row, last rejected innovation [m].
Then of positions, headings and wheel speeds, rejected ones too: the sum of their squared innovations over the variance
that the filter expects (per degree of freedom, so 1 on average: Bar-Shalom et al. 2001, 5.4.2), and how many."""

GATE_2 = 13.82  # chi-square, 2 degrees of freedom, 99.9 %
GATE_1 = 10.83  # chi-square, 1 degree of freedom, 99.9 %
GATE_WHEELS = 25.0  # 5 sigma; wheels that slip
IMU_SILENCE = 0.1  # s without an IMU until the steering gives the yaw rate
STANDING = 0.02  # m/s; slower, the car does not turn, and the gyro shows its bias
STANDING_SIGMA = 0.02  # rad/s per odometry message
ALIKE = 3.0  # m between the innovations of rejected fixes that agree with each other
CONFIRMED = 50.0  # accepted fixes after which the filter is trusted more than a few seconds of GNSS
PATIENCE_NEW, PATIENCE = 3.0, 30.0  # s of agreeing rejected fixes until a filter starts over: new, confirmed


@compiled
def predict(m: FloatArray, p: FloatArray, hold: FloatArray, w: float, dt: float, noise: FloatArray) -> None:
    """Move mean `m` (STATES,) and covariance `p` forward by `dt` [s] at measured yaw rate `w` [rad/s], in place."""
    if dt <= 0.0:
        return
    a, v = hold[HA], m[V]
    rate = w - m[B]
    course = m[YAW] + 0.5 * rate * dt - m[C] * v * rate
    c, s = math.cos(course), math.sin(course)
    step = (v + 0.5 * a * dt) * dt
    m[X] += step * c
    m[Y] += step * s
    m[YAW] += rate * dt
    m[V] += a * dt
    fade = 1.0 - dt / noise[SLOW_TIME]
    m[GX] *= fade
    m[GY] *= fade
    # F is the identity but for these entries, so F P F' is a few row sums, then the same with columns
    by_v, by_b, by_c = -m[C] * rate, m[C] * v - 0.5 * dt, -v * rate
    x_yaw, y_yaw = -step * s, step * c
    x_v, y_v = dt * c + x_yaw * by_v, dt * s + y_yaw * by_v
    for k in range(STATES):
        course_k = p[YAW, k] + by_b * p[B, k] + by_c * p[C, k]
        p[X, k] += x_yaw * course_k + x_v * p[V, k]
        p[Y, k] += y_yaw * course_k + y_v * p[V, k]
        p[YAW, k] -= dt * p[B, k]
        p[GX, k] *= fade
        p[GY, k] *= fade
    for k in range(STATES):
        course_k = p[k, YAW] + by_b * p[k, B] + by_c * p[k, C]
        p[k, X] += x_yaw * course_k + x_v * p[k, V]
        p[k, Y] += y_yaw * course_k + y_v * p[k, V]
        p[k, YAW] -= dt * p[k, B]
        p[k, GX] *= fade
        p[k, GY] *= fade
    p[X, X] += noise[SLIP_NOISE] ** 2 * dt
    p[Y, Y] += noise[SLIP_NOISE] ** 2 * dt
    p[YAW, YAW] += hold[HYAW] ** 2 * dt
    p[V, V] += noise[ACCEL_NOISE] ** 2 * dt
    p[B, B] += noise[BIAS_WALK] ** 2 * dt
    p[K, K] += noise[SCALE_WALK] ** 2 * dt
    p[C, C] += noise[COMPLIANCE_WALK] ** 2 * dt
    slow = 2.0 * hold[HSLOW] ** 2 * dt / noise[SLOW_TIME]  # what fades of the slow error comes anew
    p[GX, GX] += slow
    p[GY, GY] += slow


@compiled
def correct(m: FloatArray, p: FloatArray, h: FloatArray, innovation: float, variance: float, gate: float) -> bool:
    """Scalar update with row `h` (STATES,); False and no change if the squared Mahalanobis distance exceeds `gate`."""
    ph = np.empty(STATES)
    total = variance
    for i in range(STATES):
        value = 0.0
        for k in range(STATES):
            value += p[i, k] * h[k]
        ph[i] = value
        total += h[i] * value
    if innovation * innovation > gate * total:
        return False
    for i in range(STATES):
        gain = ph[i] / total
        m[i] += gain * innovation
        for k in range(STATES):
            p[i, k] -= gain * ph[k]
    return True


@compiled
def start_over(p: FloatArray, dx: float, dy: float) -> None:
    """Forget where the car is: covariance `p` (STATES, STATES) grows by how far the fixes are off (dx, dy [m])."""
    for i in range(3):
        p[i, i] += (dx * dx + dy * dy) if i < 2 else 0.5


@compiled
def reject(p: FloatArray, t: float, dx: float, dy: float, counts: FloatArray) -> None:
    """Count a GNSS fix at `t` [s] that does not fit, with innovation dx, dy [m], in `counts` (COUNTS,).

    After enough fixes that agree with each other the filter is lost and not they: `p` (STATES, STATES) starts over.
    """
    agrees = counts[STREAK] > 0.0 and math.hypot(dx - counts[OFF_X], dy - counts[OFF_Y]) < ALIKE
    if not agrees:
        counts[STREAK], counts[SINCE] = 0.0, t
    counts[STREAK] += 1.0
    counts[REJECTED] += 1.0
    counts[OFF_X], counts[OFF_Y] = dx, dy
    patience = PATIENCE if counts[ACCEPTED] >= CONFIRMED else PATIENCE_NEW
    if t - counts[SINCE] >= patience and counts[STREAK] > 3.0:
        start_over(p, dx, dy)
        counts[STREAK] = counts[ACCEPTED] = 0.0


@compiled
def correct_gnss(
    m: FloatArray, p: FloatArray, row: FloatArray, lever: FloatArray, noise: FloatArray, counts: FloatArray
) -> None:
    """Antenna position, `lever` (2,) [m] ahead and left of the rear axle, and heading; counts as COUNTS has them."""
    c, s = math.cos(m[YAW]), math.sin(m[YAW])
    arm_x, arm_y = lever[0] * c - lever[1] * s, lever[0] * s + lever[1] * c
    hx, hy = np.zeros(STATES), np.zeros(STATES)
    hx[X], hx[GX], hx[YAW] = 1.0, 1.0, -arm_y
    hy[Y], hy[GY], hy[YAW] = 1.0, 1.0, arm_x
    dx = row[2] - (m[X] + m[GX] + arm_x)
    dy = row[3] - (m[Y] + m[GY] + arm_y)
    r = row[4] ** 2 * (1.0 - noise[SLOW_SHARE] ** 2)
    sxx = syy = r
    sxy = 0.0
    for i in (X, YAW, GX):
        for k in (X, YAW, GX):
            sxx += hx[i] * p[i, k] * hx[k]
    for i in (Y, YAW, GY):
        for k in (Y, YAW, GY):
            syy += hy[i] * p[i, k] * hy[k]
    for i in (X, YAW, GX):
        for k in (Y, YAW, GY):
            sxy += hx[i] * p[i, k] * hy[k]
    distance = (syy * dx * dx - 2.0 * sxy * dx * dy + sxx * dy * dy) / (sxx * syy - sxy * sxy)
    counts[FIX_NIS] += 0.5 * distance
    counts[FIXES] += 1.0
    if row[6] > 0.0:
        turned = wrap_angle(row[5] - m[YAW])
        counts[YAW_NIS] += turned * turned / (p[YAW, YAW] + row[6] * row[6])
        counts[YAWS] += 1.0
    if distance > GATE_2:
        reject(p, row[0], dx, dy, counts)
        return
    counts[STREAK] = 0.0
    counts[ACCEPTED] += 1.0
    correct(m, p, hx, dx, r, 1e18)
    # the second component sees the state that the first one moved
    arm_y = lever[0] * math.sin(m[YAW]) + lever[1] * math.cos(m[YAW])
    correct(m, p, hy, row[3] - (m[Y] + m[GY] + arm_y), r, 1e18)
    if row[6] > 0.0:
        h = np.zeros(STATES)
        h[YAW] = 1.0
        correct(m, p, h, wrap_angle(row[5] - m[YAW]), row[6] * row[6], GATE_1)


@compiled
def correct_wheels(
    m: FloatArray, p: FloatArray, row: FloatArray, hold: FloatArray, noise: FloatArray, counts: FloatArray
) -> None:
    """Take an odometry row (ROW,) into mean `m` (STATES,) and covariance `p` (STATES, STATES), in place.

    `hold` (HOLD,), `noise` (NOISES,) and `counts` (COUNTS,) are those of the filter; units as there. Standing still
    shows the bias of the yaw rate; without an IMU the steering gives the yaw rate.
    """
    h = np.zeros(STATES)
    h[V], h[K] = 1.0 + m[K], m[V]
    faster = row[2] - h[V] * m[V]
    expected = h[V] * h[V] * p[V, V] + 2.0 * h[V] * h[K] * p[V, K] + h[K] * h[K] * p[K, K] + row[3] * row[3]
    counts[WHEEL_NIS] += faster * faster / expected
    counts[WHEELS] += 1.0
    correct(m, p, h, faster, row[3] * row[3], GATE_WHEELS)
    if row[0] - hold[HIMU] > IMU_SILENCE:
        # the bias is the gyroscope's, not the steering's: what is taken off in `predict` is put on here
        hold[HW], hold[HA], hold[HYAW] = row[4] + m[B], 0.0, noise[STEER_NOISE]
    elif abs(row[2]) < STANDING and abs(m[V]) < 2.0 * STANDING:
        h[V], h[K], h[B] = 0.0, 0.0, 1.0
        correct(m, p, h, hold[HW] - m[B], STANDING_SIGMA**2, GATE_1)


@compiled
def digest(
    m: FloatArray,
    p: FloatArray,
    hold: FloatArray,
    row: FloatArray,
    lever: FloatArray,
    noise: FloatArray,
    counts: FloatArray,
) -> None:
    """Predict to the stamp of `row`, then update by it. `hold` (HOLD,) is the filter's input, in place."""
    w = hold[HW]
    if row[1] == IMU and row[0] - hold[HIMU] <= IMU_SILENCE:
        w = 0.5 * (w + row[2])  # it changed evenly since the last one
    predict(m, p, hold, w, row[0] - hold[HT], noise)
    hold[HT] = max(hold[HT], row[0])
    if row[1] == GNSS:
        hold[HSLOW] = noise[SLOW_SHARE] * row[4]
        correct_gnss(m, p, row, lever, noise, counts)
    elif row[1] == ODO:
        correct_wheels(m, p, row, hold, noise, counts)
    else:
        hold[HW], hold[HA], hold[HIMU], hold[HYAW] = row[2], row[3], row[0], noise[GYRO_NOISE]


@compiled
def copy_row(source: FloatArray, i: int, target: FloatArray, k: int) -> None:
    """Copy row `i` of `source` (n, k) to row `k` of `target` (m, k).

    A loop compiles faster than an assignment of slices.
    """
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
    lever: FloatArray,
    noise: FloatArray,
    counts: FloatArray,
    m_out: FloatArray,
    p_out: FloatArray,
    hold_out: FloatArray,
) -> int:
    """Fuse `rows[:n]` and give the state at `t_now` [s] in m_out (STATES,), p_out, hold_out (HOLD,).

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
        if rows[done, 0] >= hold[HT] - 1e-9:
            digest(m, p, hold, rows[done], lever, noise, counts)
        done += 1
    left = n - done
    for i in range(left):
        copy_row(rows, done + i, rows, i)
    for i in range(STATES):
        m_out[i] = m[i]
        for k in range(STATES):
            p_out[i, k] = p[i, k]
    for i in range(HOLD):
        hold_out[i] = hold[i]
    scratch = np.empty(COUNTS)
    for i in range(COUNTS):
        scratch[i] = counts[i]
    for i in range(left):
        digest(m_out, p_out, hold_out, rows[i], lever, noise, scratch)
    predict(m_out, p_out, hold_out, hold_out[HW], t_now - hold_out[HT], noise)
    return left
