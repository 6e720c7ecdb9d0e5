"""The ground under a simulated car: height and slopes of the road it stands on."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Protocol, runtime_checkable

from openscenario.road.tables import ROAD_FLAT

if TYPE_CHECKING:
    from openscenario.road.network import RoadNetwork
    from openscenario.road.positions import RoadPosition


@runtime_checkable
class NeedsTerrain(Protocol):
    """A vehicle that must be told what is under its wheels; a real one feels it."""

    def place_on_road(self, z: float, grade: float = 0.0, bank: float = 0.0) -> None:
        """Say what is under the wheels: height [m], slope along [rad, > 0 uphill], across [rad, > 0 left side up]."""
        ...


class Terrain:
    """Height and slopes along the way of one car. `flat` networks need not be asked at all."""

    def __init__(self, network: RoadNetwork) -> None:
        self.flat = bool(network.tables[3][:, ROAD_FLAT].all())
        self._network = network
        self._last: RoadPosition | None = None

    def under(self, x: float, y: float, yaw: float) -> tuple[float, float, float]:
        """z [m], slope along the car [rad, > 0 uphill] and across [rad, > 0 left side up] at a point of the map."""
        found = self._last = self._network.locate(x, y, yaw, self._last)
        pose = self._network.lane_pose(found.road, found.lane, found.s, found.offset)
        along, left = -math.tan(pose.pitch), math.tan(pose.roll)
        cos, sin = math.cos(yaw - pose.h), math.sin(yaw - pose.h)
        return pose.z, math.atan(along * cos + left * sin), math.atan(left * cos - along * sin)
