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
        unit, due, normal, uniform = self._unit, self._clock.due, self._noise.normal, self._noise.uniform
        lx, ly, cosine, sine, dropout = unit.mount.x, unit.mount.y, self._cos, self._sin, unit.timing.dropout
        accel_sigma, gyro_sigma, send = unit.accel_sigma, unit.gyro_sigma, self._line.send
        bias_x, bias_y, bias_r = self._bias_x, self._bias_y, self._bias_r
        last_t, last_r = self._last_t, self._last_r
        for row in rows:
            t, r = row[0], row[8]
            gap = t - last_t
            turn = (r - last_r) / gap if gap > 0.0 else 0.0  # rad/s^2
            last_t, last_r = t, r
            if not due(t):
                continue
            ax = row[9] - turn * ly - r * r * lx
            ay = row[10] + turn * lx - r * r * ly
            seen_x = cosine * ax + sine * ay + bias_x + accel_sigma * normal()
            seen_y = -sine * ax + cosine * ay + bias_y + accel_sigma * normal()
            rate = r + bias_r + gyro_sigma * normal()
            if uniform() >= dropout:
                send(t, Imu(t, seen_x, seen_y, rate))
        self._last_t, self._last_r = last_t, last_r
