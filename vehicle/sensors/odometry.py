"""Wheel odometry: speed from wheel turns, and the reported steering angle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vehicle.messages import Odometry
from vehicle.sensors.common import Clock, Line, Noise, Timing, check_sigma


@dataclass(frozen=True, slots=True)
class WheelOdometry:
    """Speed of the rear axle times `scale` (rolling radius error) with noise `sigma` [m/s]; standing it reads zero.

    The steering report has noise `steer_sigma` [rad] and offset `steer_offset` [rad].
    """

    timing: Timing
    scale: float = 1.0
    sigma: float = 0.02
    steer_sigma: float = 0.001
    steer_offset: float = 0.0

    def __post_init__(self) -> None:
        check_sigma("sigma", self.sigma)
        check_sigma("steer_sigma", self.steer_sigma)

    def start(self, t: float, seed: np.random.SeedSequence) -> RunningOdometry:
        """The odometry at work from `t` [s]."""
        return RunningOdometry(self, t, seed)


class RunningOdometry:
    """Odometry at work."""

    def __init__(self, odometry: WheelOdometry, t: float, seed: np.random.SeedSequence) -> None:
        self._odometry, self._clock, self._noise = odometry, Clock(odometry.timing, t), Noise(seed)
        self._line: Line[Odometry] = Line(odometry.timing)
        self.arrived = self._line.arrived

    def measure_all(self, rows: Sequence[Sequence[float]]) -> None:
        """Take trace rows (TRACE_COLUMNS), oldest first; measures at those at which it is time."""
        clock, o, dropout = self._clock, self._odometry, self._odometry.timing.dropout
        normal, uniform, send = self._noise.normal, self._noise.uniform, self._line.send
        for row in rows:
            t = row[0]
            if t < clock.earliest or not clock.due(t):
                continue
            error = o.sigma * normal()
            v = o.scale * row[5] + error if row[5] != 0.0 else 0.0
            steer = row[11] + o.steer_offset + o.steer_sigma * normal()
            if uniform() >= dropout:
                send(t, Odometry(t, v, steer))
