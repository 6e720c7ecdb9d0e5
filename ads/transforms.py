"""Plane poses and the transforms between the frames map, base (rear axle) and sensors."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from machine_code import compiled
from vehicle.messages import FloatArray, VehicleDescription


@compiled
def wrap_angle(angle: float) -> float:
    """The same angle [rad] in (-pi, pi]."""
    return angle - 2.0 * math.pi * math.ceil((angle - math.pi) / (2.0 * math.pi))


class Pose(NamedTuple):
    """A frame in its parent: position [m] and yaw [rad]. `a.then(b)` is the frame b, given in a, in a's parent."""

    x: float
    y: float
    yaw: float

    def then(self, child: Pose) -> Pose:
        """Composition: the pose of `child`, which is given in this frame, in this frame's parent."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return Pose(self.x + c * child.x - s * child.y, self.y + s * child.x + c * child.y, self.yaw + child.yaw)

    def inverse(self) -> Pose:
        """The parent in this frame."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return Pose(-c * self.x - s * self.y, s * self.x - c * self.y, -self.yaw)

    def apply(self, points: FloatArray) -> FloatArray:
        """Points (n, 2) of this frame [m] in its parent, (n, 2)."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        there: FloatArray = np.asarray(points) @ np.array([[c, s], [-s, c]]) + np.array([self.x, self.y])
        return there


class TransformTree(NamedTuple):
    """Frames of the car in the plane, as in REP-105: map -> odom -> base -> sensors.

    `odom` moves smoothly (dead reckoning) and drifts; `map_odom` corrects it and may jump.
    """

    map_odom: Pose
    odom_base: Pose
    sensors: Mapping[str, Pose]

    def lookup(self, target: str, source: str) -> Pose:
        """The frame `source` in the frame `target`; names are map, odom, base and those of `sensors`.

        Raises: KeyError for another name; it says which there are.
        """
        return self._in_map(target).inverse().then(self._in_map(source))

    def _in_map(self, name: str) -> Pose:
        if name == "map":
            return Pose(0.0, 0.0, 0.0)
        if name == "odom":
            return self.map_odom
        base = self.map_odom.then(self.odom_base)
        if name == "base":
            return base
        if name not in self.sensors:
            raise KeyError(f"no frame {name!r}; there are {', '.join(('map', 'odom', 'base', *self.sensors))}")
        return base.then(self.sensors[name])


def sensor_frames(car: VehicleDescription) -> Mapping[str, Pose]:
    """Where the sensors sit on the car."""
    return {
        "gnss": Pose(car.gnss_x, car.gnss_y, 0.0),
        "imu": Pose(car.imu_x, car.imu_y, car.imu_yaw),
        "lidar": Pose(car.lidar_x, car.lidar_y, car.lidar_yaw),
        "camera": Pose(car.camera_x, car.camera_y, car.camera_yaw),
    }


def moved(x: float, y: float, yaw: float, v: float, yaw_rate: float, dt: float) -> tuple[float, float, float]:
    """Pose after `dt` [s] (may be negative) at constant speed [m/s] and yaw rate [rad/s].

    Midpoint rule; error below 1 mm for |yaw_rate * dt| < 0.1 and |v * dt| < 2 m.
    """
    half = yaw + 0.5 * yaw_rate * dt
    return x + v * dt * math.cos(half), y + v * dt * math.sin(half), yaw + yaw_rate * dt
