"""Localization: GNSS, wheel odometry and IMU fused by stamps into one estimate per tick."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np

from ads.ekf import GNSS, IMU, NOISE, ODO, ROW, advance
from ads.transforms import moved
from vehicle.messages import FloatArray, GnssFix, Observation, VehicleDescription

ODOMETRY_SIGMA = 0.04  # m/s
IMU_SIGMA = 0.01  # rad/s
SHORTEST_WINDOW = 0.05  # s
LONGEST_WINDOW = 0.5  # s; a measurement later than this is dropped
CAPACITY = 512  # rows; at 400 rows/s and the longest window there is room to spare


class Estimate(NamedTuple):
    """Rear axle in the map at `t` [s]: position [m], yaw [rad], speed [m/s], yaw rate [rad/s], acceleration [m/s^2]."""

    t: float
    x: float
    y: float
    yaw: float
    v: float
    yaw_rate: float
    ax: float
    position_sigma: float
    yaw_sigma: float

    def pose_at(self, t: float) -> tuple[float, float, float]:
        """x, y [m] and yaw [rad] at another time, at constant speed and yaw rate; meant for |t - self.t| < 0.5 s."""
        return moved(self.x, self.y, self.yaw, self.v, self.yaw_rate, t - self.t)


class Localizer(Protocol):
    """Turns observations into estimates; None until it knows where it is."""

    def update(self, observation: Observation) -> Estimate | None:
        """The estimate at `observation.t`."""


class EkfLocalizer:
    """Localizer by an extended Kalman filter (see ads.ekf).

    `heading_hint(x, y)` gives the yaw [rad] to start with where the GNSS has none; the map knows the lane's direction,
    and None off the road stands for 0.
    """

    def __init__(
        self,
        vehicle: VehicleDescription,
        heading_hint: Callable[[float, float], float | None],
        noise: FloatArray = NOISE,
    ) -> None:
        self._vehicle = vehicle
        self._hint = heading_hint
        self._noise = np.array(noise, dtype=np.float64)
        self._mean = np.zeros(6)
        self._cov = np.zeros((6, 6))
        self._hold = np.zeros(2)
        self._rows = np.zeros((CAPACITY, ROW))
        self._n = 0
        self._window = SHORTEST_WINDOW
        self._started = False
        self._speed = 0.0
        self._counts = np.zeros(2)
        self.mean = np.zeros(6)
        self.covariance = np.zeros((6, 6))

    @property
    def rejected(self) -> int:
        """GNSS fixes thrown away so far because they did not fit."""
        return int(self._counts[1])

    def update(self, observation: Observation) -> Estimate | None:
        """Fuse what arrived and predict to `observation.t`; None before the first GNSS fix."""
        now = observation.t
        if not self._started:
            for odometry in observation.odometry:
                self._speed = odometry.v
            if not observation.gnss:
                return None
            self._start(observation.gnss[0])
        self._collect(observation)
        self._n = advance(
            self._mean,
            self._cov,
            self._hold,
            self._rows,
            self._n,
            now - self._window,
            now,
            self._vehicle.gnss_x,
            self._noise,
            self._counts,
            self.mean,
            self.covariance,
        )
        x, y, yaw, v, w, _ = self.mean.tolist()
        p = self.covariance
        position = math.sqrt(max(0.5 * (p[0, 0] + p[1, 1]), 0.0))
        ax = observation.imu[-1].ax if observation.imu else float(self._hold[1])
        return Estimate(now, x, y, yaw, v, w, ax, position, math.sqrt(max(p[2, 2], 0.0)))

    def _start(self, fix: GnssFix) -> None:
        known = fix.yaw is not None
        yaw = fix.yaw if fix.yaw is not None else self._hint(fix.x, fix.y) or 0.0
        sigma_yaw = max(fix.yaw_sigma, 0.005) if known else 0.15
        lever = self._vehicle.gnss_x
        self._mean[:] = (
            fix.x - lever * math.cos(yaw), fix.y - lever * math.sin(yaw), yaw, self._speed, 0.0, 0.0,
        )  # fmt: skip
        position = max(fix.sigma, 0.01) ** 2 + (lever * sigma_yaw) ** 2
        np.fill_diagonal(self._cov, (position, position, sigma_yaw**2, 0.25, 0.01, 1e-4))
        self._hold[:] = (fix.t, 0.0)
        self._started = True

    def _collect(self, observation: Observation) -> None:
        rows, n, start = self._rows, self._n, self._hold[0]
        oldest = observation.t
        base = self._vehicle.wheelbase
        for fix in observation.gnss:
            oldest = min(oldest, fix.t)
            if fix.t > start and n < CAPACITY:
                yaw = fix.yaw
                rows[n] = (
                    fix.t, GNSS, fix.x, fix.y, max(fix.sigma, 0.01),
                    0.0 if yaw is None else yaw, 0.0 if yaw is None else max(fix.yaw_sigma, 0.002),
                )  # fmt: skip
                n += 1
        for odo in observation.odometry:
            oldest = min(oldest, odo.t)
            if odo.t > start and n < CAPACITY:
                w = odo.v * math.tan(odo.steer) / base
                # understeer: the kinematic yaw rate is worth less the faster the car turns and drives
                sigma = 0.02 + 0.1 * abs(w) + 0.002 * abs(odo.v)
                rows[n] = (odo.t, ODO, odo.v, ODOMETRY_SIGMA, w, sigma, 0.0)
                n += 1
        lever = self._vehicle.imu_x
        for imu in observation.imu:
            oldest = min(oldest, imu.t)
            if imu.t > start and n < CAPACITY:
                rows[n] = (imu.t, IMU, imu.yaw_rate, IMU_SIGMA, imu.ax + imu.yaw_rate**2 * lever, 0.0, 0.0)
                n += 1
        self._n = n
        self._window = min(LONGEST_WINDOW, max(self._window, observation.t - oldest + SHORTEST_WINDOW))
