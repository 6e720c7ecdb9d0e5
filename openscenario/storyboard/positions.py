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
from openscenario.findings import Finding, ScenarioError
from openscenario.road.positions import Pose, RoadPosition
from openscenario.storyboard.geo import projection
from openscenario.storyboard.places import Place, RoadPoint, turned_in_plane, yaw_in_plane
from openscenario.storyboard.registry import entity_called
from openscenario.storyboard.trajectories import Course, course
from openscenario.storyboard.unsupported import Unsupported

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board
    from openscenario.storyboard.entity import Entity

Where = Callable[[], Place]


def resolver(position: model.Position, board: Board, mover: Entity | None = None) -> Where:
    """A function that gives the place of `position` at the time it is called.

    `mover` is what will be put there: its route, if it has one, leads from another entity to what is relative to it.

    Raises:
        Unsupported: the kind of position, or a road, lane or entity that does not exist.
    """
    match position:
        case model.WorldPosition():
            return _world(position, board)
        case model.GeoPosition():
            return _geo(position, board)
        case model.RelativeWorldPosition():
            return _relative_world(position, board)
        case model.RelativeObjectPosition():
            return _relative_object(position, board)
        case model.LanePosition():
            return _lane(position, board)
        case model.RoadPosition():
            return _road(position, board)
        case model.RelativeLanePosition():
            return _relative_lane(position, board, mover)
        case model.RelativeRoadPosition():
            return _relative_road(position, board, mover)
        case model.TrajectoryPosition():
            return _trajectory(position, board)
        case model.RoutePosition():
            return _route(position, board)
    raise Unsupported("this position is not supported", element=position)


def place(position: model.Position, board: Board) -> Place:
    """The place of `position` now."""
    return resolver(position, board)()


def _constant(value: Place) -> Where:
    return lambda: value


def _orientation(orientation: model.Orientation | None, base: float) -> float:
    """Heading [rad] that an orientation means where the reference heading is `base`."""
    if orientation is None:
        return base
    return orientation.h if orientation.type == "absolute" else base + orientation.h


def _tilt(orientation: model.Orientation | None, pitch: float, roll: float) -> tuple[float, float]:
    """Pitch and roll [rad] that an orientation means where those of the reference are `pitch` and `roll`."""
    if orientation is None:
        return pitch, roll
    if orientation.type == "absolute":
        return orientation.p, orientation.r
    return pitch + orientation.p, roll + orientation.r


def _world(position: model.WorldPosition, board: Board) -> Where:
    """The numbers are those of the road file: where its header moves the roads, places go with them."""
    x, y, z, h, facing = position.x, position.y, position.z, position.h, 0.0
    if board.network is not None:
        x, y, height, facing = board.network.moved(x, y, z or 0.0, h or 0.0)
        z, h = (None if z is None else height), (None if h is None else facing)
    return _constant(on_ground(board, x, y, z, h, position.p, position.r, facing))


def _geo(position: model.GeoPosition, board: Board) -> Where:
    """Projected as the road file's header says. That gives places in the world, where the header's offset has already
    moved the roads to. Source: ASAM OpenDRIVE 1.8, 8.5: the offset comes before the projection."""
    if board.network is None:
        raise Unsupported("the scenario has no road network", element=position)
    latitude, longitude = position.latitude_deg, position.longitude_deg
    if latitude is None or longitude is None:  # until 1.1, in radians
        if position.latitude is None or position.longitude is None:
            raise Unsupported("latitude and longitude are needed", element=position)
        latitude, longitude = math.degrees(position.latitude), math.degrees(position.longitude)
    x, y = projection(board.network.geo_reference)(longitude, latitude)
    z = position.altitude if position.altitude is not None else position.height
    given = position.orientation
    if given is None:
        return _constant(on_ground(board, x, y, z, None, None, None))
    if given.type == "absolute":
        return _constant(on_ground(board, x, y, z, given.h, given.p, given.r))
    ground = on_ground(board, x, y, z, given.h, None, None)
    return _constant(ground._replace(pitch=ground.pitch + given.p, roll=ground.roll + given.r))


