"""Localization: GNSS, wheel odometry and IMU fused by stamps into one estimate per tick."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np

from ads.ekf import (
    COUNTS,
    FIX_NIS,
    GNSS,
    HA,
    HOLD,
    HW,
    IMU,
    NOISES,
    ODO,
    REJECTED,
    ROW,
    STATES,
    WHEEL_NIS,
    YAW_NIS,
    B,
    advance,
)
from ads.transforms import Pose, TransformTree, moved, sensor_frames
from vehicle.messages import FloatArray, GnssFix, Imu, Observation, VehicleDescription

UNKNOWN_SPEED = 15.0  # m/s, sigma before the wheels have spoken
SHORTEST_WINDOW = 0.05  # s
LONGEST_WINDOW = 0.5  # s; a measurement later than this is dropped
TURNING_TIME = 0.1  # s over which the change of the yaw rate is smoothed
NIS = (("nis_gnss", FIX_NIS), ("nis_heading", YAW_NIS), ("nis_wheels", WHEEL_NIS))  # name; place of the sum in COUNTS
CAPACITY = 512  # rows; at 400 rows/s and the longest window there is room to spare


class MotionNoise(NamedTuple):
    """What the filter takes the car and its sensors for. The defaults are those of the class: RTK GNSS, MEMS IMU.

    Densities per sqrt(s) down to `compliance_walk`.
    """

    slip: float = 0.007  # m, transient side slip
    gyro: float = 0.0002  # rad: 0.002 rad/s at 100 Hz
    steering: float = 0.03  # rad, yaw by the steering while no IMU speaks
    acceleration: float = 0.25  # m/s: slopes and the accelerometer's bias are in it
    bias_walk: float = 2e-5  # rad/s
    scale_walk: float = 1e-4  # of the speed
    compliance_walk: float = 1e-5  # rad s^2/m
    slow_share: float = 0.55  # of a fix's sigma that lasts
    slow_time: float = 60.0  # s that it lasts
    wheels: float = 0.02  # m/s, of one message of the odometry
    bias: float = 0.003  # rad/s, yaw rate's at start
    scale: float = 0.02  # wheel speed's at start
    compliance: float = 0.005  # rad s^2/m, side slip per lateral acceleration at start
    compliance_sigma: float = 0.005  # rad s^2/m


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
    covariance: FloatArray | None = None  # (4, 4) of x, y [m], yaw [rad], v [m/s]

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
    and None off the road stands for 0. `mean` and `covariance` are the filter's state at the last tick, `frames` the
    transform tree of then. `consistency`, by the names of NIS: mean normalised squared innovation (1 is expected) of
    the positions, headings and wheel speeds that the last tick took for good; of a kind of which it took none, of the
    last tick that did.
    """

    def __init__(
        self,
        vehicle: VehicleDescription,
        heading_hint: Callable[[float, float], float | None],
        noise: MotionNoise | None = None,
    ) -> None:
        self._vehicle = vehicle
        self._hint = heading_hint
        self._trust = noise or MotionNoise()
        self._noise = np.array(self._trust[:NOISES], dtype=np.float64)
        self._lever = np.array([vehicle.gnss_x, vehicle.gnss_y])
        self._mean = np.zeros(STATES)
        self._cov = np.zeros((STATES, STATES))
        self._hold = np.zeros(HOLD)
        self._hold_now = np.zeros(HOLD)
        self._rows = np.zeros((CAPACITY, ROW))
        self._n = 0
        self._window = SHORTEST_WINDOW
        self._started = False
        self._speed: float | None = None
        self._counts = np.zeros(COUNTS)
        self.consistency: dict[str, float] = {}
        self.mean = np.zeros(STATES)
        self.covariance = np.zeros((STATES, STATES))
        self._mounts = sensor_frames(vehicle)
        self._odom = Pose(0.0, 0.0, 0.0)
        self._last: Estimate | None = None
        self._spin: Imu | None = None  # the newest
        self._spin_rate = 0.0  # rad/s^2

    @property
    def rejected(self) -> int:
        """GNSS fixes thrown away so far because they did not fit."""
        return int(self._counts[REJECTED])

    @property
    def frames(self) -> TransformTree | None:
        """Map, odom, base and sensors at the last tick; None before the first fix."""
        if self._last is None:
            return None
        base = Pose(self._last.x, self._last.y, self._last.yaw)
        return TransformTree(base.then(self._odom.inverse()), self._odom, self._mounts)

    def update(self, observation: Observation) -> Estimate | None:
        """Fuse what arrived and predict to `observation.t`; None before the first GNSS fix."""
        now = observation.t
        if not self._started:
            for odometry in observation.odometry:
                if math.isfinite(odometry.v):
                    self._speed = odometry.v
            fixes = [fix for fix in observation.gnss if _is_fix(fix)]
            if not fixes:
                return None
            self._start(fixes[0])
        self._collect(observation)
        counted = self._counts.copy()
        self._n = advance(
            self._mean,
            self._cov,
            self._hold,
            self._rows,
            self._n,
            now - self._window,
            now,
            self._lever,
            self._noise,
            self._counts,
            self.mean,
            self.covariance,
            self._hold_now,
        )
        counted = self._counts - counted
        for name, place in NIS:
            if counted[place + 1] > 0.0:
                self.consistency[name] = float(counted[place] / counted[place + 1])
        x, y, yaw, v, bias = self.mean[: B + 1].tolist()
        w = float(self._hold_now[HW]) - bias
        p = self.covariance
        position = math.sqrt(max(0.5 * (p[0, 0] + p[1, 1]), 0.0))
        felt = [imu for imu in observation.imu if math.isfinite(imu.ax + imu.ay)]
        ax = self._ahead(felt[-1]) if felt else float(self._hold_now[HA])
        before, sigma = self._last, math.sqrt(max(p[2, 2], 0.0))
        self._last = Estimate(now, x, y, yaw, v, w, ax, position, sigma, p[:4, :4].copy())
        if before is not None:  # dead reckoning: smooth, whatever the fixes say
            self._odom = Pose(*moved(*self._odom, 0.5 * (before.v + v), 0.5 * (before.yaw_rate + w), now - before.t))
        return self._last

    def _start(self, fix: GnssFix) -> None:
        known = fix.yaw is not None
        hint = None if known else self._hint(fix.x, fix.y)
        yaw = fix.yaw if fix.yaw is not None else hint or 0.0
        sigma_yaw = max(fix.yaw_sigma, 0.005) if known else 0.15 if hint is not None else 1.0
        x, y = self._lever.tolist()
        c, s = math.cos(yaw), math.sin(yaw)
        trust = self._trust
        self._mean[:] = (
            fix.x - x * c + y * s, fix.y - x * s - y * c, yaw, self._speed or 0.0, 0.0, 0.0, trust.compliance, 0.0, 0.0,
        )  # fmt: skip
        sigma = max(fix.sigma, 0.01)
        slow = trust.slow_share * sigma
        speed = UNKNOWN_SPEED if self._speed is None else 0.5
        position = sigma**2 + (math.hypot(x, y) * sigma_yaw) ** 2
        np.fill_diagonal(
            self._cov,
            (position, position, sigma_yaw**2, speed**2, trust.bias**2, trust.scale**2, trust.compliance_sigma**2,
             slow**2, slow**2),
        )  # fmt: skip
        for place, error in ((0, 7), (1, 8)):  # the fix's slow error is in the position from the start
            self._cov[place, error] = self._cov[error, place] = -(slow**2)
        self._hold[:] = (fix.t, 0.0, 0.0, -math.inf, trust.steering, slow)
        self._started = True

    def _collect(self, observation: Observation) -> None:
        start, room = self._hold[0], CAPACITY - self._n
        oldest = observation.t
        base, wheels, finite = self._vehicle.wheelbase, self._trust.wheels, math.isfinite
        rows: list[tuple[float, ...]] = []
        for fix in observation.gnss:
            t = fix.t
            oldest = min(oldest, t)
            if t > start and _is_fix(fix):
                yaw = fix.yaw
                rows.append(
                    (t, GNSS, fix.x, fix.y, max(fix.sigma, 0.01), 0.0, 0.0)
                    if yaw is None
                    else (t, GNSS, fix.x, fix.y, max(fix.sigma, 0.01), yaw, max(fix.yaw_sigma, 0.002))
                )
        for odo in observation.odometry:
            t, v, steer = odo.t, odo.v, odo.steer
            if t < oldest:
                oldest = t
            if t > start and finite(v + steer):
                rows.append((t, ODO, v, wheels, v * math.tan(steer) / base, 0.0, 0.0))
        ahead, beside = self._vehicle.imu_x, self._vehicle.imu_y
        straight = self._vehicle.imu_yaw == 0.0
        for imu in observation.imu:
            t, rate = imu.t, imu.yaw_rate
            if t < oldest:
                oldest = t
            ax = imu.ax if straight else self._ahead(imu)
            if t > start and finite(ax + rate):
                ax += rate**2 * ahead
                if beside != 0.0:
                    ax += self._turning(imu) * beside
                rows.append((t, IMU, rate, ax, 0.0, 0.0, 0.0))
        if rows := rows[:room]:
            self._rows[self._n : self._n + len(rows)] = rows
            self._n += len(rows)
        self._window = min(LONGEST_WINDOW, max(self._window, observation.t - oldest + SHORTEST_WINDOW))

    def _ahead(self, imu: Imu) -> float:
        """Specific force [m/s^2] along the car's x axis where the unit sits, which may look askew."""
        yaw = self._vehicle.imu_yaw
        return imu.ax if yaw == 0.0 else imu.ax * math.cos(yaw) - imu.ay * math.sin(yaw)

    def _turning(self, imu: Imu) -> float:
        """Change of the yaw rate [rad/s^2], smoothed over TURNING_TIME: a unit beside the middle is sped up by it."""
        before, turning = self._spin, self._spin_rate
        if before is None or not 0.0 < imu.t - before.t < 1.0:
            if before is None or imu.t > before.t:
                self._spin, self._spin_rate = imu, 0.0
            return self._spin_rate
        dt = imu.t - before.t
        turning += dt / (TURNING_TIME + dt) * ((imu.yaw_rate - before.yaw_rate) / dt - turning)
        self._spin, self._spin_rate = imu, turning
        return turning


def _is_fix(fix: GnssFix) -> bool:
    """Whether a fix holds numbers; receivers without one send NaN."""
    return math.isfinite(fix.x + fix.y + fix.sigma + fix.yaw_sigma + (fix.yaw or 0.0))
