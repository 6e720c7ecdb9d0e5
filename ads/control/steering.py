"""Steering: the LQR law on the pose predicted over the steering delay, within what car and comfort allow."""

from __future__ import annotations

import math
from typing import Protocol

from ads.control.delay_compensation import DelayCompensation
from ads.control.lqr import DT, gain_table, steer_law
from ads.control.spline import project, sample
from ads.localization import Estimate
from ads.parameters import Parameters
from ads.transforms import wrap_angle
from vehicle.messages import FloatArray, VehicleDescription

STEER_RATE = 0.5  # rad/s at the road wheel
LATERAL_LIMIT = 4.5  # m/s^2; no command asks for more
WINDOW = 40  # path points around the last one


class Steering(Protocol):
    """Turns the pose and the planned path into a road-wheel angle."""

    def steer(self, estimate: Estimate, path: FloatArray, index: int) -> float:
        """Road-wheel angle [rad] at `estimate.t`; `path` (n, COLUMNS) of a spline, `index` the nearest point."""


class LqrSteering:
    """Steering by LQR with curvature feed-forward and delay compensation."""

    def __init__(self, parameters: Parameters, vehicle: VehicleDescription) -> None:
        p = parameters
        self._vehicle = vehicle
        self._table = gain_table(vehicle.wheelbase, p.LQR_q11, p.LQR_q22, p.LQR_r11)
        self._delay = DelayCompensation(vehicle.steer_delay, vehicle.wheelbase)
        self._integral = 0.0
        self._last = 0.0

    def steer(self, estimate: Estimate, path: FloatArray, index: int) -> float:
        """Road-wheel angle [rad] at `estimate.t`, from the pose after the delay; see Steering.

        `path` (n, COLUMNS) of a spline.
        """
        car = self._vehicle
        x, y, yaw, v = self._delay.predict(
            estimate.t, estimate.x, estimate.y, estimate.yaw, max(estimate.v, 0.0), estimate.yaw_rate, estimate.ax
        )
        i, s, lateral = project(path, x, y, index, WINDOW)
        _, _, heading, curvature, _ = sample(path, i, s)
        angle, self._integral = steer_law(
            self._table, car.wheelbase, v, lateral, wrap_angle(yaw - heading), curvature, self._integral
        )
        limit = min(car.max_steer, math.atan(car.wheelbase * LATERAL_LIMIT / max(v * v, 1.0)))
        step = STEER_RATE * DT
        angle = min(max(angle, self._last - step), self._last + step)
        self._last = min(max(angle, -limit), limit)
        self._delay.remember(estimate.t, self._last)
        return self._last
