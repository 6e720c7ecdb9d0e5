"""Scanning LiDAR: points on what its rays meet first."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, radians, sin

import numpy as np

from vehicle.messages import FloatArray, LidarScan
from vehicle.model.errors import ModelError
from vehicle.sensors.air import lidar_range
from vehicle.sensors.common import Clock, Line, Mount, Noise, NoiseArray, Timing, check_sigma
from vehicle.sensors.raycast import scan, to_points


@dataclass(frozen=True, slots=True)
class Lidar:
    """A scanner of `azimuths` rays over `field_of_view` [rad] about its x axis, in layers of `elevations` [rad].

    Returns between `nearest` and `reach` [m] with range noise `sigma` [m] count. `ground` adds returns of flat ground
    at the car's height. The whole scan is taken at one instant. Boxes are opaque and always reflect.
    """

    mount: Mount
    timing: Timing
    azimuths: int = 720
    field_of_view: float = 2.0 * pi
    elevations: tuple[float, ...] = (radians(-0.6), radians(-1.8), radians(-4.0))
    reach: float = 80.0
    nearest: float = 0.5
    sigma: float = 0.02
    ground: bool = False

    def __post_init__(self) -> None:
        check_sigma("sigma", self.sigma)
        if not 1 <= self.azimuths <= 100_000:
            raise ModelError("value not allowed", key="azimuths", found=str(self.azimuths), allowed="1 to 100000")
        if not 0.0 < self.field_of_view <= 2.0 * pi:
            found = f"{self.field_of_view:g}"
            raise ModelError("value not allowed", key="field_of_view", found=found, allowed="more than 0 to 2 pi rad")
        for each in self.elevations:
            if not -0.5 * pi < each < 0.5 * pi:
                found, allowed = f"{each:g}", "between -pi/2 and pi/2 rad"
                raise ModelError("value not allowed", key="elevations", found=found, allowed=allowed)
        if not 0.0 <= self.nearest < self.reach:
            raise ModelError("value not allowed", key="reach", found=f"{self.reach:g}", allowed="more than nearest")

    def start(self, t: float, seed: np.random.SeedSequence) -> RunningLidar:
        """The scanner at work from `t` [s]."""
        return RunningLidar(self, t, seed)


class RunningLidar:
    """A scanner at work."""

    def __init__(self, lidar: Lidar, t: float, seed: np.random.SeedSequence) -> None:
        self._lidar, self._clock = lidar, Clock(lidar.timing, t)
        chance, spread = seed.spawn(2)
        self._noise, self._spread = Noise(chance), NoiseArray(spread)
        self._line: Line[LidarScan] = Line(lidar.timing)
        # A ring divides the full turn evenly; an open field has a ray on each of its ends
        full = lidar.field_of_view >= 2.0 * pi - 1e-9
        gaps = lidar.azimuths if full else lidar.azimuths - 1
        self._pitch = (2.0 * pi if full else lidar.field_of_view) / gaps if gaps else 2.0 * pi
        self._first = -0.5 * self._pitch * (lidar.azimuths if full else lidar.azimuths - 1)
        angles = self._first + self._pitch * np.arange(lidar.azimuths)
        self._rays = np.column_stack((np.cos(angles), np.sin(angles)))
        self._tilts = np.tan(np.array(lidar.elevations, dtype=np.float64))
        self._depth = np.full((lidar.azimuths, len(lidar.elevations)), np.inf)

    def measure(
        self, t: float, x: float, y: float, z: float, yaw: float, boxes: FloatArray, extinction: float = 0.0
    ) -> None:
        """Scan `boxes` (n, 9) from the reference point's pose if it is time [s, m, rad].

        extinction: of the air [1/m]
        """
        if not self._clock.due(t):
            return
        lidar, mount = self._lidar, self._lidar.mount
        c, s = cos(yaw), sin(yaw)
        count = scan(
            boxes,
            x + c * mount.x - s * mount.y,
            y + s * mount.x + c * mount.y,
            z + mount.z,
            yaw + mount.yaw,
            mount.z,
            self._first,
            self._pitch,
            self._rays,
            self._tilts,
            max(lidar_range(lidar.reach, extinction), lidar.nearest),
            lidar.nearest,
            lidar.ground,
            self._depth,
        )
        points = to_points(self._depth, self._rays, self._tilts, self._spread.take(count), lidar.sigma)
        if self._noise.uniform() >= lidar.timing.dropout:
            self._line.send(t, LidarScan(t, points))

    def arrived(self, t: float) -> LidarScan | None:
        """The newest scan that has arrived since the last call, if any."""
        scans = self._line.arrived(t)
        return scans[-1] if scans else None
