"""A closed loop of the tests' own: kinematic bicycle at the rear axle, ideal sensors, boxes that move straight."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ads.parameters import Parameters
from ads.stack import Stack
from vehicle.messages import GnssFix, Imu, Observation, Odometry, Task, VehicleDescription

TABBY = VehicleDescription(
    length=3.03, width=1.488, height=1.38, wheelbase=2.36, center_x=1.0, max_steer=math.radians(20.0), max_speed=33.0,
    max_acceleration=2.5, max_deceleration=8.0, mass=730.0, lidar_x=1.2, camera_x=0.8,
)  # fmt: skip
SEDAN = VehicleDescription(
    length=4.4, width=1.8, height=1.5, wheelbase=2.7, center_x=1.35, max_steer=math.radians(35.0), max_speed=60.0,
    max_acceleration=4.0, max_deceleration=9.0, mass=1500.0, lidar_x=1.5, camera_x=1.2,
)  # fmt: skip
DT = 0.05


@dataclass
class Car:
    """Kinematic bicycle with a first-order drive lag; integrates at 100 Hz."""

    description: VehicleDescription
    x: float
    y: float
    yaw: float
    v: float = 0.0
    a: float = 0.0
    yaw_rate: float = 0.0
    steer: float = 0.0
    lag: float = 0.1

    def step(self, steer: float, accel: float) -> None:
        for _ in range(5):
            h = DT / 5
            self.steer += (steer - self.steer) * h / 0.05
            self.a += (accel - self.a) * h / self.lag
            v = max(self.v + self.a * h, 0.0)
            if v == 0.0:
                self.a = max(self.a, 0.0)
            self.yaw_rate = self.v * math.tan(self.steer) / self.description.wheelbase
            self.x += 0.5 * (v + self.v) * h * math.cos(self.yaw + 0.5 * self.yaw_rate * h)
            self.y += 0.5 * (v + self.v) * h * math.sin(self.yaw + 0.5 * self.yaw_rate * h)
            self.yaw += self.yaw_rate * h
            self.v = v


@dataclass
class Drive:
    """What a closed-loop run leaves: arrays over ticks."""

    rows: list[tuple[float, ...]] = field(default_factory=list)
    traces: list[dict[str, float]] = field(default_factory=list)
    off_path: list[float] = field(default_factory=list)

    def column(self, i: int) -> np.ndarray:
        return np.array([row[i] for row in self.rows])

    @property
    def v(self) -> np.ndarray:
        return self.column(3)

    def jerk(self) -> float:
        """Largest |jerk| [m/s^3] of the acceleration behind a 2 Hz Butterworth filter of second order, no phase."""
        from scipy.signal import butter, filtfilt

        b, a = butter(2, 2.0, fs=1.0 / DT)
        return float(np.abs(np.gradient(filtfilt(b, a, self.column(5)), DT)).max())

    def rmse(self) -> float:
        return float(np.sqrt(np.mean(np.square(self.off_path))))


def distance_to_path(path: np.ndarray, x: float, y: float) -> float:
    a, b = path[:-1], path[1:]
    d = b - a
    r = np.clip(((x - a[:, 0]) * d[:, 0] + (y - a[:, 1]) * d[:, 1]) / np.maximum((d**2).sum(axis=1), 1e-12), 0, 1)
    return float(np.hypot(a[:, 0] + r * d[:, 0] - x, a[:, 1] + r * d[:, 1] - y).min())


def observe(car: Car, t: float, task: Task | None = None, **more: object) -> Observation:
    """Ideal sensors: GNSS 10 Hz, odometry and IMU 20 Hz, no noise."""
    d = car.description
    fix = GnssFix(t, car.x + d.gnss_x * math.cos(car.yaw), car.y + d.gnss_x * math.sin(car.yaw), 0.02)
    return Observation(
        t=t,
        gnss=(fix,) if round(t / DT) % 2 == 0 else (),
        odometry=(Odometry(t, car.v, car.steer),),
        imu=(Imu(t, car.a, car.v * car.yaw_rate, car.yaw_rate),),
        task=task,
        **more,  # type: ignore[arg-type]
    )


def drive(
    stack: Stack,
    car: Car,
    duration: float,
    task: Task | None = None,
    sense: Callable[[float, Car], dict[str, object]] | None = None,
    watch: Callable[[float, Car], None] | None = None,
) -> Drive:
    """Run the loop; `sense` adds LiDAR, camera or signals, `watch` sees each tick."""
    log = Drive()
    for k in range(round(duration / DT)):
        t = k * DT
        more = sense(t, car) if sense is not None else {}
        command = stack.tick(observe(car, t, task if k == 0 else None, **more))
        log.rows.append((t, car.x, car.y, car.v, car.yaw, car.a, command.steer, command.accel))
        log.traces.append(dict(stack.trace))
        if stack.path is not None:
            log.off_path.append(distance_to_path(stack.path, car.x, car.y))
        if watch is not None:
            watch(t, car)
        car.step(command.steer, command.accel)
    return log


def new_stack(network: object, description: VehicleDescription = TABBY, **more: object) -> Stack:
    parameters = more.pop("parameters", None) or Parameters()
    return Stack(parameters, network, description, **more)  # type: ignore[arg-type]
