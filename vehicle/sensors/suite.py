"""The sensors of a car together: their description, and the same at work."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import msgspec
import numpy as np

from vehicle.messages import (
    CameraFrame,
    GnssFix,
    Imu,
    LidarScan,
    Observation,
    Odometry,
    Reading,
    Surroundings,
    Task,
    VehicleDescription,
)
from vehicle.model.car import Car
from vehicle.model.errors import ModelError
from vehicle.sensors.camera import Camera
from vehicle.sensors.common import Mount, Timing
from vehicle.sensors.further import further_sensors
from vehicle.sensors.gnss import Gnss
from vehicle.sensors.imu import InertialUnit
from vehicle.sensors.lidar import Lidar
from vehicle.sensors.odometry import WheelOdometry

SENSORS = ("gnss", "odometry", "imu", "lidar", "camera")  # those with a message of their own, as Observation has them
HIGHEST = {"gnss": 100.0, "odometry": 100.0, "imu": 100.0, "lidar": 20.0, "camera": 20.0}  # Hz: rows of motion, ticks
TABBY_CENTER_X = 1.18  # m, rear axle to the middle of the TABBY EVO


class RunningSensor(Protocol):
    """A further sensor at work."""

    def measure(self, row: Sequence[float]) -> None:
        """Take a trace row (TRACE_COLUMNS); measure if it is time."""
        ...

    def arrived(self, t: float) -> tuple[Reading, ...]:
        """Readings that have arrived by `t` [s], oldest first; each only once."""
        ...


class Sensor(Protocol):
    """The description of a further sensor."""

    def start(self, t: float, seed: np.random.SeedSequence) -> RunningSensor:
        """The sensor at work from `t` [s], drawing from `seed`."""
        ...


@dataclass(frozen=True, slots=True)
class SensorSuite:
    """Which sensors a car has; None = it lacks that one. further: others, by the name of their file.

    Sensors of motion measure at most at the 100 Hz of the trace, LiDAR and camera at the 20 Hz of the ticks. Raises
    ModelError for a rate above that.
    """

    gnss: Gnss | None = None
    odometry: WheelOdometry | None = None
    imu: InertialUnit | None = None
    lidar: Lidar | None = None
    camera: Camera | None = None
    further: Mapping[str, Sensor] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, highest in HIGHEST.items():
            sensor = getattr(self, name)
            if sensor is not None and sensor.timing.rate > highest:
                found, allowed = f"{sensor.timing.rate:g}", f"more than 0 to {highest:g} Hz"
                raise ModelError("value not allowed", key=f"{name} rate", found=found, allowed=allowed)

    def with_mount_x(self, sensor: str, x: float) -> SensorSuite:
        """The suite with `sensor` ("gnss", "imu", "lidar" or "camera") moved to `x` [m]; unchanged if it lacks it."""
        if sensor == "gnss" and self.gnss:
            return replace(self, gnss=replace(self.gnss, mount=replace(self.gnss.mount, x=x)))
        if sensor == "imu" and self.imu:
            return replace(self, imu=replace(self.imu, mount=replace(self.imu.mount, x=x)))
        if sensor == "lidar" and self.lidar:
            return replace(self, lidar=replace(self.lidar, mount=replace(self.lidar.mount, x=x)))
        if sensor == "camera" and self.camera:
            return replace(self, camera=replace(self.camera, mount=replace(self.camera.mount, x=x)))
        return self

    def describe(self, car: VehicleDescription) -> VehicleDescription:
        """`car` with the mounting of these sensors."""
        found: dict[str, float | int] = {}
        if self.gnss:
            found |= {"gnss_x": self.gnss.mount.x, "gnss_y": self.gnss.mount.y}
        if self.imu:
            mount = self.imu.mount
            found |= {"imu_x": mount.x, "imu_y": mount.y, "imu_yaw": mount.yaw}
        if self.lidar:
            mount = self.lidar.mount
            found |= {"lidar_x": mount.x, "lidar_y": mount.y, "lidar_z": mount.z, "lidar_yaw": mount.yaw}
        if self.camera:
            camera = self.camera
            mount = camera.mount
            found |= {"camera_x": mount.x, "camera_y": mount.y, "camera_z": mount.z, "camera_yaw": mount.yaw}
            found |= {"camera_focal": camera.focal}
            found |= {"camera_width": camera.width, "camera_height": camera.height}
        return msgspec.structs.replace(car, **found)

    def start(self, row: Sequence[float], seed: int, reads: Collection[str] | None = None) -> RunningSensors:
        """The sensors at work from the first trace row on; each draws from a generator of its own.

        reads: names of those that somebody reads, the others stay silent; None: all. What one measures does not
        depend on which others work.
        """
        return RunningSensors(self, row, seed, reads)


class RunningSensors:
    """Sensors at work: fed with trace rows and, at each tick, with the surroundings."""

    def __init__(
        self, suite: SensorSuite, row: Sequence[float], seed: int, reads: Collection[str] | None = None
    ) -> None:
        t = row[0]
        names = (*SENSORS, *suite.further)
        dice = dict(zip(names, np.random.SeedSequence(seed).spawn(len(names)), strict=True))
        if reads is not None:
            dice = {name: each for name, each in dice.items() if name in reads}
        self._gnss = suite.gnss.start(t, dice["gnss"]) if suite.gnss and "gnss" in dice else None
        self._odometry = suite.odometry.start(t, dice["odometry"]) if suite.odometry and "odometry" in dice else None
        self._imu = suite.imu.start(t, dice["imu"]) if suite.imu and "imu" in dice else None
        self._lidar = suite.lidar.start(t, dice["lidar"]) if suite.lidar and "lidar" in dice else None
        self._camera = suite.camera.start(t, dice["camera"]) if suite.camera and "camera" in dice else None
        self._further = {name: each.start(t, dice[name]) for name, each in suite.further.items() if name in dice}
        self._moving = [s.measure_all for s in (self._gnss, self._odometry, self._imu) if s]
        self._row = row
        self.feed([row])

    def feed(self, rows: Sequence[Sequence[float]], place: Sequence[float] | None = None) -> None:
        """Let the sensors of motion measure along trace rows (TRACE_COLUMNS), oldest first.

        `place`: the row from which LiDAR and camera look around, where it is not the last of `rows`.
        """
        for measure_all in self._moving:
            measure_all(rows)
        for sensor in self._further.values():
            for row in rows:
                sensor.measure(row)
        if rows:
            self._row = rows[-1] if place is None else place

    def observe(self, t: float, surroundings: Surroundings, task: Task | None = None) -> Observation:
        """Let LiDAR and camera look around, then collect everything that has arrived by `t` [s]."""
        _, x, y, z, yaw, *_ = self._row
        gnss: tuple[GnssFix, ...] = self._gnss.arrived(t) if self._gnss else ()
        odometry: tuple[Odometry, ...] = self._odometry.arrived(t) if self._odometry else ()
        imu: tuple[Imu, ...] = self._imu.arrived(t) if self._imu else ()
        lidar: LidarScan | None = None
        camera: CameraFrame | None = None
        if self._lidar:
            self._lidar.measure(t, x, y, z, yaw, surroundings.seen_by("lidar").boxes, surroundings.extinction)
            lidar = self._lidar.arrived(t)
        if self._camera:
            self._camera.measure(t, x, y, z, yaw, surroundings.seen_by("camera"))
            camera = self._camera.arrived(t)
        readings = {name: new for name, sensor in self._further.items() if (new := sensor.arrived(t))}
        return Observation(t, gnss, odometry, imu, lidar, camera, surroundings.signals, task, readings)


def default_sensors(parameters: Mapping[str, float] | None = None, *, car: Car | None = None) -> SensorSuite:
    """The sensors of the TABBY EVO as the paper has them, on `car` (its centre is where S measures from).

    `parameters` are values of S: GNSS_x and CAMERA_x [m, from the ego's centre]; others are not the sensors' and
    ignored. Noise and latencies are those of the class: RTK GNSS with two antennas, industrial MEMS IMU, a LiDAR of
    three layers, a 1280 x 720 camera with a real-time detector.
    """
    values = parameters or {}
    center = car.center_x if car else TABBY_CENTER_X
    return SensorSuite(
        gnss=Gnss(Mount(x=center + values.get("GNSS_x", -1.0), z=1.5), Timing(rate=10.0, latency=0.05)),
        odometry=WheelOdometry(Timing(rate=50.0, latency=0.01)),
        imu=InertialUnit(Mount(x=center, z=0.5), Timing(rate=100.0, latency=0.0)),
        lidar=Lidar(Mount(x=center, z=1.5), Timing(rate=10.0, latency=0.05)),
        camera=Camera(Mount(x=center + values.get("CAMERA_x", 0.4), z=1.4), Timing(rate=10.0, latency=0.1)),
        further={name: module.default() for name, module in further_sensors().items()},
    )
