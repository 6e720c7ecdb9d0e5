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
_START_SPEED = 0.3  # m/s, by which a start may be off (standard deviation) on hills, where a slow car has no rows that
# tell it; chosen: it is measured to some cm/s
_STANDS, _STANDING_SPEED = 0.2, 0.01  # m/s: where no speed is measured, one that begins slower stands, give or take;
# the first row alone tells the start of one that stands, and it is noise; chosen, not measured
_SLOW = 0.3  # m/s: on hills, from where car or model is slower on, their ways are no longer compared in this segment
KNOTS = 3  # of a segment, evenly, between which the slope of the road runs straight
TAKEN_OUT = 0.9
"""Of the slopes that suit a segment best; chosen: with all of it, a constant resistance could not be told from a bias
of the accelerometer. With their mean over the drive left in, a drive that ends 0.2 % higher gives a gain of the brakes
of 0.82 for 0.85; with a tenth of each, 0.848."""


@compiled
def project(output: FloatArray, measured: FloatArray, t: FloatArray, weight: FloatArray, starts: IntArray,
            ends: IntArray, counted: BoolArray, free_speed: bool, slopes: float, values: FloatArray, start: FloatArray,
            chi2: FloatArray, count: IntArray) -> None:  # fmt: skip
    """Fill values (n, 8), start (m, 4), chi2 (8,) as sums and count (8,); see `segments.residuals`, also for the units.

    Two sweeps a segment: the first gathers the normal equations of the start, the second takes its effect out. With
    `slopes`, one more before them, which finds the slopes of the road.
    """
    values[:] = np.nan
    speeds = 1 + (KNOTS if free_speed and slopes > 0.0 else 0)
    reach, left = np.zeros((values.shape[0], 5, speeds)), np.empty(8)
    found, rolls = np.zeros((len(starts), speeds - 1)), np.ones(len(t), dtype=np.bool_)
    for j in range(len(starts)):
        for one in range(speeds):
            _reach(output, t, starts[j], ends[j], free_speed, one, reach)
        if speeds > 1:
            _roll(output, measured, starts[j], ends[j], rolls)
            p = _start(output, measured, weight, starts[j], ends[j], counted, rolls, slopes, reach, found[j])
            found[j] = p[4:]
    found *= TAKEN_OUT
    for j in range(len(starts)):
        first, end = starts[j], ends[j]
        p = _start(output, measured, weight, first, end, counted, rolls, 0.0, reach, found[j])
        x0, y0 = output[first, 0], output[first, 1]
        for i in range(first, end):
            if not counted[i]:
                continue
            a, b = measured[i], output[i]
            turn = a[2] - b[2]
            turn -= 2.0 * np.pi * np.rint(turn / (2.0 * np.pi))
            left[0] = (a[0] - b[0]) - (p[0] + (y0 - b[1]) * p[2])
            left[1] = (a[1] - b[1]) - (p[1] + (b[0] - x0) * p[2])
            left[2] = turn - p[2]
            left[3] = a[3] - b[3]
            left[4] = a[4] - b[4]
            left[5] = np.nan if _stops(output, i, first, end) else a[5] - b[5]
            if speeds > 1 and abs(b[3]) < _STOPPED:
                left[5] = np.nan  # the accelerometer of a car that is held on a hill shows the hill
            left[6] = a[6] - b[6]
            left[7] = a[7] - b[7]
            for one in range(speeds):
                for k in range(5):
                    left[k] -= reach[i, k, one] * p[3 + one]
                left[6] -= 2.0 * b[4] * reach[i, 3, one] * p[3 + one]
            for k in range(8):
                if np.isfinite(left[k]) and (rolls[i] or not (k < 2 or k == 3)):
                    values[i, k] = left[k]
                    if weight[k] > 0.0:
                        chi2[k] += (left[k] * weight[k]) ** 2
                        count[k] += 1
        for k in range(4):
            start[j, k] = p[k]


