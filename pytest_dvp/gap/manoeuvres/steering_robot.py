"""A driving stack that plays the commands of a planned drive by the clock, as a steering robot does.

dvp run plan/step_steer.xosc --ads plan/step_steer_robot.py:Robot --model car.toml
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vehicle.messages import TICK

if TYPE_CHECKING:
    from vehicle.messages import Command, Observation, VehicleDescription


class CommandPlayer:
    """Plays `wanted` columns of a file: t [s], steer [rad] and accel [m/s^2] asked for; open loop, so it sees nothing.

    A command is the mean of the rows of its tick, so that none of them is lost and speed and heading come out as
    planned. Pedals are given as shares of the accelerations of which the car's description speaks.
    """

    def __init__(self, path: Path, description: VehicleDescription) -> None:
        with path.open(encoding="utf-8", newline="") as stream:
            rows = csv.reader(stream)
            header = [name.split(" ")[0] for name in next(rows)]
            table = np.array([[float(cell) for cell in row] for row in rows])
        self._t = table[:, header.index("t")]
        self._steer = table[:, header.index("wanted_steer")]
        self._accel = table[:, header.index("wanted_accel")]
        self._description = description

    def tick(self, observation: Observation) -> Command:
        """The command of this tick; after the end the brake holds the car."""
        from vehicle.messages import Command

        (steer, accel), d = self._mean(observation.t), self._description
        throttle, brake = max(accel, 0.0) / d.max_acceleration, max(-accel, 0.0) / d.max_deceleration
        return Command(observation.t, steer, accel, min(throttle, 1.0), min(brake, 1.0))

    def _mean(self, t: float) -> tuple[float, float]:
        """Steering and acceleration asked for, on average from `t` [s] on for a tick; each row holds until the next."""
        edges = np.array([t, *self._t[(self._t > t) & (self._t < t + TICK)], t + TICK])
        rows = np.maximum(np.searchsorted(self._t, edges[:-1], side="right") - 1, 0)
        share = np.diff(edges) / TICK
        return float(share @ self._steer[rows]), float(share @ self._accel[rows])
