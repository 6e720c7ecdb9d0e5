"""Positions of the standard, made into places.

`resolver` checks a position once (unknown road, lane or entity raise `Unsupported`, which becomes a finding) and
returns a function that gives the place when it is wanted: what is relative to an entity moves with it.

Headings. A relative orientation (and a missing one) is relative to the lane's driving direction for lane and route
positions, to the reference line for road positions, to the other entity for relative positions, and to the world
for world positions. A relative lane position without orientation heads with or against the traffic as the other
entity does.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from openscenario import model
from openscenario.road.positions import RoadPosition
from openscenario.storyboard.places import Place, RoadPoint
from openscenario.storyboard.registry import Unsupported
from openscenario.storyboard.trajectories import Course, course

if TYPE_CHECKING:
    from openscenario.storyboard.engine import Storyboard
    from openscenario.storyboard.entity import Entity

Where = Callable[[], Place]


def resolver(position: model.Position, board: Storyboard) -> Where:
    """A function that gives the place of `position` at the time it is called.

    Raises:
        Unsupported: the kind of position, or a road, lane or entity that does not exist.
    """
    match position:
        case model.WorldPosition():
            return _world(position, board)
        case model.RelativeWorldPosition():
            return _relative_world(position, board)
        case model.RelativeObjectPosition():
            return _relative_object(position, board)
        case model.LanePosition():
            return _lane(position, board)
        case model.RoadPosition():
            return _road(position, board)
        case model.RelativeLanePosition():
            return _relative_lane(position, board)
        case model.RelativeRoadPosition():
            return _relative_road(position, board)
        case model.TrajectoryPosition():
            return _trajectory(position, board)
        case model.RoutePosition():
            return _route(position, board)
    raise Unsupported("this position is not supported", element=position)


def place(position: model.Position, board: Storyboard) -> Place:
    """The place of `position` now."""
    return resolver(position, board)()


def _constant(value: Place) -> Where:
    return lambda: value


def _orientation(orientation: model.Orientation | None, base: float) -> float:
    """Heading [rad] that an orientation means where the reference heading is `base`."""
    if orientation is None:
        return base
    return orientation.h if orientation.type == "absolute" else base + orientation.h


def _entity(name: str, board: Storyboard, element: object) -> Entity:
    if name not in board.entities:
        raise Unsupported("no entity of this name", name, ", ".join(board.entities), element)
    return board.entities[name]


def _world(position: model.WorldPosition, board: Storyboard) -> Where:
    heading = position.h
    z, pitch, roll = position.z, position.p, position.r
    network = board.network
    if network is not None and (z is None or pitch is None or roll is None):
        found = network.locate(position.x, position.y, heading)
        pose = network.lane_pose(found.road, found.lane, found.s, found.offset)
        sense = 1.0 if math.cos((heading or 0.0) - pose.h) >= 0.0 else -1.0
        z = pose.z if z is None else z
        pitch = sense * pose.pitch if pitch is None else pitch
        roll = sense * pose.roll if roll is None else roll
    value = Place(position.x, position.y, z or 0.0, heading or 0.0, pitch or 0.0, roll or 0.0, None, bool(heading))
    return _constant(value)


def _relative_world(position: model.RelativeWorldPosition, board: Storyboard) -> Where:
    other = _entity(position.entity_ref, board, position)
    orientation = position.orientation

    def where() -> Place:
        return Place(
            other.x + position.dx,
            other.y + position.dy,
            other.z + position.dz,
            _orientation(orientation, other.h),
            has_heading=orientation is not None,
        )

    return where


def _relative_object(position: model.RelativeObjectPosition, board: Storyboard) -> Where:
    other = _entity(position.entity_ref, board, position)
    orientation = position.orientation

    def where() -> Place:
        dx, dy, dz = turned(other.h, other.pitch, other.roll, position.dx, position.dy, position.dz)
        pitch, roll = other.pitch, other.roll
        if orientation is not None:
            absolute = orientation.type == "absolute"
            pitch = orientation.p if absolute else pitch + orientation.p
            roll = orientation.r if absolute else roll + orientation.r
        return Place(
            other.x + dx,
            other.y + dy,
            other.z + dz,
            _orientation(orientation, other.h),
            pitch,
            roll,
            has_heading=orientation is not None,
        )

    return where


def turned(h: float, pitch: float, roll: float, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A vector [m] in the frame of a body, seen from the world: turned by roll, then pitch, then heading [rad]."""
    y, z = y * math.cos(roll) - z * math.sin(roll), y * math.sin(roll) + z * math.cos(roll)
    x, z = x * math.cos(pitch) + z * math.sin(pitch), z * math.cos(pitch) - x * math.sin(pitch)
    return x * math.cos(h) - y * math.sin(h), x * math.sin(h) + y * math.cos(h), z


