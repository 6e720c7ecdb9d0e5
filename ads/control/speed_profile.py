"""Speed along a path from its curvature, and the braking law for stops and slower traffic.

The braking law eases out: deceleration is `b` at speed and falls linearly to EASE_A at standstill,
a(v) = min(b, EASE_A + EASE_K v), so that neither the deceleration nor its change jolts when the car comes to rest.
"""

from __future__ import annotations

import math

from ads.control.spline import KAPPA, SPEED, S
from machine_code import compiled
from vehicle.messages import FloatArray

LATERAL_ACCELERATION = 2.5  # m/s^2, ISO 15622 leaves 2.3 to 3; at high set speeds it takes over from LQR_rc_max
EASE_A = 0.15  # m/s^2
EASE_K = 0.7  # 1/s
FIRMEST = 1.6  # times the planned deceleration, for a stop that is learnt of late
GAP_GAIN = 0.4  # 1/s^2; how firmly a gap that is too small is opened


@compiled
def fill_speed(path: FloatArray, set_speed: float, rc_max: float, accel: float, decel: float) -> None:
    """Write the speed limit column of `path` (n, COLUMNS) of a spline, in place.

    `set_speed` [m/s] holds where the radius is at least `rc_max` [m]; in tighter bends the speed falls with the root
    of the radius, and lateral acceleration stays below LATERAL_ACCELERATION. Speed changes keep to `accel` and
    `decel` [m/s^2].
    """
    n = len(path)
    for i in range(n):
        # mean over 3 m: a spline overshoots where a road's curvature jumps
        k = 0.0
        low, high = max(0, i - 3), min(n, i + 4)
        for j in range(low, high):
            k += abs(path[j, KAPPA]) / (high - low)
        v = set_speed
        if k > 1e-9:
            radius = 1.0 / k
            v = min(v, set_speed * math.sqrt(radius / rc_max), math.sqrt(LATERAL_ACCELERATION * radius))
        path[i, SPEED] = v
    for i in range(n - 2, -1, -1):
        ds = path[i + 1, S] - path[i, S]
        path[i, SPEED] = min(path[i, SPEED], math.sqrt(path[i + 1, SPEED] ** 2 + 2.0 * decel * ds))
    for i in range(1, n):
        ds = path[i, S] - path[i - 1, S]
        path[i, SPEED] = min(path[i, SPEED], math.sqrt(path[i - 1, SPEED] ** 2 + 2.0 * accel * ds))


@compiled
def stopping_distance(v: float, b: float) -> float:
    """Distance [m] to come from speed `v` [m/s] to rest by the braking law with deceleration `b` [m/s^2]."""
    knee = max(b - EASE_A, 0.0) / EASE_K
    low = min(v, knee)
    d = low / EASE_K - EASE_A / (EASE_K * EASE_K) * math.log(1.0 + EASE_K * low / EASE_A)
    if v > knee:
        d += (v * v - knee * knee) / (2.0 * b)
    return d


@compiled
def approach_speed(distance: float, b: float) -> float:
    """Speed [m/s] from which the braking law with `b` [m/s^2] comes to rest in `distance` [m]; inverse of the above."""
    if distance <= 0.0:
        return 0.0
    knee = max(b - EASE_A, 0.0) / EASE_K
    d_knee = stopping_distance(knee, b)
    if distance >= d_knee:
        return math.sqrt(knee * knee + 2.0 * b * (distance - d_knee))
    low, high = 0.0, knee
    for _ in range(24):
        middle = 0.5 * (low + high)
        if stopping_distance(middle, b) < distance:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@compiled
def firmer(v: float, distance: float, b: float) -> float:
    """Deceleration [m/s^2] from `b` to FIRMEST times `b` with which the law comes from `v` [m/s] to rest in `distance`.

    Who learns late of a stop brakes evenly a little harder, not hard at first and gently then.
    """
    if v <= 0.0 or stopping_distance(v, b) <= distance:
        return b
    low, high = b, FIRMEST * b
    for _ in range(10):
        middle = 0.5 * (low + high)
        if stopping_distance(v, middle) > distance:
            low = middle
        else:
            high = middle
    return high


@compiled
def approach_acceleration(v: float, v_target: float, distance: float, b: float, gain: float, lag: float) -> float:
    """Acceleration [m/s^2] that reaches `v_target` [m/s] in `distance` [m] by the braking law, with feedback `gain`.

    `lag` [s] is the time until a command bites. Large and positive while the point is far away. When comfort braking
    cannot do it any more, the deceleration is what the distance needs.
    """
    relative = v - v_target
    left = distance - max(relative, 0.0) * lag
    if left <= 0.0 and v_target > 0.0:
        return -gain * relative + GAP_GAIN * left
    firm = firmer(relative, left, b)
    wanted = approach_speed(left, firm)
    a = -min(firm, EASE_A + EASE_K * wanted) + gain * (wanted - relative)
    if relative > 0.0:
        needed = relative * relative / (2.0 * max(distance, 0.05))
        if needed > 1.15 * b:
            a = min(a, -needed)
    return a
