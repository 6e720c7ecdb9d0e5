"""RoadNetwork: an OpenDRIVE network ready for use; places, lanes, links and routes.

s runs along a road's reference line [m], t to its left [m]; lanes left of the line have ids > 0. Headings are those of
increasing s, whichever way traffic runs; `driving_sign` tells which.
"""

from __future__ import annotations

import math
import os
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from functools import cached_property
from itertools import pairwise
from types import MappingProxyType

from openscenario.road import index as search
from openscenario.road import lanes as kernels
from openscenario.road import onwards, path, route
from openscenario.road import pose as poses
from openscenario.road.boundaries import Boundary, make_boundaries
from openscenario.road.branches import Branch, branch_rows, leaves, make_branches, stations
from openscenario.road.crosswalks import Crosswalk, PlaceOf, find_crosswalks
from openscenario.road.distances import RoadDistances
from openscenario.road.elements import Junction, Lane, LaneSection, OpenDrive, Road, Rule, Signal
from openscenario.road.graph import LaneGraph, make_graph
from openscenario.road.links import LaneEnd, answered, make_links
from openscenario.road.opendrive import read_opendrive
from openscenario.road.positions import Pose, RoadPosition
from openscenario.road.profile import Floats
from openscenario.road.repairs import LENIENT, Roads
from openscenario.road.route import RouteError, RouteLane
from openscenario.road.tables import driving_signs, make_tables

__all__ = ["Boundary", "Crosswalk", "Pose", "RoadNetwork", "RoadPosition", "RouteError", "RouteLane", "load_network"]

_NAN = math.nan
# Lanes may take at most DETOUR times the way along the roads, plus SHORT_WAY [m].
DETOUR = 2.0  # chosen, about one junction
SHORT_WAY = 50.0  # m; chosen, about one junction
MOST_JOINTS = 10_000  # of roads on one way: a ring of roads without length has no end


def load_network(path: str | os.PathLike[str], roads: Roads = LENIENT) -> RoadNetwork:
    """Read an OpenDRIVE file; roads: as for `openscenario.road.opendrive.read_opendrive`.

    Raises:
        ScenarioError: the file is missing or has errors; findings name file, line and element.
    """
    return RoadNetwork(read_opendrive(path, roads))