def on_ground(
    board: Board,
    x: float,
    y: float,
    z: float | None,
    h: float | None,
    p: float | None,
    r: float | None,
    facing: float = 0.0,
) -> Place:
    """A place in the world; what is not given of height, pitch and roll is the road's, and without `h` it faces as
    `facing` says [rad]."""
    network = board.network
    if network is None:
        return Place(x, y, z or 0.0, facing if h is None else h, p or 0.0, r or 0.0, None, h is not None)
    up = z is not None
    height, heading = z or 0.0, facing if h is None else h
    if not up or p is None or r is None:
        found = network.locate(x, y, None if h is None else heading, z=height if up else None)
        pose = network.lane_pose(found.road, found.lane, found.s, found.offset)
        yaw = yaw_in_plane(pose.pitch, pose.roll, heading - pose.h)
        _, pitch, roll = turned_in_plane(pose.h, pose.pitch, pose.roll, yaw)
        height = height if up else pose.z
        p = pitch if p is None else p
        r = roll if r is None else r
    return Place(x, y, height, heading, p, r, None, h is not None)


def _relative_world(position: model.RelativeWorldPosition, board: Board) -> Where:
    other = entity_called(position.entity_ref, board, position)
    orientation = position.orientation

    def where() -> Place:
        return Place(
            other.x + position.dx,
            other.y + position.dy,
            other.z + position.dz,
            _orientation(orientation, other.h),
            *_tilt(orientation, other.pitch, other.roll),
            has_heading=orientation is not None,
        )

    return where


def _relative_object(position: model.RelativeObjectPosition, board: Board) -> Where:
    other = entity_called(position.entity_ref, board, position)
    orientation = position.orientation

    def where() -> Place:
        dx, dy, dz = turned(other.h, other.pitch, other.roll, position.dx, position.dy, position.dz)
        return Place(
            other.x + dx,
            other.y + dy,
            other.z + dz,
            _orientation(orientation, other.h),
            *_tilt(orientation, other.pitch, other.roll),
            has_heading=orientation is not None,
        )

    return where


