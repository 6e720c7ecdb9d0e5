"""Routes: the way along lanes through waypoints, and places along it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise, product
from typing import TYPE_CHECKING

from openscenario import model
from openscenario.road.network import RoadNetwork
from openscenario.road.route import RouteError, RouteLane
from openscenario.storyboard.places import Place, RoadPoint

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board
    from openscenario.storyboard.entity import Entity

ROUNDING = 1e-6  # m that a place may be beyond the end of a route: of numbers in files
MOST_LANES = 10_000  # of roads without length there is no end


def round_trip(places: Sequence[Place], closed: bool) -> Sequence[Place]:
    """The places of a route, and its first one again if it is closed: `the last waypoint is followed by the first`."""
    return (*places, places[0]) if closed and len(places) > 1 else places


def way(board: Board, places: Sequence[Place]) -> tuple[RouteLane, ...]:
    """Stretches of lanes through the places, in driving order; cut at the first place that no way leads to."""
    network = board.network
    if network is None:
        return ()
    stretches: list[RouteLane] = []
    points = [_point(board, place) for place in places]
    for start, goal in pairwise(points):
        if stretches and stretches[-1].road == start.road:
            # go on in the lane that the last stretch ended in
            start = RoadPoint(start.road, stretches[-1].lane, start.s, 0.0)
        piece = _piece(network, start, goal)
        if not piece:
            break
        stretches.extend(piece)
    return tuple(stretches)


def _piece(network: RoadNetwork, start: RoadPoint, goal: RoadPoint) -> Sequence[RouteLane]:
    """The way from lane to lane with the traffic; if there is none, that between the roads, in lanes that have one."""
    for first, last in product((start, _across(network, start)), (goal, _across(network, goal))):
        if first is not None and last is not None:
            try:
                return network.route((first.road, first.lane, first.s), (last.road, last.lane, last.s))
            except RouteError:
                continue
    return ()


def _across(network: RoadNetwork, point: RoadPoint) -> RoadPoint | None:
    """The nearest lane beside one whose traffic goes the other way."""
    road, lane, s, _ = point
    sign = network.driving_sign(road, lane, s)
    lanes = [each.id for each in network.section(road, s).lanes if each.drivable]
    lanes = [each for each in lanes if network.driving_sign(road, each, s) != sign]
    return RoadPoint(road, min(lanes, key=lambda each: abs(each - lane)), s, 0.0) if lanes else None


def wander(board: Board, entity: Entity, length: float) -> tuple[RouteLane, ...]:
    """At least `length` [m] of lanes ahead of a tracked entity, with chance deciding where they part."""
    network = board.network
    assert network is not None
    here = (entity.road, entity.lane)
    lanes: list[RouteLane] = []
    driven = 0.0
    while driven < length:
        road, lane = here
        end = network.roads[road].length
        along = network.driving_sign(road, lane, entity.s if not lanes else 0.0) > 0
        lanes.append(RouteLane(road, lane, 0.0 if along else end, end if along else 0.0))
        driven += end
        after = network.lane_successors(road, lane)
        if not after or len(lanes) >= MOST_LANES:
            break
        here = board.random.choice(after)
    return tuple(lanes)


def _point(board: Board, place: Place) -> RoadPoint:
    """The drivable lane of a place: the one it names, or the nearest."""
    network = board.network
    assert network is not None
    if place.road is not None:
        return place.road
    found = network.locate(place.x, place.y, place.h if place.has_heading else None, z=place.z)
    return RoadPoint(found.road, found.lane, found.s, found.offset)


def along_route(
    board: Board,
    places: Sequence[Place],
    inside: model.PositionInLaneCoordinates | model.PositionInRoadCoordinates,
    *,
    closed: bool = False,
) -> RoadPoint:
    """The place `path_s` [m] along the route (on reference lines), in the lane or at the t that `inside` names.

    A closed route goes round; what lies beyond an end of another one is that end, with a warning.
    """
    left = inside.path_s
    stretches = way(board, round_trip(places, closed))
    whole = sum(abs(stretch.s_to - stretch.s_from) for stretch in stretches)
    inside_route = 0.0 <= left <= whole + ROUNDING
    if closed and whole > 0.0 and not inside_route:
        left %= whole
    elif not inside_route:
        text = f"pathS = {left:g} m is beyond the route, which has {whole:g} m: the nearer end of it is taken"
        if not stretches:
            text = f"no way leads along the waypoints of the route: pathS = {left:g} m is taken as its first waypoint"
        board.warn(inside, "beyond-route", text)
        left = max(left, 0.0)
    first = _point(board, places[0])
    road, s, lane = first.road, first.s, first.lane
    for stretch in stretches:
        length = abs(stretch.s_to - stretch.s_from)
        road, lane = stretch.road, stretch.lane
        sign = 1.0 if stretch.s_to >= stretch.s_from else -1.0
        s = stretch.s_from + sign * min(left, length)
        if left <= length:
            break
        left -= length
    if isinstance(inside, model.PositionInLaneCoordinates):
        return RoadPoint(road, inside.lane_id, s, inside.lane_offset)
    network = board.network
    assert network is not None
    return RoadPoint(road, lane, s, inside.t - network.lane_t(road, lane, s))