class RoadNetwork:
    """A road network; immutable after construction."""

    def __init__(self, file: OpenDrive) -> None:
        self.file = file
        self.roads: Mapping[str, Road] = MappingProxyType({road.id: road for road in file.roads})
        self.junctions: Mapping[str, Junction] = MappingProxyType({j.id: j for j in file.junctions})
        self.signals: tuple[Signal, ...] = tuple(signal for road in file.roads for signal in road.signals)
        self.rule: Rule = file.roads[0].rule
        self.geo_reference = file.geo_reference
        self._branches = make_branches(file.roads, file.junctions)
        self.tables = make_tables(file.roads, stations(self._branches))
        self._ids = tuple(road.id for road in file.roads)
        self._numbers = {road.id: number for number, road in enumerate(file.roads)}
        self.index = search.make_index(self.tables)
        self._signs = dict(zip(self._ids, driving_signs(self.tables), strict=True))

    def lane_pose(self, road: str, lane: int, s: float, offset: float = 0.0) -> Pose:
        """Pose `offset` [m] left of a lane's middle at s [m]; lane 0 is the centre lane.

        The heading is that of the lane's middle in the direction of increasing s, seen from above.

        Raises:
            KeyError: no such road, or no such lane at s.
        """
        found = poses.lane_pose(self.tables, self._numbers[road], lane, float(s), float(offset))
        if found[0] != found[0]:
            raise KeyError(f"road {road} has no lane {lane} at s = {s:g} m")
        return tuple.__new__(Pose, found)

    def moved(self, x: float, y: float, z: float, h: float) -> tuple[float, float, float, float]:
        """A place in the numbers of the file [m, rad], after the header's offset, which moves the roads as well.

        Source: ASAM OpenDRIVE 1.8, 8.5 (header offset): turned by hdg about the file's origin, then shifted by x, y, z.
        """
        dx, dy, dz, turn = self.file.geo_offset
        if not any(self.file.geo_offset):
            return x, y, z, h
        c, sn = math.cos(turn), math.sin(turn)
        return c * x - sn * y + dx, sn * x + c * y + dy, z + dz, h + turn

    def lane_t(self, road: str, lane: int, s: float) -> float:
        """t [m] of a lane's middle at s [m]; NaN where there is no such lane."""
        number, s = self._numbers[road], float(s)
        return float(kernels.lane_centre(self.tables, number, kernels.section_at(self.tables, number, s), lane, s)[0])

    def curvature(self, road: str, s: float) -> float:
        """Curvature [1/m] of a road's reference line at s [m], > 0 to the left.

        Raises:
            KeyError: no such road.
        """
        return float(poses.reference(self.tables, self._numbers[road], float(s))[3])

    def road_pose(self, road: str, s: float, t: float) -> Pose:
        """Pose at s, t [m] of a road, heading along the reference line.

        Raises:
            KeyError: no such road.
        """
        return tuple.__new__(Pose, poses.surface_pose(self.tables, self._numbers[road], float(s), float(t), 0.0, 0.0))

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

        h: heading [rad] of what stands there, decides between overlapping roads; hint: where it was last, makes the
        search short and keeps it on its road while a lane there holds it; z [m] tells a bridge from the road below it;
        drivable=False considers sidewalks, shoulders and the like as well.
        Raises KeyError if the network has no lanes at all.
        """
        road, lane, s, t, offset, heading, inside = search.locate(
            self.tables,
            self.index,
            float(x),
            float(y),
            _NAN if z is None else float(z),
            _NAN if h is None else float(h),
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
        number, s = self._numbers[road], float(s)
        width = kernels.lane_centre(self.tables, number, kernels.section_at(self.tables, number, s), lane, s)[3]
        return 0.0 if width != width else width

    def driving_sign(self, road: str, lane: int, s: float = 0.0) -> int:
        """+1 if traffic on a lane runs with increasing s, -1 if against it."""
        starts, signs = self._signs[road]
        sign = signs[bisect_right(starts, s, 1) - 1].get(lane)
        if sign is not None:
            return sign
        return (1 if lane <= 0 else -1) * (1 if self.roads[road].rule == "RHT" else -1)

    def section(self, road: str, s: float) -> LaneSection:
        """The lane section of a road that holds at s [m]."""
        sections = self.roads[road].sections
        return next((section for section in reversed(sections) if section.s <= s), sections[0])

    def lane(self, road: str, lane: int, s: float) -> Lane | None:
        """The lane with that id at s [m], or None."""
        return next((item for item in self.section(road, s).lanes if item.id == lane), None)

    def lane_type(self, road: str, lane: int, s: float) -> str:
        """Type of a lane at s [m] (driving, sidewalk ...), "none" where there is no such lane."""
        found = self.lane(road, lane, s)
        return "none" if found is None else found.type

    def lane_speed(self, road: str, lane: int, s: float) -> float:
        """Speed limit [m/s] of a lane at s [m]: of the lane, else of the road's type; inf for none."""
        found = self.lane(road, lane, s)
        if found is not None:
            along = s - self.section(road, s).s
            limits = [limit.max for limit in found.speeds if limit.s <= along]
            if limits:
                return limits[-1]
        types = [item for item in self.roads[road].types if item.s <= s]
        speed = types[-1].speed if types else None
        return math.inf if speed is None else speed

    @cached_property
    def states_friction(self) -> bool:
        """Whether a lane of the network has a material with a friction below that of a dry road."""
        lanes = (lane for road in self.roads.values() for section in road.sections for lane in section.lanes)
        return any(each.friction < 1.0 for lane in lanes for each in lane.frictions)

    def lane_friction(self, road: str, lane: int, s: float) -> float:
        """Friction coefficient [-] of a lane's material at s [m]; 1, that of a dry road, where none is stated."""
        found = self.lane(road, lane, s)
        if found is None or not found.frictions:
            return 1.0
        along = s - self.section(road, s).s
        return next((each.friction for each in reversed(found.frictions) if each.s <= along), 1.0)

    def lane_successors(self, road: str, lane: int) -> tuple[tuple[str, int], ...]:
        """(road, lane) that traffic goes on to at the end of a lane, in driving direction, over links and junctions."""
        return tuple((self._ids[end.road], end.lane) for end in self._ends_after(self._numbers[road], lane))

    def _ends_after(self, road: int, lane: int, *, forward: bool | None = None) -> list[LaneEnd]:
        """Lane ends that a lane runs on to; forward: with increasing s (None: with the traffic)."""
        traffic = forward is None
        if forward is None:
            forward = self._exit_forward(road, lane)
        found = []
        for end in self._links.get(LaneEnd(road, lane, forward), ()):
            enters_with_s = not end.at_end
            s = 0.0 if enters_with_s else self.file.roads[end.road].length
            with_traffic = (self.driving_sign(self._ids[end.road], end.lane, s) > 0) == enters_with_s
            if with_traffic or not traffic:
                found.append(end)
        return found

    def _exit_forward(self, road: int, lane: int) -> bool:
        """Whether traffic leaves the lane at the road's end (else at its start)."""
        last = self.file.roads[road].length
        ids = {item.id for item in self.file.roads[road].sections[-1].lanes}
        return self.driving_sign(self._ids[road], lane, last if lane in ids else 0.0) > 0

    @cached_property
    def _links(self) -> dict[LaneEnd, tuple[LaneEnd, ...]]:
        return make_links(self.file.roads, self.file.junctions)

    @cached_property
    def _graph(self) -> LaneGraph:
        return make_graph(self.tables, self._links, branch_rows(self.tables, self._branches))

    @cached_property
    def _exits(self) -> tuple[Branch, ...]:
        """Places between the ends of roads where routes may leave them."""
        return tuple(branch for branch in self._branches if leaves(self.tables, branch))

    @cached_property
    def _entries(self) -> Mapping[LaneEnd, Branch]:
        """Lane ends that lead onto a road between its ends."""
        return {branch.end: branch for branch in self._branches if not leaves(self.tables, branch)}

    @property
    def branching(self) -> bool:
        """Whether ways leave a road, or lead onto one, between its ends."""
        return bool(self._branches)

    def lane_graph(self) -> LaneGraph:
        """Drivable lanes as nodes, ways between them as edges with costs [m]."""
        return self._graph

    def route(self, start: tuple[str, int, float], goal: tuple[str, int, float]) -> tuple[RouteLane, ...]:
        """The cheapest way from (road, lane, s) to (road, lane, s) in driving direction; lane changes cost.

        Raises:
            RouteError: a place is on no drivable lane, or no way leads to the goal.
        """
        places = []
        for road, lane, s in (start, goal):
            if road not in self._numbers:
                raise RouteError(f"there is no road {road}")
            places.append(route.find_place(self.tables, self._graph, self._numbers[road], lane, float(s), road))
        try:
            nodes = route.plan(self.tables, self._graph, places[0], places[1])
        except RouteError:
            places_text = " to ".join(f"road {road} lane {lane} s = {s:g} m" for road, lane, s in (start, goal))
            raise RouteError(f"no way leads in driving direction from {places_text}") from None
        pieces = route.stretches(self.tables, self._graph, nodes, places[0][0].s, places[1][0].s)
        return tuple(RouteLane(self._ids[road], lane, s_from, s_to) for road, lane, s_from, s_to in pieces)

    def centreline(self, route_lanes: Sequence[RouteLane], step: float = 0.5) -> Floats:
        """The line of lane middles along a route, shape (n, 4): x, y [m], heading [rad], curvature [1/m].

        Heading (continuous, not wrapped) and curvature are those of the line itself, in driving direction; samples lie
        `step` [m] apart, the last one at the route's end. A lane change is a smooth line over at most 60 m.
        """
        pieces = [(self._numbers[item[0]], item[1], float(item[2]), float(item[3])) for item in route_lanes]
        return route.draw(self.tables, pieces, float(step))

    def advance(
        self,
        position: RoadPosition,
        ds: float,
        turn: float = 0.0,
        along: Sequence[RouteLane] = (),
        *,
        on_reference: bool = False,
    ) -> RoadPosition:
        """The position `ds` [m] further along the lane in driving direction (ds < 0: against it), at the same offset.

        ds is the way travelled at that offset, not the change of s; with `on_reference` it is that along the reference
        lines. Where lanes part the way is the one that stays on
        the route `along`, else the one whose change of heading is nearest to `turn` [rad, > 0 left], else the first in
        the file. A lane that ends where its road goes on leads to the middle of the lane of its side that lies nearest
        there. At any other dead end (`dead_end`) the position stays at the lane's end.

        Raises:
            ValueError: ds is not finite.
        """
        if not math.isfinite(ds):
            raise ValueError(f"ds = {ds} m is no way to go")
        number, lane, s, offset = self._numbers[position.road], position.lane, position.s, position.offset
        left = float(ds) * self.driving_sign(position.road, lane, s)
        for _ in range(MOST_JOINTS):
            if on_reference:
                offset = -self.lane_t(self._ids[number], lane, s)
            way = left
            before = (number, lane, s)
            lane, s, t, heading, left = path.advance(self.tables, number, lane, s, offset, left)
            branch = self.exit_between(before, (number, lane, s), way > 0.0, along) if self._branches else None
            if branch is not None:
                left = way - self._way_to(branch.s, before, offset, way)
                number, lane = branch.end.road, branch.end.lane
                s = self.file.roads[number].length if branch.end.at_end else 0.0
                if branch.end.at_end == (way > 0.0):
                    left, offset = -left, -offset
                continue
            if left == 0.0:
                break
            entry = self._entries.get(LaneEnd(number, lane, left > 0.0)) if self._branches else None
            if entry is not None:
                with_traffic = self.driving_sign(self._ids[number], lane, s) * left > 0.0
                onwards = self.driving_sign(self._ids[entry.road], entry.lane, entry.s) * (1 if with_traffic else -1)
                if onwards * left < 0.0:
                    left, offset = -left, -offset
                number, lane, s = entry.road, entry.lane, entry.s
                continue
            ends = self._ends_after(number, lane, forward=left > 0.0)
            if not ends:
                beyond = self._beside_beyond(number, lane, offset, forward=left > 0.0)
                if beyond is None:
                    break
                ends, offset = [beyond], 0.0
            end = (
                ends[0]
                if len(ends) == 1
                else self._choose(ends, heading + (0.0 if left > 0.0 else math.pi), turn, along)
            )
            if end.at_end == (left > 0.0):  # roads that meet end to end run against each other
                left, offset = -left, -offset
            number, lane = end.road, end.lane
            s = self.file.roads[number].length if end.at_end else 0.0
        return tuple.__new__(RoadPosition, (self._ids[number], lane, s, t, offset, heading, position.on_road))

    def _beside_beyond(self, number: int, lane: int, offset: float, *, forward: bool) -> LaneEnd | None:
        """The lane end of the road linked at a road's end that lies nearest to a lane no link leads on."""
        road = self.file.roads[number]
        link = road.successor if forward else road.predecessor
        if link is None or link.kind != "road" or link.s is not None or link.id not in self._numbers or not lane:
            return None
        other = self._numbers[link.id]
        if not link.contact or not answered(road, self.file.roads[other], link):
            return None
        at_end = link.contact == "end"
        against = -1 if at_end == forward else 1  # roads that meet end to end run against each other
        t = self.lane_t(road.id, lane, road.length if forward else 0.0) + offset
        s = self.file.roads[other].length if at_end else 0.0
        side = against if lane > 0 else -against
        found, _, width, _ = kernels.nearest_lane(self.tables, other, s, against * t, True, side)
        return LaneEnd(other, found, at_end) if found and width > path.NO_WIDTH else None

    def exit_between(
        self, before: tuple[int, int, float], after: tuple[int, int, float], forward: bool, along: Sequence[RouteLane]
    ) -> Branch | None:
        """The first way off a road between its ends that a route takes between two places (road number, lane, s [m]).

        forward: with increasing s.
        """
        number, lane, s = before
        taken = {(here.road, there.road) for here, there in pairwise(along) if here.road != there.road}
        found = [
            branch
            for branch in self._exits
            if branch.road == number
            and branch.lane in (lane, after[1])
            and (s < branch.s <= after[2] if forward else after[2] <= branch.s < s)
            and (self._ids[number], self._ids[branch.end.road]) in taken
        ]
        return min(found, key=lambda branch: abs(branch.s - s), default=None)

    def _way_to(self, s: float, before: tuple[int, int, float], offset: float, way: float) -> float:
        """Way [m], of `way` [m] along a lane, after which it has come to s [m]."""
        number, lane, start = before
        low, high = 0.0, way
        for _ in range(50):
            middle = 0.5 * (low + high)
            there = path.advance(self.tables, number, lane, start, offset, middle)[1]
            if abs(there - start) < abs(s - start):
                low = middle
            else:
                high = middle
        return high

    def _choose(self, ends: list[LaneEnd], heading: float, turn: float, along: Sequence[RouteLane]) -> LaneEnd:
        """The way to take from a place left with `heading` [rad]."""
        wanted = [(self._numbers[item.road], item.lane) for item in along]
        for end in ends:
            if (end.road, end.lane) in wanted:
                return end
        roads_wanted = [road for road, _ in wanted]
        for end in ends:
            if end.road in roads_wanted:
                return end
        for end in ends:  # a connection that leads back to the route
            beyond = self._links.get(LaneEnd(end.road, end.lane, not end.at_end), ())
            if any(after.road in roads_wanted for after in beyond):
                return end

        def miss(end: LaneEnd) -> float:
            length = self.file.roads[end.road].length
            leaving = poses.reference(self.tables, end.road, 0.0 if end.at_end else length)[2]
            leaving += math.pi if end.at_end else 0.0
            return abs(math.remainder(leaving - heading - turn, 2.0 * math.pi))

        return min(ends, key=lambda end: round(miss(end), 6))

    def dead_end(self, position: RoadPosition) -> bool:
        """Whether the position is at the end of a lane (in driving direction) that leads nowhere."""
        number = self._numbers[position.road]
        sign = self.driving_sign(position.road, position.lane, position.s)
        at_end = position.s >= self.file.roads[number].length - 1e-6 if sign > 0 else position.s <= 1e-6
        if not at_end or (self._branches and LaneEnd(number, position.lane, sign > 0) in self._entries):
            return False
        return not self._ends_after(number, position.lane)

    @cached_property
    def _distances(self) -> RoadDistances:
        return RoadDistances(self.tables, self._links)

    def distance(self, start: RoadPosition, goal: RoadPosition) -> float:
        """Way [m] along reference lines between two positions, the shorter way round; NaN if no road links them.

        > 0: the goal lies ahead in driving direction of the start's lane, < 0: behind.
        """
        sign = self.driving_sign(start.road, start.lane, start.s)
        a, b = self._numbers[start.road], self._numbers[goal.road]
        return sign * self._distances.between(a, start.s, b, goal.s)[0]

    def runs_against(self, start: RoadPosition, goal: RoadPosition) -> bool:
        """Whether s runs the other way at the goal: come along the roads, by heading where no road leads there."""
        if start.road == goal.road:
            return False
        a, b = self._numbers[start.road], self._numbers[goal.road]
        way, against = self._distances.between(a, start.s, b, goal.s)
        return against if math.isfinite(way) else math.cos(goal.h_road - start.h_road) < 0.0

    def lane_onwards(self, start: RoadPosition, goal: RoadPosition) -> int | None:
        """The lane at the goal that the one at the start runs on as, whichever way the traffic runs.

        None if no lane links lead there on about as short a way as the roads do. A lane that ends within a road goes on
        as the nearest one of its side.
        """
        a, b = self._numbers[start.road], self._numbers[goal.road]
        most = 0.0 if a == b else DETOUR * abs(self._distances.between(a, start.s, b, goal.s)[0]) + SHORT_WAY
        if most != most:
            return None
        return onwards.lane_onwards(self.tables, self._met, (a, start.lane, start.s), (b, goal.s), most)

    def _met(self, road: int, lane: int, at_end: bool) -> Sequence[LaneEnd]:
        """The lane ends that a lane meets at an end of its road, by links or as it lies."""
        met = self._links.get(LaneEnd(road, lane, at_end), ())
        beside = None if met else self._beside_beyond(road, lane, 0.0, forward=at_end)
        return met if beside is None else (beside,)

    @cached_property
    def crosswalks(self) -> tuple[Crosswalk, ...]:
        """Crosswalk objects of all roads."""
        return find_crosswalks(self.file.roads, self._place_on)

    def _place_on(self, road: int) -> PlaceOf:
        def place(s: float, t: float) -> tuple[float, float, float]:
            x, y, _, heading, _, _ = poses.surface_pose(self.tables, road, s, t, 0.0, 0.0)
            return x, y, heading

        return place

    def boundaries(self, step: float = 1.0) -> list[Boundary]:
        """Borders of drivable lanes for pictures: (kind "edge" | "lane" | "centre", points (n, 2) [m])."""
        return make_boundaries(self.tables, step)
