"""A stack with two planted faults that are rare in the ranges of follow.xosc; scripts/planted_search.py searches them.

It goes straight on and keeps room to what its LiDAR sees in a corridor. Each fault needs several parameters of the
scenario together, and breaks a gate of its own. The constants were set from 1,000 even drives; of 6,500 others, 2 broke
the first gate and 4 the second one.
"""

from __future__ import annotations

import math
from typing import Any

from vehicle.messages import Command, Observation

ROOM, BRAKING = 4.0, 1.6  # m kept to what is ahead; m/s^2 by which it comes to that
CORRIDOR, ABOVE = 1.1, 0.3  # m to each side that must be free; m above the ground that counts
OLD = 1.5  # s by which what it sees is too old: the first fault
NEAR, FAST, SLAM = 5.0, 3.8, 6.0  # m, m/s: an approach that it takes for an emergency; m/s^2 then: the second fault
SCAN = 0.1  # s between two scans


class Follower:
    """Collision: what it sees is old. Hard brake: it takes a fast approach nearby for an emergency."""

    def __init__(self, parameters: Any, network: Any, description: Any) -> None:
        self.car = description
        self.front = description.center_x + 0.5 * description.length
        self.v, self.wanted, self.gap, self.closing = 0.0, 5.0, math.inf, 0.0
        self.seen: list[tuple[float, float]] = []
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
        if self.gap < NEAR and self.closing > FAST:
            self.slammed = observation.t
        if observation.t - self.slammed < 1.0:
            accel = -SLAM
        return Command(observation.t, 0.0, accel, max(accel, 0.0) / 3.5, max(-accel, 0.0) / 7.0)

    def _look(self, t: float, points: Any) -> None:
        high = points[points[:, 2] + self.car.lidar_z > ABOVE]
        along, beside = high[:, 0] + self.car.lidar_x - self.front, abs(high[:, 1] + self.car.lidar_y)
        ahead = along[(along > 0.0) & (beside < CORRIDOR)]
        self.seen.append((t, float(ahead.min()) if len(ahead) else math.inf))
        while len(self.seen) > 1 and self.seen[1][0] <= t - OLD:
            self.seen.pop(0)
        before, self.gap = self.gap, self.seen[0][1]
        self.closing = (before - self.gap) / SCAN if math.isfinite(before) else 0.0
