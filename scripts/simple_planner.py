"""A stack of another make, for `dvp mutate`: pure pursuit on its lanes, and room kept to what the LiDAR sees there.

    dvp mutate SCENARIO... --ads scripts/simple_planner.py:SimplePlanner

No tracking, no prediction, no map of lights: 60 lines that share nothing with the reference stack.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from vehicle.messages import Command, Observation

LOOK, LATERAL = 0.6, 1.5  # s: how far ahead it steers at; m/s^2 in bends
ROOM, BRAKING = 5.0, 1.5  # m kept to what is ahead; m/s^2 by which it comes to that
HALF = 1.1  # m beside its path that must be free


class SimplePlanner:
    """Follows the middle of its lanes to the goal, slower where something is in the way."""

    def __init__(self, parameters: Any, network: Any, description: Any) -> None:
        self.network, self.car = network, description
        self.task: Any = None
        self.path: Any = None
        self.line: Any = None
        self.pose: tuple[float, float, float] | None = None
        self.v, self.gap = 0.0, math.inf

    def tick(self, observation: Observation) -> Command:
        """One step."""
        self.task = observation.task or self.task
        for odometry in observation.odometry:
            self.v = odometry.v
        for fix in observation.gnss:
            if fix.yaw is None:
                continue
            c, s = math.cos(fix.yaw), math.sin(fix.yaw)
            forward, left = self.v * (observation.t - fix.t) - self.car.gnss_x, -self.car.gnss_y
            self.pose = fix.x + forward * c - left * s, fix.y + forward * s + left * c, fix.yaw
        if self.pose is None:
            return Command(observation.t, 0.0, 0.0, 0.0, 0.0)
        x, y, yaw = self.pose
        if self.path is None:
            here = self.network.locate(x, y, yaw)
            goal = self.task.goal or self.network.advance(here, 200.0)[:3]
            self.line = self.network.centreline(self.network.route(here[:3], goal), 0.5)
            self.path = self.line[:, :2]
        nearest = int(np.argmin(np.hypot(*(self.path - (x, y)).T)))
        if observation.lidar is not None:
            self.gap = self._free(observation.lidar.points, nearest)
        ahead = min(nearest + int((3.0 + LOOK * self.v) / 0.5), len(self.path) - 1)
        dx, dy = self.path[ahead] - (x, y)
        sideways = dy * math.cos(yaw) - dx * math.sin(yaw)
        steer = math.atan(2.0 * self.car.wheelbase * sideways / max(dx * dx + dy * dy, 1.0))
        bend = np.abs(self.line[nearest : nearest + 40, 3]).max()
        to_goal = 0.5 * (len(self.path) - 1 - nearest)
        wanted = min(self.task.set_speed or 5.0, math.sqrt(LATERAL / max(bend, 1e-3)), math.sqrt(1.2 * to_goal))
        wanted = min(wanted, math.sqrt(2.0 * BRAKING * max(self.gap - ROOM, 0.0)))
        accel = min(max(wanted - self.v, -6.0), 1.0)
        return Command(observation.t, steer, accel, max(accel, 0.0) / 3.5, max(-accel, 0.0) / 7.0)

    def _free(self, points: Any, nearest: int) -> float:
        """Free path [m] before the bumper; `points` (n, 3) from the LiDAR [m]."""
        assert self.pose is not None
        x, y, yaw = self.pose
        seen = points[(points[:, 2] + self.car.lidar_z > 0.3) & (points[:, 0] > 0.0) & (points[:, 0] < 40.0)]
        px, py = seen[:, 0] + self.car.lidar_x, seen[:, 1] + self.car.lidar_y
        world = np.column_stack((x + px * np.cos(yaw) - py * np.sin(yaw), y + px * np.sin(yaw) + py * np.cos(yaw)))
        path = self.path[nearest : nearest + 80]
        if not len(world):
            return math.inf
        apart = np.hypot(world[:, :1] - path[:, 0], world[:, 1:] - path[:, 1])
        near = apart.min(axis=1) < HALF
        front = self.car.center_x + 0.5 * self.car.length
        return float(0.5 * apart.argmin(axis=1)[near].min() - front) if near.any() else math.inf
