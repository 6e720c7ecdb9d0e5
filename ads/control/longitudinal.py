"""Speed control: one wanted acceleration from the path's speed limit and the points where the car must be slower."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from ads.control.speed_profile import approach_acceleration
from ads.control.spline import sample
from ads.localization import Estimate
from machine_code import compiled
from vehicle.messages import FloatArray, VehicleDescription

GAIN = 0.9  # 1/s
COMFORT_JERK = 1.4  # m/s^3
URGENT_JERK = 2.5  # m/s^3
EMERGENCY_JERK = 20.0  # m/s^3
COMFORT_DECELERATION = 1.0  # m/s^2 at town speed
HARD_DECELERATION = 3.5  # m/s^2; more only in an emergency
CALM = 1.45  # times comfortable braking, for a speed that is wanted from now on; no urgent change of it
TOO_FAST = 3.0  # m/s over the path's limit; more is worth hard braking
STANDSTILL = 0.08  # m/s
ROLLS_BACK = 0.06  # m/s; faster backwards, the car is held by its brake: it stands on a slope (a flat one shows 0.02)
HELD_BACK = 0.4  # m/s^2; less is not worth setting off again on a slope for, a metre before the place of the stop
ROOM = 16  # constraints
PREVIEW = 0.3  # s over which the path's change of speed is taken: as long as a limited jerk needs for it
LONGEST_REACTION = 0.6  # s; with more, the acceleration under way would be fed back too strongly
NOW = -1e9  # m; as a distance: from now on


@compiled
def comfort_deceleration(v: float) -> float:
    """Planned braking [m/s^2] at speed [m/s]: gentle in town, firmer from motorway speed."""
    return COMFORT_DECELERATION * min(max(v / 8.0, 1.0), 2.0)


@compiled
def wanted_acceleration(
    v: float, a_now: float, path: FloatArray, index: int, s: float, points: FloatArray, n: int, lag: float, a_up: float
) -> tuple[float, bool]:
    """Acceleration [m/s^2] before limits on its change, and whether a stop is what sets it.

    `points` (n, 2): distance ahead [m] and highest speed there [m/s]; distance NOW means from now on.
    """
    b = comfort_deceleration(v)
    ramp = lag + max(0.5 * (b + a_now), 0.0) / COMFORT_JERK * 0.5
    look, ahead = s + v * lag, max(v * PREVIEW, 1.0)
    _, _, _, _, limit = sample(path, index, look)
    _, _, _, _, beyond = sample(path, index, look + ahead)
    slope = (beyond * beyond - limit * limit) / (2.0 * ahead)
    then = v + a_now * min(lag + 0.5 * PREVIEW, LONGEST_REACTION)  # what is under way changes the speed before a does
    a = slope + GAIN * (limit - then) if abs(limit - v) < 1.0 else GAIN * (limit - v)
    floor = max(b, 1.2) if v - limit < TOO_FAST else HARD_DECELERATION
    a = min(max(a, -floor), a_up * (1.0 if limit - v > 1.0 else max(limit - v, 0.0) ** 0.5 + 1e-3))
    stop = False
    for i in range(n):
        d, target = points[i, 0], points[i, 1]
        other = approach_acceleration(v, target, d, b, GAIN, ramp)
        if d <= NOW:
            other = max(GAIN * (target - v), -CALM * b)
        if other < a:
            a = other
            stop = target < 0.3
    return max(a, -HARD_DECELERATION), stop


def allowed_speed(profile: float, v: float, limits: list[tuple[float, float]]) -> float:
    """Speed [m/s] from which every limit ahead is met by comfortable braking; `profile` that of the path here [m/s]."""
    braking = 2.0 * float(comfort_deceleration(v))
    return min([profile, *(math.sqrt(speed * speed + braking * max(distance, 0.0)) for distance, speed in limits)])


class SpeedControl(Protocol):
    """Turns speed limits into one acceleration."""

    def step(
        self,
        estimate: Estimate,
        path: FloatArray,
        index: int,
        s: float,
        limits: list[tuple[float, float]],
        brake: float,
    ) -> tuple[float, bool]:
        """Wanted acceleration [m/s^2], and True if the car is to stand.

        `path` (n, COLUMNS) of a spline, `index` the nearest point, `s` [m] along it; `limits`: (distance ahead [m] or
        NOW, highest speed there [m/s]); `brake` > 0 [m/s^2] is an emergency.
        """


class ComfortSpeedControl:
    """Speed control with limited jerk, except in an emergency."""

    def __init__(self, vehicle: VehicleDescription, dt: float) -> None:
        self._vehicle = vehicle
        self._dt = dt
        self._points = np.zeros((ROOM, 2))
        self._a = 0.0
        self._standing = False
        self._release = 0.1  # m/s^2 that is wanted when the brake is let go

    def step(
        self,
        estimate: Estimate,
        path: FloatArray,
        index: int,
        s: float,
        limits: list[tuple[float, float]],
        brake: float,
    ) -> tuple[float, bool]:
        """Wanted acceleration [m/s^2], and True if the car is to stand, by comfortable braking; see SpeedControl.

        `path` (n, COLUMNS) of a spline.
        """
        car = self._vehicle
        v = estimate.v
        n = 0
        for distance, speed in limits[:ROOM]:
            self._points[n, 0] = distance
            self._points[n, 1] = speed
            n += 1
        a_up = min(1.5, 0.7 * car.max_acceleration)
        wanted, stop = wanted_acceleration(v, self._a, path, index, s, self._points, n, car.drive_delay, a_up)
        if brake > 0.0:
            wanted, stop = min(wanted, -min(brake, car.max_deceleration)), True
        if self._standing:
            if wanted < self._release:
                return -0.3, True
            self._standing = False
            self._a = 0.0
        elif stop and ((v < STANDSTILL and wanted < 0.05) or v < -ROLLS_BACK):
            self._standing = True
            self._release = HELD_BACK if v < -ROLLS_BACK else 0.1
            self._a = 0.0
            return -0.3, True
        self._a = self._limited(v, wanted, brake > 0.0)
        if not math.isfinite(self._a):
            self._a = -1.0
        return self._a, False

    def _limited(self, v: float, wanted: float, emergency: bool) -> float:
        """`wanted` [m/s^2] as near as the allowed jerk lets this tick come to it."""
        a, comfort = self._a, comfort_deceleration(v)
        if v < STANDSTILL and wanted > 0.0:
            a = max(a, 0.0)  # it stands: nothing to release smoothly
        onset = COMFORT_JERK
        if emergency:
            onset = EMERGENCY_JERK
        elif wanted < -1.5 * comfort:
            onset = URGENT_JERK
        release = COMFORT_JERK
        if a < -HARD_DECELERATION:
            release = 0.5 * EMERGENCY_JERK
        elif a < -1.1 * comfort:
            release = URGENT_JERK
        return min(max(wanted, a - onset * self._dt), a + release * self._dt)
