"""Footprint: where a moving box stands on a network, with the lane under its middle, in one compiled call a step."""

from __future__ import annotations

import math

import numpy as np

from machine_code import compiled
from openscenario.road.index import Index, locate
from openscenario.road.lanes import lane_centre, section_at
from openscenario.road.network import RoadNetwork
from openscenario.road.profile import Floats
from openscenario.road.tables import Tables


class Footprint:
    """A box that moves over a network, followed from step to step.

    corners: array (n, 2), x forward and y left of its reference point [m].
    """

    def __init__(self, network: RoadNetwork, corners: Floats) -> None:
        self._network, self._corners = network, np.ascontiguousarray(corners, dtype=np.float64)
        self._ids = tuple(network.roads)
        self._limits: dict[tuple[str, int], float] = {}  # m/s, by road and lane; NaN where it changes along the road
        # Road and s [m] of each corner, and of the reference point last; road -1: not yet known.
        self._places = np.array([[-1.0, 0.0]] * (len(corners) + 1))

    def under(self, x: float, y: float, yaw: float) -> tuple[bool, float, float]:
        """Whether all corners are on drivable lanes, and the width [m] and speed limit [m/s] of the lane under the
        reference point, NaN where there is none.

        x, y [m], yaw [rad]: pose of the reference point.
        """
        network = self._network
        cos, sin = math.cos(yaw), math.sin(yaw)
        whole, road, lane, s, width = stand(
            network.tables, network.index, x, y, yaw, cos, sin, self._corners, self._places
        )
        if road < 0:
            return whole, math.nan, math.nan
        name = self._ids[road]
        if (name, lane) not in self._limits:
            self._limits[name, lane] = network.lane_speed(name, lane, s) if _constant(network, name, lane) else math.nan
        limit = self._limits[name, lane]
        if math.isnan(limit):
            limit = network.lane_speed(name, lane, s)
        return whole, width or math.nan, limit if math.isfinite(limit) else math.nan


def _constant(network: RoadNetwork, road: str, lane: int) -> bool:
    """Whether the speed limit of a lane is the same all along its road."""
    sections, types = network.roads[road].sections, network.roads[road].types
    stated = any(each.speeds for each in sections[0].lanes if each.id == lane)
    return len(sections) == 1 and not stated and all(each.s <= 0.0 for each in types)


@compiled
def stand(
    tables: Tables, index: Index, x: float, y: float, yaw: float, cos: float, sin: float, corners: Floats,
    places: Floats,
) -> tuple[bool, int, int, float, float]:  # fmt: skip
    """Whether all corners are on lanes; road, lane, s [m] and width [m] of the lane under the reference point.

    Road -1: it is beside all lanes. `places` (n + 1, 2), road and s [m] of each point, is where the
    search begins, and is written.
    """
    whole = True
    for k in range(corners.shape[0] + 1):
        middle = k == corners.shape[0]
        if not (middle or whole):  # one is enough, and beside the road a place is looked for everywhere
            continue
        u, v = (0.0, 0.0) if middle else (corners[k, 0], corners[k, 1])
        px, py = x + cos * u - sin * v, y + sin * u + cos * v
        road, lane, s, _, _, _, inside = locate(
            tables, index, px, py, math.nan, yaw if middle else math.nan, int(places[k, 0]), places[k, 1], True
        )
        places[k, 0], places[k, 1] = road, s
        if not middle:
            whole = whole and inside
        elif inside:
            width = lane_centre(tables, road, section_at(tables, road, s), lane, s)[3]
            return whole, road, lane, s, 0.0 if math.isnan(width) else width
    return whole, -1, 0, 0.0, 0.0