def _on_lane(
    board: Storyboard,
    point: RoadPoint,
    orientation: model.Orientation | None,
    *,
    base: float | None = None,
) -> Place:
    """Place of road coordinates; heading relative to the driving direction unless `base` says otherwise."""
    network = board.network
    assert network is not None
    pose = network.lane_pose(point.road, point.lane, point.s, point.offset)
    along = network.driving_sign(point.road, point.lane, point.s) > 0
    if base is None:
        base = pose.h if along else pose.h + math.pi
    heading = _orientation(orientation, base)
    sense = 1.0 if math.cos(heading - pose.h) >= 0.0 else -1.0
    return Place(
        pose.x,
        pose.y,
        pose.z,
        heading,
        sense * pose.pitch + (orientation.p if orientation else 0.0),
        sense * pose.roll + (orientation.r if orientation else 0.0),
        point,
        orientation is not None,
    )


def _road_of(board: Storyboard, road: str, element: object) -> None:
    if board.network is None:
        raise Unsupported("the scenario has no road network", element=element)
    if road not in board.network.roads:
        raise Unsupported("no road of this id in the road network", road, _some(tuple(board.network.roads)), element)


def _some(names: tuple[str, ...]) -> str:
    return ", ".join(names[:12]) + (", ..." if len(names) > 12 else "")


def _lane(position: model.LanePosition, board: Storyboard) -> Where:
    _road_of(board, position.road_id, position)
    point = RoadPoint(position.road_id, position.lane_id, position.s, position.offset)
    try:
        return _constant(_on_lane(board, point, position.orientation))
    except KeyError:
        raise Unsupported(
            f"no lane {position.lane_id} on road {position.road_id} at s = {position.s:g} m", element=position
        ) from None


def _road(position: model.RoadPosition, board: Storyboard) -> Where:
    _road_of(board, position.road_id, position)
    network = board.network
    assert network is not None
    pose = network.road_pose(position.road_id, position.s, position.t)
    heading = _orientation(position.orientation, pose.h)
    value = Place(pose.x, pose.y, pose.z, heading, pose.pitch, pose.roll, None, position.orientation is not None)
    return _constant(value)


def shifted_lane(lane: int, by: int) -> int:
    """The lane id `by` lanes further in the direction of increasing ids; there is no lane 0 to drive on."""
    new = lane + by
    if lane < 0 <= new:
        return new + 1
    if lane > 0 >= new:
        return new - 1
    return new


def _relative_lane(position: model.RelativeLanePosition, board: Storyboard) -> Where:
    other = _entity(position.entity_ref, board, position)
    if board.network is None:
        raise Unsupported("the scenario has no road network", element=position)
    distance = position.ds if position.ds is not None else position.ds_lane or 0.0

    def where() -> Place:
        ground = board.ground
        ground.track(other)
        point = ground.ahead(other, distance, along_lane=position.ds is None)
        lane = shifted_lane(point.lane, position.d_lane)
        network = board.network
        assert network is not None
        here = network.lane_pose(point.road, lane, point.s, 0.0).h
        if position.orientation is not None:
            base = here if other.sense > 0.0 else here + math.pi
        else:
            # with or against the traffic, as the other one
            wrong = other.sense * network.driving_sign(other.road, other.lane, other.s) < 0.0
            along = (network.driving_sign(point.road, lane, point.s) > 0) != wrong
            base = here if along else here + math.pi
        return _on_lane(board, RoadPoint(point.road, lane, point.s, position.offset), position.orientation, base=base)

    return where


def _relative_road(position: model.RelativeRoadPosition, board: Storyboard) -> Where:
    other = _entity(position.entity_ref, board, position)
    network = board.network
    if network is None:
        raise Unsupported("the scenario has no road network", element=position)

    def where() -> Place:
        ground = board.ground
        ground.track(other)
        point = ground.ahead(other, position.ds, along_lane=False)
        t = network.lane_t(point.road, point.lane, point.s) + point.offset
        pose = network.road_pose(point.road, point.s, t + position.dt)
        heading = _orientation(position.orientation, pose.h if other.sense > 0.0 else pose.h + math.pi)
        return Place(pose.x, pose.y, pose.z, heading, pose.pitch, pose.roll, None, position.orientation is not None)

    return where


def _trajectory(position: model.TrajectoryPosition, board: Storyboard) -> Where:
    def where() -> Place:
        along: Course = course(position.trajectory, lambda inner: place(inner, board))
        x, y, z, h = along.at(position.s)
        if along.length > 0.0 and isinstance(position.trajectory.shape, model.Polyline):
            h = along.tangent(position.s)
        x -= position.t * math.sin(h)
        y += position.t * math.cos(h)
        return Place(x, y, z, _orientation(position.orientation, h), has_heading=True)

    return where


def _route(position: model.RoutePosition, board: Storyboard) -> Where:
    network = board.network
    if network is None:
        raise Unsupported("the scenario has no road network", element=position)
    waypoints = [resolver(waypoint.position, board) for waypoint in position.route.waypoints]

    def where() -> Place:
        from openscenario.storyboard.routes import along_route

        inside = position.in_route_position
        if isinstance(inside, model.PositionOfCurrentEntity):
            other = _entity(inside.entity_ref, board, position)
            return Place(other.x, other.y, other.z, _orientation(position.orientation, other.h))
        point = along_route(board, [waypoint() for waypoint in waypoints], inside)
        return _on_lane(board, point, position.orientation)

    return where


__all__ = ["RoadPosition", "Where", "place", "resolver", "shifted_lane"]
