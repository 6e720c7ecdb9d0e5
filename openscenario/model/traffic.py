"""Background traffic that the storyboard asks for, and the traffic lights of the road network."""

from __future__ import annotations

from dataclasses import dataclass, field

from openscenario.model.declarations import Properties
from openscenario.model.entities import Controller, EntityObject, ObjectController
from openscenario.model.enums import Role, VehicleCategory
from openscenario.model.kinds import (
    Count,
    Duration,
    Element,
    EntityName,
    Length,
    Metre,
    NonNegative,
    Number,
    PhaseDuration,
    Speed,
    Weight,
    xml,
)
from openscenario.model.positions import Position


@dataclass(frozen=True, slots=True)
class TrafficSignalState(Element):
    traffic_signal_id: str
    state: str


@dataclass(frozen=True, slots=True)
class TrafficSignalGroupState(Element):
    state: str


@dataclass(frozen=True, slots=True)
class Phase(Element):
    name: str
    duration: PhaseDuration
    traffic_signal_states: tuple[TrafficSignalState, ...] = ()
    traffic_signal_group_state: TrafficSignalGroupState | None = field(
        metadata=xml(former=("TrafficeSignalGroupState",)), default=None
    )


@dataclass(frozen=True, slots=True)
class TrafficSignalController(Element):
    name: str
    delay: Duration = 0.0
    reference: str = ""
    phases: tuple[Phase, ...] = ()


@dataclass(frozen=True, slots=True)
class ControllerDistributionEntry(Element):
    weight: Weight
    controller: Controller = field(metadata=xml(catalog=True))


@dataclass(frozen=True, slots=True)
class VehicleCategoryDistributionEntry(Element):
    category: VehicleCategory
    weight: Weight


@dataclass(frozen=True, slots=True)
class VehicleRoleDistributionEntry(Element):
    role: Role
    weight: Weight


@dataclass(frozen=True, slots=True)
class TrafficDefinition(Element):
    """What the traffic is made of, until 1.2."""

    name: str
    vehicle_category_distribution: tuple[VehicleCategoryDistributionEntry, ...] = field(
        metadata=xml("VehicleCategoryDistribution/VehicleCategoryDistributionEntry")
    )
    controller_distribution: tuple[ControllerDistributionEntry, ...] = field(
        metadata=xml("ControllerDistribution/ControllerDistributionEntry")
    )
    vehicle_role_distribution: tuple[VehicleRoleDistributionEntry, ...] = field(
        metadata=xml("VehicleRoleDistribution/VehicleRoleDistributionEntry"), default=()
    )


@dataclass(frozen=True, slots=True)
class ScenarioObjectTemplate(Element):
    entity: EntityObject = field(metadata=xml(inline=True, catalog=True))
    object_controllers: tuple[ObjectController, ...] = ()


@dataclass(frozen=True, slots=True)
class EntityDistributionEntry(Element):
    weight: Weight
    scenario_object_template: ScenarioObjectTemplate


@dataclass(frozen=True, slots=True)
class TrafficDistributionEntry(Element):
    weight: Weight
    entity_distribution: tuple[EntityDistributionEntry, ...] = field(
        metadata=xml("EntityDistribution/EntityDistributionEntry")
    )
    properties: Properties | None = None


@dataclass(frozen=True, slots=True)
class TrafficDistribution(Element):
    """What the traffic is made of, since 1.3."""

    traffic_distribution_entries: tuple[TrafficDistributionEntry, ...] = field(metadata=xml("TrafficDistributionEntry"))


@dataclass(frozen=True, slots=True)
class Range(Element):
    lower_limit: Number
    upper_limit: Number


@dataclass(frozen=True, slots=True)
class DirectionOfTravelDistribution(Element):
    same: Weight
    opposite: Weight


@dataclass(frozen=True, slots=True)
class CentralSwarmObject(Element):
    entity_ref: EntityName


@dataclass(frozen=True, slots=True)
class TrafficSourceAction(Element):
    """`rate` [1/s]."""

    radius: Length
    rate: NonNegative
    position: Position
    speed: Speed | None = field(metadata=xml(former=("velocity",)), default=None)
    traffic_definition: TrafficDefinition | None = None
    traffic_distribution: TrafficDistribution | None = None


@dataclass(frozen=True, slots=True)
class TrafficSinkAction(Element):
    radius: Length
    position: Position
    rate: NonNegative | None = None
    traffic_definition: TrafficDefinition | None = None


@dataclass(frozen=True, slots=True)
class TrafficSwarmAction(Element):
    inner_radius: Length
    semi_major_axis: Length
    semi_minor_axis: Length
    offset: Metre
    number_of_vehicles: Count
    central_object: CentralSwarmObject
    velocity: Speed | None = None
    initial_speed_range: Range | None = None
    direction_of_travel_distribution: DirectionOfTravelDistribution | None = None
    traffic_definition: TrafficDefinition | None = None
    traffic_distribution: TrafficDistribution | None = None


@dataclass(frozen=True, slots=True)
class Lane(Element):
    id: int


@dataclass(frozen=True, slots=True)
class RoadCursor(Element):
    road_id: str
    s: Length | None = None
    lanes: tuple[Lane, ...] = ()


@dataclass(frozen=True, slots=True)
class RoadRange(Element):
    road_cursors: tuple[RoadCursor, ...]
    length: Length | None = None


@dataclass(frozen=True, slots=True)
class Polygon(Element):
    positions: tuple[Position, ...] = field(metadata=xml("Position"))


@dataclass(frozen=True, slots=True)
class TrafficArea(Element):
    polygon: Polygon | None = None
    road_ranges: tuple[RoadRange, ...] = ()


@dataclass(frozen=True, slots=True)
class TrafficAreaAction(Element):
    continuous: bool
    number_of_entities: Count
    traffic_distribution: TrafficDistribution
    traffic_area: TrafficArea


@dataclass(frozen=True, slots=True)
class TrafficStopAction(Element):
    pass


@dataclass(frozen=True, slots=True)
class TrafficAction(Element):
    XML = "GlobalAction/TrafficAction"

    action: TrafficSourceAction | TrafficSinkAction | TrafficSwarmAction | TrafficAreaAction | TrafficStopAction = (
        field(metadata=xml(inline=True))
    )
    traffic_name: str = ""
