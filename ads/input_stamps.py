"""Stamps of what arrived: how old the newest message of each sensor is, and how many came out of order."""

from __future__ import annotations

from vehicle.messages import Observation

SENSORS = ("gnss", "odometry", "imu", "lidar", "camera")


class InputStamps:
    """Keeps the newest stamp of each sensor. `disordered`: messages so far that were not newer than all before."""

    def __init__(self) -> None:
        self._newest: dict[str, float] = {}
        self.disordered = 0

    def update(self, observation: Observation) -> dict[str, float]:
        """Age [s] of the newest message by `age_SENSOR`, of the sensors that have spoken, and `disordered`."""
        for sensor in SENSORS:
            given = getattr(observation, sensor)
            for message in given if isinstance(given, tuple) else (given,):
                if message is None:
                    continue
                newest = self._newest.get(sensor)
                if newest is None or message.t > newest:
                    self._newest[sensor] = message.t
                else:
                    self.disordered += 1
        ages = {f"age_{sensor}": observation.t - t for sensor, t in self._newest.items()}
        return {**ages, "disordered": float(self.disordered)}
