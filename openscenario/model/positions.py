"""The positions of the standard. Angles [rad], lengths [m]."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

from openscenario.model.enums import ReferenceContext
from openscenario.model.kinds import Element, EntityName, Latitude, Length, Longitude, Metre, Radian, xml

if TYPE_CHECKING:
    from openscenario.model.routes import Route
    from openscenario.model.trajectories import Trajectory


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