@compiled
def _reach(output: FloatArray, t: FloatArray, first: int, end: int, free_speed: bool, one: int,
           reach: FloatArray) -> None:  # fmt: skip
    """Fill reach (n, 5, one), rows first..end: what has been done to x, y, yaw, speed and yaw rate by 1 m/s more at the
    start (`one` 0), or by a slope of the road that accelerates by 1 m/s^2 at one of the knots, less beside it."""
    gx, gy, gyaw = 0.0, 0.0, 0.0
    moving = free_speed
    rate_before, gain_before, speed_before = 0.0, 0.0, 0.0
    yaw_before = output[first, 2]
    apart = max(t[end - 1] - t[first], 1e-9) / (KNOTS - 1)
    faster, push_before = 0.0, 0.0
    for i in range(first, end):
        v, rate = output[i, 3], output[i, 4]
        if abs(v) < _STOPPED and i > first:
            moving = False
        if one > 0:
            push = max(0.0, 1.0 - abs((t[i] - t[first]) / apart - (one - 1)))
            if i > first:
                faster += 0.5 * (t[i] - t[i - 1]) * (push + push_before)
            push_before = push
        else:
            faster = 1.0
        gain = faster if moving else 0.0
        turn = rate / v if moving and abs(v) > _CREEP else 0.0
        turned = turn * gain
        if i > first:
            dt = t[i] - t[i - 1]
            mid_yaw = 0.5 * (output[i, 2] + yaw_before)
            mid_gain = 0.5 * (gain + gain_before)
            c, s = np.cos(mid_yaw), np.sin(mid_yaw)
            half = 0.25 * dt * (turned + rate_before)
            gyaw += half
            mid_speed = 0.5 * (v + speed_before)
            gx += dt * (c * mid_gain - s * mid_speed * gyaw)
            gy += dt * (s * mid_gain + c * mid_speed * gyaw)
            gyaw += half
        rate_before, gain_before, speed_before, yaw_before = turned, gain, v, output[i, 2]
        reach[i, 0, one], reach[i, 1, one], reach[i, 2, one] = gx, gy, gyaw
        reach[i, 3, one], reach[i, 4, one] = gain, turned


@compiled
def _roll(output: FloatArray, measured: FloatArray, first: int, end: int, rolls: BoolArray) -> None:
    """Set rolls (n,), rows first..end, to False from where car or model is slow on: on a hill one stops before the
    other, and no first order tells how far it would have come."""
    slow = False
    for i in range(first, end):
        slow = slow or abs(output[i, 3]) < _SLOW or abs(measured[i, 3]) < _SLOW
        rolls[i] = not slow


@compiled
def _start(output: FloatArray, measured: FloatArray, weight: FloatArray, first: int, end: int, counted: BoolArray,
           rolls: BoolArray, slopes: float, reach: FloatArray, given: FloatArray) -> FloatArray:  # fmt: skip
    """(4 + m,) x, y, yaw and speed to add to a segment's start, by least squares over its rows, and its slopes (m,):
    those `given`, or with `slopes` more than 0 those that suit best, too."""
    n = 4 + (len(given) if slopes > 0.0 else 0)
    a, b, d = np.zeros((n, n)), np.zeros(n), np.zeros(4 + len(given))
    p, found = np.zeros(n), np.zeros(4 + len(given))
    x0, y0 = output[first, 0], output[first, 1]
    for i in range(first, end):
        if not counted[i]:
            continue
        o = output[i]
        for k in range(7):
            e = measured[i, k] - o[k]
            w = weight[k] * weight[k]
            if k == 5 or not w > 0.0 or not np.isfinite(e) or (not rolls[i] and (k < 2 or k == 3)):
                continue
            turn = 0.0  # what 1 rad more at the start has done
            if k < 2:
                turn = y0 - o[1] if k == 0 else o[0] - x0
            elif k == 2:
                e -= 2.0 * np.pi * np.rint(e / (2.0 * np.pi))
                turn = 1.0
            for one in range(1 + len(given)):
                d[3 + one] = reach[i, k, one] if k < 5 else 2.0 * o[4] * reach[i, 3, one]
            for one in range(n, 4 + len(given)):
                e -= d[one] * given[one - 4]
            if k < 2:
                b[k] += w * e
                a[k, k] += w
                a[k, 2] += w * turn
            if turn != 0.0:
                b[2] += w * turn * e
                a[2, 2] += w * turn * turn
            for r in range(3, n):
                if k < 2:
                    a[k, r] += w * d[r]
                if d[r] != 0.0:
                    b[r] += w * d[r] * e
                    a[2, r] += w * turn * d[r]
                    for q in range(r, n):
                        a[r, q] += w * d[r] * d[q]
    if not weight[3] > 0.0 and abs(output[first, 3]) < _STANDS:
        a[3, 3] += 1.0 / (_STANDING_SPEED * _STANDING_SPEED)
    elif len(given):
        a[3, 3] += 1.0 / (_START_SPEED * _START_SPEED)
    for one in range(4, n):
        a[one, one] += 1.0 / (slopes * slopes)
    _solve(a, b, p)
    found[4:] = given
    found[:n] = p
    return found


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
