"""Conditions and triggers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

from openscenario.model.entities import ByObjectType, EntityRef
from openscenario.model.enums import (
    AngleType,
    ConditionEdge,
    CoordinateSystem,
    DirectionalDimension,
    RelativeDistanceType,
    RoutingAlgorithm,
    Rule,
    StoryboardElementState,
    StoryboardElementType,
    TriggeringEntitiesRule,
)
from openscenario.model.kinds import (
    Acceleration,
    DateTime,
    Duration,
    Element,
    EntityName,
    Length,
    Metre,
    NonNegativeRadian,
    ParameterName,
    Radian,
    Second,
    SignalControllerName,
    Speed,
    StoryboardName,
    VariableName,
    xml,
)
from openscenario.model.positions import Position

# --- by entity


@dataclass(frozen=True, slots=True)
class EndOfRoadCondition(Element):
    duration: Duration


@dataclass(frozen=True, slots=True)
class CollisionCondition(Element):
    target: EntityRef | ByObjectType = field(metadata=xml(inline=True))


@dataclass(frozen=True, slots=True)
class OffroadCondition(Element):
    duration: Duration


@dataclass(frozen=True, slots=True)
class TimeHeadwayCondition(Element):
    entity_ref: EntityName
    freespace: bool
    rule: Rule
    value: Second
    along_route: bool | None = None
    coordinate_system: CoordinateSystem | None = None
    relative_distance_type: RelativeDistanceType | None = None
    routing_algorithm: RoutingAlgorithm = "undefined"


@dataclass(frozen=True, slots=True)
class TimeToCollisionConditionTarget(Element):
    """Exactly one of the two."""

    position: Position | None = None
    entity_ref: EntityRef | None = None


@dataclass(frozen=True, slots=True)
class TimeToCollisionCondition(Element):
    time_to_collision_condition_target: TimeToCollisionConditionTarget
    freespace: bool
    rule: Rule
    value: Second
    along_route: bool | None = None
    coordinate_system: CoordinateSystem | None = None
    relative_distance_type: RelativeDistanceType | None = None
    routing_algorithm: RoutingAlgorithm = "undefined"


@dataclass(frozen=True, slots=True)
class AccelerationCondition(Element):
    rule: Rule
    value: Acceleration
    direction: DirectionalDimension | None = None


@dataclass(frozen=True, slots=True)
class StandStillCondition(Element):
    duration: Duration


@dataclass(frozen=True, slots=True)
class SpeedCondition(Element):
    rule: Rule
    value: Speed
    direction: DirectionalDimension | None = None


@dataclass(frozen=True, slots=True)
class RelativeSpeedCondition(Element):
    entity_ref: EntityName
    rule: Rule
    value: Speed
    direction: DirectionalDimension | None = None


@dataclass(frozen=True, slots=True)
class TraveledDistanceCondition(Element):
    value: Length


@dataclass(frozen=True, slots=True)
class ReachPositionCondition(Element):
    tolerance: Length
    position: Position


@dataclass(frozen=True, slots=True)
class DistanceCondition(Element):
    position: Position
    freespace: bool
    rule: Rule
    value: Metre
    along_route: bool | None = None
    coordinate_system: CoordinateSystem | None = None
    relative_distance_type: RelativeDistanceType | None = None
    routing_algorithm: RoutingAlgorithm = "undefined"


@dataclass(frozen=True, slots=True)
class RelativeDistanceCondition(Element):
    entity_ref: EntityName
    relative_distance_type: RelativeDistanceType
    freespace: bool
    rule: Rule
    value: Metre
    coordinate_system: CoordinateSystem | None = None
    routing_algorithm: RoutingAlgorithm = "undefined"


@dataclass(frozen=True, slots=True)
class RelativeLaneRange(Element):
    from_: int | None = field(metadata=xml("from"), default=None)
    to: int | None = None


@dataclass(frozen=True, slots=True)
class RelativeClearanceCondition(Element):
    opposite_lanes: bool
    free_space: bool
    distance_forward: Length = 0.0
    distance_backward: Length = 0.0
    relative_lane_ranges: tuple[RelativeLaneRange, ...] = ()
    entity_refs: tuple[EntityRef, ...] = ()


@dataclass(frozen=True, slots=True)
class AngleCondition(Element):
    angle_type: AngleType
    angle: Radian
    angle_tolerance: NonNegativeRadian
    coordinate_system: CoordinateSystem = "world"


@dataclass(frozen=True, slots=True)
class RelativeAngleCondition(Element):
    entity_ref: EntityName
    angle_type: AngleType
    angle: Radian
    angle_tolerance: NonNegativeRadian
    coordinate_system: CoordinateSystem = "entity"


EntityCondition: TypeAlias = (
    EndOfRoadCondition
    | CollisionCondition
    | OffroadCondition
    | TimeHeadwayCondition
    | TimeToCollisionCondition
    | AccelerationCondition
    | StandStillCondition
    | SpeedCondition
    | RelativeSpeedCondition
    | TraveledDistanceCondition
    | ReachPositionCondition
    | DistanceCondition
    | RelativeDistanceCondition
    | RelativeClearanceCondition
    | AngleCondition
    | RelativeAngleCondition
)


@dataclass(frozen=True, slots=True)
class TriggeringEntities(Element):
    triggering_entities_rule: TriggeringEntitiesRule
    entity_refs: tuple[EntityRef, ...]


@dataclass(frozen=True, slots=True)
class ByEntityCondition(Element):
    triggering_entities: TriggeringEntities
    entity_condition: EntityCondition


# --- by value


@dataclass(frozen=True, slots=True)
class ParameterCondition(Element):
    XML = "ByValueCondition/ParameterCondition"

    parameter_ref: ParameterName
    rule: Rule
    value: str


@dataclass(frozen=True, slots=True)
class VariableCondition(Element):
    XML = "ByValueCondition/VariableCondition"

    variable_ref: VariableName
    rule: Rule
    value: str


@dataclass(frozen=True, slots=True)
class TimeOfDayCondition(Element):
    XML = "ByValueCondition/TimeOfDayCondition"

    rule: Rule
    date_time: DateTime


@dataclass(frozen=True, slots=True)
class SimulationTimeCondition(Element):
    XML = "ByValueCondition/SimulationTimeCondition"

    rule: Rule
    value: Second


@dataclass(frozen=True, slots=True)
class StoryboardElementStateCondition(Element):
    XML = "ByValueCondition/StoryboardElementStateCondition"

    storyboard_element_type: StoryboardElementType
    storyboard_element_ref: StoryboardName
    state: StoryboardElementState


@dataclass(frozen=True, slots=True)
class UserDefinedValueCondition(Element):
    XML = "ByValueCondition/UserDefinedValueCondition"

    name: str
    rule: Rule
    value: str


@dataclass(frozen=True, slots=True)
class TrafficSignalCondition(Element):
    XML = "ByValueCondition/TrafficSignalCondition"

    name: str
    state: str


@dataclass(frozen=True, slots=True)
class TrafficSignalControllerCondition(Element):
    XML = "ByValueCondition/TrafficSignalControllerCondition"

    traffic_signal_controller_ref: SignalControllerName
    phase: str


ByValueCondition: TypeAlias = (
    ParameterCondition
    | VariableCondition
    | TimeOfDayCondition
    | SimulationTimeCondition
    | StoryboardElementStateCondition
    | UserDefinedValueCondition
    | TrafficSignalCondition
    | TrafficSignalControllerCondition
)


# --- triggers


@dataclass(frozen=True, slots=True)
class Condition(Element):
    """`condition` is a ByEntityCondition or directly one of the by-value conditions."""

    name: str
    delay: Duration
    condition_edge: ConditionEdge
    condition: ByEntityCondition | ByValueCondition = field(metadata=xml(inline=True))


@dataclass(frozen=True, slots=True)
class ConditionGroup(Element):
    """True when all its conditions are."""

    conditions: tuple[Condition, ...]


@dataclass(frozen=True, slots=True)
class Trigger(Element):
    """True when one of its groups is; without groups never true."""

    condition_groups: tuple[ConditionGroup, ...] = ()
