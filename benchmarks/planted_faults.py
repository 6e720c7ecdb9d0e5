"""Three short stacks with two planted faults each, rare in the ranges of their scenario; scripts/planted_search.py
searches them.

They go straight on and keep room to what their LiDAR sees in a corridor. Each fault needs several parameters of the
scenario together; a gate tells the two of a stack apart. How rare they are is set by the constants below: of Follower
from 1,000 even drives; those of Merged and Child are first guesses, and too frequent.
"""

from __future__ import annotations

import math
from typing import Any

from vehicle.messages import Command, Observation

ROOM, BRAKING = 4.0, 1.6  # m kept to what is ahead; m/s^2 by which it comes to that
SLAM = 6.0  # m/s^2 of a brake that is pushed down


class Straight:
    """Keeps its speed and its room, and goes straight on."""

    corridor = 1.1  # m to each side that must be free
    dead = 0.0  # s that a nearer obstacle stays unknown

    def __init__(self, parameters: Any, network: Any, description: Any) -> None:
        self.car = description
        self.front = description.center_x + 0.5 * description.length
        self.v, self.wanted, self.gap, self.before, self.closing = 0.0, 5.0, math.inf, math.inf, 0.0
        self.known: list[tuple[float, float]] = []
        self.slammed = -math.inf

    def tick(self, observation: Observation) -> Command:
        """The command of this moment."""
        if observation.task is not None and observation.task.set_speed:
            self.wanted = observation.task.set_speed
        for odometry in observation.odometry:
            self.v = odometry.v
        if observation.lidar is not None:
            self._look(observation.t, observation.lidar.points)
        keep = math.sqrt(2.0 * BRAKING * max(self.gap - ROOM, 0.0))
        accel = min(max(min(self.wanted, keep) - self.v, -2.5), 1.0)
        if self.slams():
            self.slammed = observation.t
        if observation.t - self.slammed < 1.0:
            accel = -SLAM
        return Command(observation.t, self.steer(observation.t), accel, max(accel, 0.0) / 3.5, max(-accel, 0.0) / 7.0)

    def _look(self, t: float, points: Any) -> None:
        seen = points[points[:, 2] + self.car.lidar_z > 0.3]
        along, beside = seen[:, 0] + self.car.lidar_x - self.front, abs(seen[:, 1] + self.car.lidar_y)
        ahead = along[(along > 0.0) & (beside < self.corridor)]
        gap = float(ahead.min()) if len(ahead) else math.inf
        self.known.append((t, gap))
        while len(self.known) > 1 and self.known[1][0] <= t - self.dead:
            self.known.pop(0)
        self.before, self.gap = self.gap, self.known[0][1]
        self.closing = (self.before - self.gap) / 0.1 if math.isfinite(self.before) else 0.0

    def slams(self) -> bool:
        """Whether it pushes the brake down now."""
        return False

    def steer(self, t: float) -> float:
        """Angle of the road wheels [rad]."""
        return 0.0


class Follower(Straight):
    """follow.xosc. Collision: what it sees is old. Hard brake: it takes a fast approach nearby for an emergency."""

    dead = 1.5
    near, fast = 5.0, 3.8  # m, m/s

    def slams(self) -> bool:
        return self.gap < self.near and self.closing > self.fast


class Merged(Straight):
    """cut_in.xosc. Collision: its corridor is narrow. Hard brake: as Follower."""

    corridor = 0.55
    dead = 0.3
    near, fast = 6.0, 3.0

    def slams(self) -> bool:
        return self.gap < self.near and self.closing > self.fast


class Child(Straight):
    """occluded_child.xosc. Collision: what it sees is old. Swerve: it steers if something appears close by."""

    dead = 0.2
    close = 5.0  # m
    swerved = -math.inf

    def steer(self, t: float) -> float:
        if not math.isfinite(self.before) and self.gap < self.close:
            self.swerved = t
        return 0.12 if t - self.swerved < 0.6 else 0.0
