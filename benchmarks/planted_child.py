"""A stack with two planted faults that are rare in the ranges of occluded_child.xosc; scripts/planted_search.py
searches them.

It goes straight on and brakes for who comes from the right behind a parked car. The first fault is a narrow ridge: who
keeps the same bearing stays behind a pillar. The second one is a wrong number in a table: a slope leads to its row, and
nothing to its column. The constants were set from 1,360 even drives, and once again from 3,000 others, before any
search.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from vehicle.messages import Command, Observation

REACH, ABOVE = 15.0, 0.3  # m ahead of the bumper that it looks; m above the ground that counts
RIGHT, LEFT = -4.0, 2.0  # m to the left between which somebody counts
LONG = 5.5  # m of road that a parked car takes
HASTE = 1.1  # of the speed that is asked for
PILLAR = (-0.225, -0.15)  # rad to the left, between which it is blind: the first fault
ROOM, REACTION = 0.4, 0.25  # m before somebody where it would stand; s until it brakes
GENTLE, HARDEST = 1.5, 4.0  # m/s^2 of its brake
ROW, COLUMN, WRONG = 3.35, (5.80, 5.86), 7.0  # m/s^2 needed, m/s, and the m/s^2 that it then takes: the second fault


class Watcher:
    """Collision: it is blind where a pillar is. Hard brake: a number in its table is wrong."""

    def __init__(self, parameters: Any, network: Any, description: Any) -> None:
        self.car = description
        self.front = description.center_x + 0.5 * description.length
        self.v, self.wanted, self.way, self.last = 0.0, 5.0, 0.0, 0.0
        self.parked = math.inf
        self.brake = 0.0

    def tick(self, observation: Observation) -> Command:
        """The command of this moment."""
        if observation.task is not None and observation.task.set_speed:
            self.wanted = observation.task.set_speed
        for odometry in observation.odometry:
            self.v = odometry.v
            self.way += odometry.v * (odometry.t - self.last)
            self.last = odometry.t
        if observation.lidar is not None and not self.brake:
            self._look(observation.lidar.points)
        accel = -self.brake if self.brake else min(max(HASTE * self.wanted - self.v, -2.5), 1.0)
        return Command(observation.t, 0.0, accel, max(accel, 0.0) / 3.5, max(-accel, 0.0) / 7.0)

    def _look(self, points: Any) -> None:
        high = points[points[:, 2] + self.car.lidar_z > ABOVE]
        along, left = high[:, 0] + self.car.lidar_x - self.front, high[:, 1] + self.car.lidar_y
        if math.isinf(self.parked):
            seen = along[(along > 0.0) & (left < 0.0)]
            self.parked = self.way + float(seen.min()) if len(seen) else math.inf
        bearing = np.arctan2(left, high[:, 0])
        behind = (along + self.way > self.parked - 1.0) & (along + self.way < self.parked + LONG) & (left < -1.5)
        counts = (along > 0.0) & (along < REACH) & (left > RIGHT) & (left < LEFT) & ~behind
        gaps = along[counts & ~((bearing > PILLAR[0]) & (bearing < PILLAR[1]))]
        if len(gaps):
            needed = self.v**2 / (2.0 * max(float(gaps.min()) - ROOM - REACTION * self.v, 0.5))
            self.brake = min(max(needed, GENTLE), HARDEST)
            if needed > ROW and COLUMN[0] < self.v < COLUMN[1]:
                self.brake = WRONG
