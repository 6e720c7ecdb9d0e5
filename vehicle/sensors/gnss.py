"""GNSS receiver: antenna position, and heading if it has two antennas."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, exp, inf, sin, sqrt

import numpy as np

from vehicle.messages import GnssFix
from vehicle.model.errors import ModelError
from vehicle.sensors.common import Clock, Line, Mount, Noise, Timing, check_sigma


@dataclass(frozen=True, slots=True)
class Gnss:
    """White noise `sigma` [m] per axis plus a slow Gauss-Markov error `drift` [m] of `drift_time` [s].

    `yaw_sigma` [rad] is the noise of the heading, None for a receiver without one. Error model: P. Groves,
    Principles of GNSS, Inertial and Multisensor Integrated Navigation Systems, 2nd ed., sec. 9.3.
    """

    mount: Mount
    timing: Timing
    sigma: float = 0.03
    drift: float = 0.02
    drift_time: float = 60.0
    yaw_sigma: float | None = 0.005

    def __post_init__(self) -> None:
        check_sigma("sigma", self.sigma)
        check_sigma("drift", self.drift)
        check_sigma("yaw_sigma", self.yaw_sigma or 0.0)
        if not 0.0 < self.drift_time < inf:
            found = f"{self.drift_time:g}"
            raise ModelError("value not allowed", key="drift_time", found=found, allowed="more than 0 s")

    def start(self, t: float, seed: np.random.SeedSequence) -> RunningGnss:
        """The receiver at work from `t` [s]."""
        return RunningGnss(self, t, seed)


class RunningGnss:
    """A receiver at work."""

    def __init__(self, gnss: Gnss, t: float, seed: np.random.SeedSequence) -> None:
        self._gnss, self._clock, self._noise = gnss, Clock(gnss.timing, t), Noise(seed)
        self._line: Line[GnssFix] = Line(gnss.timing)
        self.arrived = self._line.arrived
        self._keep = exp(-1.0 / (gnss.timing.rate * gnss.drift_time)) if gnss.drift > 0.0 else 0.0
        self._renew = gnss.drift * sqrt(1.0 - self._keep**2)
        self._dx = gnss.drift * self._noise.normal()
        self._dy = gnss.drift * self._noise.normal()
        self._sigma = sqrt(gnss.sigma**2 + gnss.drift**2)

    def measure_all(self, rows: Sequence[Sequence[float]]) -> None:
        """Take trace rows (TRACE_COLUMNS), oldest first; measures at those at which it is time."""
        clock = self._clock
        for row in rows:
            if not row[0] < clock.earliest and clock.due(row[0]):
                self._measure(row)

    def _measure(self, row: Sequence[float]) -> None:
        t = row[0]
        gnss, normal = self._gnss, self._noise.normal
        self._dx = self._keep * self._dx + self._renew * normal()
        self._dy = self._keep * self._dy + self._renew * normal()
        yaw, mount = row[4], gnss.mount
        c, s = cos(yaw), sin(yaw)
        x = row[1] + c * mount.x - s * mount.y + self._dx + gnss.sigma * normal()
        y = row[2] + s * mount.x + c * mount.y + self._dy + gnss.sigma * normal()
        heading = None if gnss.yaw_sigma is None else yaw + gnss.yaw_sigma * normal()
        if self._noise.uniform() >= gnss.timing.dropout:
            self._line.send(t, GnssFix(t, x, y, self._sigma, heading, gnss.yaw_sigma or 0.0))
