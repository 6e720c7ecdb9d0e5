"""Plane poses and the transforms between the frames map, base (rear axle) and sensors."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ads.compiled import compiled
from vehicle.messages import FloatArray


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


def moved(x: float, y: float, yaw: float, v: float, yaw_rate: float, dt: float) -> tuple[float, float, float]:
    """Pose after `dt` [s] (may be negative) at constant speed [m/s] and yaw rate [rad/s].

    Midpoint rule; error below 1 mm for |yaw_rate * dt| < 0.1 and |v * dt| < 2 m.
    """
    half = yaw + 0.5 * yaw_rate * dt
    return x + v * dt * math.cos(half), y + v * dt * math.sin(half), yaw + yaw_rate * dt