def turned(h: float, pitch: float, roll: float, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A vector [m] in the frame of a body, seen from the world: turned by roll, then pitch, then heading [rad]."""
    y, z = y * math.cos(roll) - z * math.sin(roll), y * math.sin(roll) + z * math.cos(roll)
    x, z = x * math.cos(pitch) + z * math.sin(pitch), z * math.cos(pitch) - x * math.sin(pitch)
    return x * math.cos(h) - y * math.sin(h), x * math.sin(h) + y * math.cos(h), z


def _on_lane(
    board: Board,
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
    return _on_surface(pose, base, orientation, point)


def _on_surface(pose: Pose, base: float, orientation: model.Orientation | None, point: RoadPoint | None) -> Place:
    """What stands on a road's surface, heading `base` [rad] or as an orientation says, with the pitch and roll that
    the surface gives it that way round; an absolute orientation gives its own."""
    heading = _orientation(orientation, base)
    if orientation is not None and orientation.type == "absolute":
        yaw = yaw_in_plane(pose.pitch, pose.roll, heading - pose.h)  # an angle in the world's plane
    else:
        yaw = heading - pose.h  # one in the road's
    h, pitch, roll = turned_in_plane(pose.h, pose.pitch, pose.roll, yaw)
    return Place(pose.x, pose.y, pose.z, h, *_tilt(orientation, pitch, roll), point, orientation is not None)


def _road_of(board: Board, road: str, element: object) -> None:
    if board.network is None:
        raise Unsupported("the scenario has no road network", element=element)
    if road not in board.network.roads:
        raise Unsupported("no road of this id in the road network", road, _some(tuple(board.network.roads)), element)


def _some(names: tuple[str, ...]) -> str:
    return ", ".join(names[:12]) + (", ..." if len(names) > 12 else "")


def _on_road(board: Board, road: str, s: float) -> float:
    """s [m], or where the road ends if that comes first (the reader has said so)."""
    assert board.network is not None
    return min(max(s, 0.0), board.network.roads[road].length)


def _lane(position: model.LanePosition, board: Board) -> Where:
    _road_of(board, position.road_id, position)
    s = _on_road(board, position.road_id, position.s)
    point = RoadPoint(position.road_id, position.lane_id, s, position.offset)
    try:
        return _constant(_on_lane(board, point, position.orientation))
    except KeyError:
        raise Unsupported(
            f"no lane {position.lane_id} on road {position.road_id} at s = {position.s:g} m", element=position
        ) from None


def _road(position: model.RoadPosition, board: Board) -> Where:
    _road_of(board, position.road_id, position)
    network = board.network
    assert network is not None
    pose = network.road_pose(position.road_id, _on_road(board, position.road_id, position.s), position.t)
    return _constant(_on_surface(pose, pose.h, position.orientation, None))


def shifted_lane(lane: int, by: int) -> int:
    """The lane id `by` lanes further in the direction of increasing ids; there is no lane 0 to drive on."""
    new = lane + by
    if lane < 0 <= new:
        return new + 1
    if lane > 0 >= new:
        return new - 1
    return new


def _relative_lane(position: model.RelativeLanePosition, board: Board, mover: Entity | None) -> Where:
    """`ds` and what goes with it follow the road: increasing s, lane ids, t. `dsLane` follows the other entity: ahead
    of it, lanes and offset to its left. With neither it is beside the other, as with `ds` of 0. Without orientation it
    heads with or against the traffic as the other does."""
    other = entity_called(position.entity_ref, board, position)
    network = board.network
    if network is None:
        raise Unsupported("the scenario has no road network", element=position)
    orientation = position.orientation

    def where() -> Place:
        ground = board.ground
        ground.track(other)
        route = mover.route_lanes if mover is not None and mover.route_lanes else other.route_lanes
        if position.ds_lane is None:
            point, side = ground.along_road(other, position.ds or 0.0, route), 1
        else:
            point = ground.along_lane(other, position.ds_lane, route)
            side = 1 if ground.sense_at(other, point) > 0.0 else -1
        target = RoadPoint(
            point.road, shifted_lane(point.lane, side * position.d_lane), point.s, side * position.offset
        )
        faced = point if orientation is not None else target
        if network.lane(target.road, target.lane, target.s) is None:
            raise _no_lane(position, target)
        base = network.lane_pose(target.road, target.lane, target.s, 0.0).h
        if ground.sense_at(other, faced) < 0.0:
            base += math.pi
        return _on_lane(board, target, orientation, base=base)

    return where


def _no_lane(position: model.RelativeLanePosition, target: RoadPoint) -> ScenarioError:
    """Where the other entity is then, the road has no lane so far beside it: known only while the scenario runs."""
    text = f"road {target.road} has no lane {target.lane} at s = {target.s:g} m, beside {position.entity_ref}"
    at, found = position.at, str(position.d_lane)
    return ScenarioError(
        [Finding("ref.unknown_lane", "error", at.file, at.line, f"{at.element}@dLane", found, text=text)]
    )


def _relative_road(position: model.RelativeRoadPosition, board: Board, mover: Entity | None) -> Where:
    """`ds` and `dt` are those of the road's axes. A relative orientation is one to the reference line; without any it
    faces as the other entity would there."""
    other = entity_called(position.entity_ref, board, position)
    network = board.network
    if network is None:
        raise Unsupported("the scenario has no road network", element=position)

    def where() -> Place:
        ground = board.ground
        ground.track(other)
        route = mover.route_lanes if mover is not None and mover.route_lanes else other.route_lanes
        point = ground.along_road(other, position.ds, route)
        t = network.lane_t(point.road, point.lane, point.s) + point.offset
        pose = network.road_pose(point.road, point.s, t + position.dt)
        turned_round = position.orientation is None and ground.sense_at(other, point) < 0.0
        base = pose.h + math.pi if turned_round else pose.h
        return _on_surface(pose, base, position.orientation, None)

    return where


def _trajectory(position: model.TrajectoryPosition, board: Board) -> Where:
    def where() -> Place:
        along: Course = course(position.trajectory, lambda inner: place(inner, board))
        x, y, z, h = along.at(position.s)
        if along.length > 0.0 and isinstance(position.trajectory.shape, model.Polyline):
            h = along.tangent(position.s)
        x -= position.t * math.sin(h)
        y += position.t * math.cos(h)
        tilt = _tilt(position.orientation, along.pitch(position.s), 0.0)
        return Place(x, y, z, _orientation(position.orientation, h), *tilt, has_heading=True)

    return where


def _route(position: model.RoutePosition, board: Board) -> Where:
    network = board.network
    if network is None:
        raise Unsupported("the scenario has no road network", element=position)
    waypoints = [resolver(waypoint.position, board) for waypoint in position.route.waypoints]

    def where() -> Place:
        from openscenario.storyboard.routes import along_route

        inside = position.in_route_position
        if isinstance(inside, model.PositionOfCurrentEntity):
            other = entity_called(inside.entity_ref, board, position)
            return Place(other.x, other.y, other.z, _orientation(position.orientation, other.h))
        places = [waypoint() for waypoint in waypoints]
        point = along_route(board, places, inside, closed=position.route.closed)
        return _on_lane(board, point, position.orientation)

    return where


__all__ = ["RoadPosition", "Where", "place", "resolver", "shifted_lane"]
