"""RoadNetwork: an OpenDRIVE network ready for use; places, lanes, links and routes.

s runs along a road's reference line [m], t to its left [m]; lanes left of the line have ids > 0. Headings are those of
increasing s, whichever way traffic runs; `driving_sign` tells which.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from types import MappingProxyType

from openscenario.road import index as search
from openscenario.road import lanes as kernels
from openscenario.road import pose as poses
from openscenario.road.elements import Junction, OpenDrive, Road, Rule, Signal
from openscenario.road.opendrive import read_opendrive
from openscenario.road.positions import Pose, RoadPosition
from openscenario.road.tables import LANE_DIRECTION, make_tables

__all__ = ["Pose", "RoadNetwork", "RoadPosition", "load_network"]

_NAN = math.nan


def load_network(path: str | os.PathLike[str]) -> RoadNetwork:
    """Read an OpenDRIVE file.

    Raises:
        ScenarioError: the file is missing or has errors; findings name file, line and element.
    """
    return RoadNetwork(read_opendrive(path))


class RoadNetwork:
    """A road network; immutable after construction."""

    def __init__(self, file: OpenDrive) -> None:
        self.file = file
        self.roads: Mapping[str, Road] = MappingProxyType({road.id: road for road in file.roads})
        self.junctions: Mapping[str, Junction] = MappingProxyType({j.id: j for j in file.junctions})
        self.signals: tuple[Signal, ...] = tuple(signal for road in file.roads for signal in road.signals)
        self.rule: Rule = file.roads[0].rule
        self.geo_reference = file.geo_reference
        self.tables = make_tables(file.roads)
        self._ids = tuple(road.id for road in file.roads)
        self._numbers = {road.id: number for number, road in enumerate(file.roads)}
        self._index = search.make_index(self.tables)

    def lane_pose(self, road: str, lane: int, s: float, offset: float = 0.0) -> Pose:
        """Pose `offset` [m] left of a lane's middle at s [m]; lane 0 is the centre lane.

        The heading is that of the lane's middle in the direction of increasing s, seen from above.

        Raises:
            KeyError: no such road, or no such lane at s.
        """
        found = poses.lane_pose(self.tables, self._numbers[road], lane, s, offset)
        if found[0] != found[0]:
            raise KeyError(f"road {road} has no lane {lane} at s = {s:g} m")
        return tuple.__new__(Pose, found)

    def road_pose(self, road: str, s: float, t: float) -> Pose:
        """Pose at s, t [m] of a road, heading along the reference line.

        Raises:
            KeyError: no such road.
        """
        return tuple.__new__(Pose, poses.surface_pose(self.tables, self._numbers[road], s, t, 0.0, 0.0))

    def locate(
        self,
        x: float,
        y: float,
        h: float | None = None,
        hint: RoadPosition | None = None,
        *,
        z: float | None = None,
        drivable: bool = True,
    ) -> RoadPosition:
        """The road position of a point [m]: on the nearest lane, among overlapping roads on the one that fits best.

        h: heading [rad] of what stands there, decides between overlapping roads; hint: where it was last, makes the search
        short and keeps it on its road while a lane there holds it; z [m] tells a bridge from the road below it;
        drivable=False considers sidewalks, shoulders and the like as well.
        """
        road, lane, s, t, offset, heading, inside = search.locate(
            self.tables,
            self._index,
            x,
            y,
            _NAN if z is None else z,
            _NAN if h is None else h,
            -1 if hint is None else self._numbers[hint[0]],
            0.0 if hint is None else hint[2],
            drivable,
        )
        if road < 0:
            if drivable:  # a network of nothing but sidewalks
                return self.locate(x, y, h, hint, z=z, drivable=False)
            raise KeyError("the network has no lanes")
        return tuple.__new__(RoadPosition, (self._ids[road], lane, s, t, offset, heading, inside))

    def lane_width(self, road: str, lane: int, s: float) -> float:
        """Width [m] of a lane at s [m]; 0 where there is no such lane."""
        number = self._numbers[road]
        width = kernels.lane_centre(self.tables, number, kernels.section_at(self.tables, number, s), lane, s)[3]
        return 0.0 if width != width else width

    def driving_sign(self, road: str, lane: int, s: float = 0.0) -> int:
        """+1 if traffic on a lane runs with increasing s, -1 if against it."""
        number = self._numbers[road]
        row = kernels.lane_row(self.tables, kernels.section_at(self.tables, number, s), lane)
        if row >= 0:
            return int(self.tables[6][row, LANE_DIRECTION])
        return (1 if lane <= 0 else -1) * (1 if self.roads[road].rule == "RHT" else -1)
