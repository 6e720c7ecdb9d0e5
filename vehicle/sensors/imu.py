"""Inertial measurement unit: specific force and yaw rate where it is mounted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, sin

import numpy as np

from vehicle.messages import Imu
from vehicle.sensors.common import Clock, Line, Mount, Noise, Timing, check_sigma


@dataclass(frozen=True, slots=True)
class InertialUnit:
    """White noise per sample and a constant bias drawn at start.

    `accel_sigma`, `accel_bias` [m/s^2], `gyro_sigma`, `gyro_bias` [rad/s] are standard deviations. Specific force at
    the mount: a + r' x p - r^2 p (rigid body). Source: P. Groves, sec. 4.4.
    """

    mount: Mount
    timing: Timing
    accel_sigma: float = 0.05
    accel_bias: float = 0.02
    gyro_sigma: float = 0.002
    gyro_bias: float = 0.0005

    def __post_init__(self) -> None:
        for name in ("accel_sigma", "accel_bias", "gyro_sigma", "gyro_bias"):
            check_sigma(name, getattr(self, name))

    def start(self, t: float, seed: np.random.SeedSequence) -> RunningImu:
        """The unit at work from `t` [s]."""
        return RunningImu(self, t, seed)


class RunningImu:
    """A unit at work."""

    def __init__(self, unit: InertialUnit, t: float, seed: np.random.SeedSequence) -> None:
        self._unit, self._clock, self._noise = unit, Clock(unit.timing, t), Noise(seed)
        self._line: Line[Imu] = Line(unit.timing)
        self.arrived = self._line.arrived
        self._bias_x = unit.accel_bias * self._noise.normal()
        self._bias_y = unit.accel_bias * self._noise.normal()
        self._bias_r = unit.gyro_bias * self._noise.normal()
        self._cos, self._sin = cos(unit.mount.yaw), sin(unit.mount.yaw)
        self._last_t, self._last_r = t, 0.0

    def measure_all(self, rows: Sequence[Sequence[float]]) -> None:
        """Take trace rows (TRACE_COLUMNS), oldest first; measures at those at which it is time."""
        unit, noise, clock, send = self._unit, self._noise, self._clock, self._line.send
        lx, ly, cosine, sine, dropout = unit.mount.x, unit.mount.y, self._cos, self._sin, unit.timing.dropout
        last_t, last_r = self._last_t, self._last_r
        for row in rows:
            t, r = row[0], row[8]
            gap = t - last_t
            turn = (r - last_r) / gap if gap > 0.0 else 0.0  # rad/s^2
            last_t, last_r = t, r
            if not clock.due(t):
                continue
            ax = row[9] - turn * ly - r * r * lx
            ay = row[10] + turn * lx - r * r * ly
            noise_x, noise_y, noise_r = noise.normals(3)
            seen_x = cosine * ax + sine * ay + self._bias_x + unit.accel_sigma * noise_x
            seen_y = -sine * ax + cosine * ay + self._bias_y + unit.accel_sigma * noise_y
            rate = r + self._bias_r + unit.gyro_sigma * noise_r
            if noise.uniform() >= dropout:
                send(t, Imu(t, seen_x, seen_y, rate))
        self._last_t, self._last_r = last_t, last_r
