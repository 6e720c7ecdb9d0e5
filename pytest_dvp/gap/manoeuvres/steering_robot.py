"""A driving stack that plays the commands of a planned drive by the clock, as a steering robot does.

dvp run plan/step_steer.xosc --ads plan/step_steer_robot.py:Robot --model car.toml
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from vehicle.messages import Command, Observation, VehicleDescription


class CommandPlayer:
    """Plays `wanted` columns of a file: t [s], steer [rad] and accel [m/s^2] asked for; open loop, so it sees nothing.

    Pedals are given as shares of the accelerations of which the car's description speaks.
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
        """The command of now; after the end the brake holds the car."""
        from vehicle.messages import Command

        k = max(int(np.searchsorted(self._t, observation.t + 1e-9, side="right")) - 1, 0)
        accel, d = float(self._accel[k]), self._description
        throttle, brake = max(accel, 0.0) / d.max_acceleration, max(-accel, 0.0) / d.max_deceleration
        return Command(observation.t, float(self._steer[k]), accel, min(throttle, 1.0), min(brake, 1.0))
