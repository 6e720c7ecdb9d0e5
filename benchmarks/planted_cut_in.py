"""A stack with two planted faults that are rare in the ranges of cut_in.xosc; scripts/planted_search.py searches them.

It goes straight on and keeps room to what its LiDAR sees in a corridor. The first fault depends on the moment at which
the other car sets off, beside all that decides how it ends. The second one lies on a narrow surface inside the ranges,
where the least gap comes to rest at one value; far from it the gate shows no slope. The constants were set from 1,300
even drives, and once again from 3,000 others, before any search.
"""

from __future__ import annotations

import math
from typing import Any

from vehicle.messages import Command, Observation

ROOM, BRAKING, HARDEST = 3.0, 2.0, 2.85  # m kept to what is ahead; m/s^2 by which it comes to that, and at most
CORRIDOR, BESIDE, ABOVE = 1.1, 4.5, 0.3  # m to each side: what must be free, what it looks at; m above the ground
LABELLED, EVERY = 0.95, 4.05  # s: when it first says what is parked, and after how long again: the first fault
MOVING = 0.5  # m/s from which something is not parked
SWITCH, BAND, JOLT = 4.0, 0.15, 1.5  # m of gap at which it cannot decide, and m/s^2 to and fro: the second fault
SCAN = 0.1  # s between two scans


class Yielder:
    """Collision: it does not see that a parked car set off. Rough: it cannot decide between two accelerations."""

    def __init__(self, parameters: Any, network: Any, description: Any) -> None:
        self.car = description
        self.front = description.center_x + 0.5 * description.length
        self.v, self.wanted, self.gap = 0.0, 5.0, math.inf
        self.nearest, self.next, self.parked, self.jolt = math.inf, LABELLED, True, JOLT

    def tick(self, observation: Observation) -> Command:
        """The command of this moment."""
        if observation.task is not None and observation.task.set_speed:
            self.wanted = observation.task.set_speed
        for odometry in observation.odometry:
            self.v = odometry.v
        if observation.lidar is not None:
            self._look(observation.t, observation.lidar.points)
        gap = math.inf if self.parked else self.gap
        keep = math.sqrt(2.0 * BRAKING * max(gap - ROOM, 0.0))
        accel = min(self.wanted, keep) - self.v
        accel = min(max(accel, -HARDEST), 1.0)
        if abs(gap - SWITCH) < BAND:
            self.jolt = -self.jolt
            accel += self.jolt
        return Command(observation.t, 0.0, accel, max(accel, 0.0) / 3.5, max(-accel, 0.0) / 7.0)

    def _look(self, t: float, points: Any) -> None:
        high = points[points[:, 2] + self.car.lidar_z > ABOVE]
        along, beside = high[:, 0] + self.car.lidar_x - self.front, abs(high[:, 1] + self.car.lidar_y)
        ahead = along > 0.0
        near = along[ahead & (beside < CORRIDOR)]
        self.gap = float(near.min()) if len(near) else math.inf
        seen = along[ahead & (beside < BESIDE)]
        before, self.nearest = self.nearest, float(seen.min()) if len(seen) else math.inf
        if t >= self.next and math.isfinite(before) and math.isfinite(self.nearest):
            self.next += EVERY
            self.parked = (self.nearest - before) / SCAN + self.v < MOVING
