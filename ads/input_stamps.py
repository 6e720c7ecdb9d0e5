"""Stamps of what arrived: how old the newest message of each sensor is, and how many came out of order."""

from __future__ import annotations

from vehicle.messages import Observation

AGES = {sensor: f"age_{sensor}" for sensor in ("gnss", "odometry", "imu", "lidar", "camera")}
"""What the age of each sensor's newest message is called."""


class InputStamps:
    """Keeps the newest stamp of each sensor. `disordered`: messages so far that were not newer than all before."""

    def __init__(self) -> None:
        self._newest: dict[str, float] = {}  # [s], by AGES
        self.disordered = 0

    def update(self, observation: Observation) -> dict[str, float]:
        """Age [s] of the newest message by `age_SENSOR`, of the sensors that have spoken, and `disordered`."""
        newest = self._newest
        for sensor, name in AGES.items():
            given = getattr(observation, sensor)
            for message in given if isinstance(given, tuple) else (given,):
                if message is None:
                    continue
                if name not in newest or message.t > newest[name]:
                    newest[name] = message.t
                else:
                    self.disordered += 1
        ages = {name: observation.t - t for name, t in newest.items()}
        return {**ages, "disordered": float(self.disordered)}
