"""Positions, and the routes and trajectories that lead along positions. Angles [rad], lengths [m]."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

from openscenario.model.declarations import ParameterDeclaration
from openscenario.model.enums import ReferenceContext, RouteStrategy
from openscenario.model.kinds import (
    Count,
    Curvature,
    Element,
    EntityName,
    Latitude,
    Length,
    Longitude,
    Metre,
    Number,
    Radian,
    Scale,
    Second,
    xml,
)


@dataclass(frozen=True, slots=True)
class Orientation(Element):
    """Absent angles are 0; `type` absent means absolute."""

    h: Radian = 0.0
    p: Radian = 0.0
    r: Radian = 0.0
    type: ReferenceContext = "absolute"


@dataclass(frozen=True, slots=True)
class WorldPosition(Element):
    """z, p, r absent: on the road surface, along it; h absent: 0, or along the trajectory it is a vertex of."""

    x: Metre
    y: Metre
    z: Metre | None = None
    h: Radian | None = None
    p: Radian | None = None
    r: Radian | None = None


@dataclass(frozen=True, slots=True)
class RelativeWorldPosition(Element):
    entity_ref: EntityName
    dx: Metre
    dy: Metre
    dz: Metre = 0.0
    orientation: Orientation | None = None


@dataclass(frozen=True, slots=True)
class RelativeObjectPosition(Element):
    entity_ref: EntityName
    dx: Metre
    dy: Metre
    dz: Metre = 0.0
    orientation: Orientation | None = None


@dataclass(frozen=True, slots=True)
class RoadPosition(Element):
    road_id: str
    s: Length
    t: Metre
    orientation: Orientation | None = None


@dataclass(frozen=True, slots=True)
class RelativeRoadPosition(Element):
    entity_ref: EntityName
    ds: Metre
    dt: Metre
    orientation: Orientation | None = None


@dataclass(frozen=True, slots=True)
class LanePosition(Element):
    road_id: str
    lane_id: int
    s: Length
    offset: Metre = 0.0
    orientation: Orientation | None = None


@dataclass(frozen=True, slots=True)
class RelativeLanePosition(Element):
    """`ds` (along the road's reference line) or `ds_lane` (along the lane's centre line), not both; neither is 0 m."""

    entity_ref: EntityName
    d_lane: int
    ds: Metre | None = None
    offset: Metre = 0.0
    ds_lane: Metre | None = None
    orientation: Orientation | None = None


@dataclass(frozen=True, slots=True)
class PositionOfCurrentEntity(Element):
    XML = "FromCurrentEntity"

    entity_ref: EntityName


@dataclass(frozen=True, slots=True)
class PositionInRoadCoordinates(Element):
    XML = "FromRoadCoordinates"

    path_s: Length
    t: Metre


@dataclass(frozen=True, slots=True)
class PositionInLaneCoordinates(Element):
    XML = "FromLaneCoordinates"

    path_s: Length
    lane_id: int
    lane_offset: Metre = 0.0


InRoutePosition: TypeAlias = PositionOfCurrentEntity | PositionInRoadCoordinates | PositionInLaneCoordinates


@dataclass(frozen=True, slots=True)
class RoutePosition(Element):
    route: Route = field(metadata=xml("RouteRef/Route", catalog=True))
    in_route_position: InRoutePosition
    orientation: Orientation | None = None


@dataclass(frozen=True, slots=True)
class TrajectoryPosition(Element):
    trajectory: Trajectory = field(metadata=xml("TrajectoryRef/Trajectory", catalog=True))
    s: Length
    t: Metre = 0.0
    orientation: Orientation | None = None


@dataclass(frozen=True, slots=True)
class GeoPosition(Element):
    """`latitude_deg`, `longitude_deg` [deg], `altitude` [m] since 1.2; `latitude`, `longitude`, `height` before."""

    latitude_deg: Latitude | None = None
    longitude_deg: Longitude | None = None
    altitude: Metre | None = None
    latitude: Radian | None = None
    longitude: Radian | None = None
    height: Metre | None = None
    vertical_road_selection: int = 0
    orientation: Orientation | None = None


Position: TypeAlias = (
    WorldPosition
    | RelativeWorldPosition
    | RelativeObjectPosition
    | RoadPosition
    | RelativeRoadPosition
    | LanePosition
    | RelativeLanePosition
    | RoutePosition
    | GeoPosition
    | TrajectoryPosition
)


@dataclass(frozen=True, slots=True)
class Waypoint(Element):
    route_strategy: RouteStrategy
    position: Position


@dataclass(frozen=True, slots=True)
class Route(Element):
    name: str
    closed: bool
    waypoints: tuple[Waypoint, ...]
    parameter_declarations: tuple[ParameterDeclaration, ...] = field(
        metadata=xml("ParameterDeclarations/ParameterDeclaration"), default=()
    )


@dataclass(frozen=True, slots=True)
class Vertex(Element):
    position: Position
    time: Second | None = None


@dataclass(frozen=True, slots=True)
class Polyline(Element):
    vertices: tuple[Vertex, ...]


@dataclass(frozen=True, slots=True)
class Clothoid(Element):
    """`curvature_prime` [1/m^2]: change of curvature along the arc (called curvatureDot in 1.0 and 1.1)."""

    curvature: Curvature
    curvature_prime: Number = field(metadata=xml(former=("curvatureDot",)))
    length: Length
    position: Position
    start_time: Second | None = None
    stop_time: Second | None = None


@dataclass(frozen=True, slots=True)
class ClothoidSplineSegment(Element):
    curvature_start: Curvature
    curvature_end: Curvature
    length: Length
    h_offset: Radian = 0.0
    time_start: Second | None = None
    position_start: Position | None = None


@dataclass(frozen=True, slots=True)
class ClothoidSpline(Element):
    segments: tuple[ClothoidSplineSegment, ...]
    time_end: Second | None = None


@dataclass(frozen=True, slots=True)
class ControlPoint(Element):
    position: Position
    time: Second | None = None
    weight: Number = 1.0


@dataclass(frozen=True, slots=True)
class Knot(Element):
    value: Number


@dataclass(frozen=True, slots=True)
class Nurbs(Element):
    order: Count
    control_points: tuple[ControlPoint, ...]
    knots: tuple[Knot, ...]


Shape: TypeAlias = Polyline | Clothoid | ClothoidSpline | Nurbs


@dataclass(frozen=True, slots=True)
class Trajectory(Element):
    name: str
    closed: bool
    shape: Shape
    parameter_declarations: tuple[ParameterDeclaration, ...] = field(
        metadata=xml("ParameterDeclarations/ParameterDeclaration"), default=()
    )


@dataclass(frozen=True, slots=True)
class Timing(Element):
    domain_absolute_relative: ReferenceContext
    scale: Scale
    offset: Second


@dataclass(frozen=True, slots=True)
class Untimed(Element):
    """`<TimeReference><None/></TimeReference>`: the time stamps of the trajectory are ignored."""

    XML = "None"


TimeReference: TypeAlias = Timing | Untimed
