"""Private actions: what one entity does."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

from openscenario.model.controllers import (
    ActivateControllerAction,
    AppearanceAction,
    ConnectTrailerAction,
    ControllerAction,
    DisconnectTrailerAction,
    VisibilityAction,
)
from openscenario.model.enums import (
    CoordinateSystem,
    DynamicsDimension,
    DynamicsShape,
    FollowingMode,
    LateralDisplacement,
    LongitudinalDisplacement,
    SpeedTargetValueType,
)
from openscenario.model.kinds import (
    Duration,
    Element,
    EntityName,
    Length,
    MaxAcceleration,
    MaxJerk,
    MaxSpeed,
    Metre,
    Number,
    Speed,
    xml,
)
from openscenario.model.positions import Position, Route, TimeReference, Trajectory


@dataclass(frozen=True, slots=True)
class TransitionDynamics(Element):
    """How a change happens: shape over `value` seconds, metres, or at `value` per second (peak rate, a magnitude)."""

    dynamics_shape: DynamicsShape
    dynamics_dimension: DynamicsDimension
    value: Number
    following_mode: FollowingMode | None = None


@dataclass(frozen=True, slots=True)
class DynamicConstraints(Element):
    """Limits as magnitudes [m/s^2], [m/s^3], [m/s]; absent: unlimited."""

    max_acceleration: MaxAcceleration | None = None
    max_acceleration_rate: MaxJerk | None = None
    max_deceleration: MaxAcceleration | None = None
    max_deceleration_rate: MaxJerk | None = None
    max_speed: MaxSpeed | None = None


# --- longitudinal


@dataclass(frozen=True, slots=True)
class AbsoluteTargetSpeed(Element):
    value: Speed


@dataclass(frozen=True, slots=True)
class RelativeTargetSpeed(Element):
    """`value` is a difference [m/s] (delta) or a factor [1]."""

    entity_ref: EntityName
    value: Number
    speed_target_value_type: SpeedTargetValueType
    continuous: bool


SpeedActionTarget: TypeAlias = AbsoluteTargetSpeed | RelativeTargetSpeed


@dataclass(frozen=True, slots=True)
class SpeedAction(Element):
    XML = "PrivateAction/LongitudinalAction/SpeedAction"

    speed_action_dynamics: TransitionDynamics
    speed_action_target: SpeedActionTarget


@dataclass(frozen=True, slots=True)
class SpeedProfileEntry(Element):
    """`time` [s] since the previous entry."""

    speed: Speed
    time: Duration | None = None


@dataclass(frozen=True, slots=True)
class SpeedProfileAction(Element):
    XML = "PrivateAction/LongitudinalAction/SpeedProfileAction"

    following_mode: FollowingMode
    dynamic_constraints: DynamicConstraints | None
    speed_profile_entries: tuple[SpeedProfileEntry, ...]
    entity_ref: EntityName | None = None


@dataclass(frozen=True, slots=True)
class LongitudinalDistanceAction(Element):
    """Exactly one of `distance` and `time_gap`."""

    XML = "PrivateAction/LongitudinalAction/LongitudinalDistanceAction"

    entity_ref: EntityName
    continuous: bool
    freespace: bool
    distance: Length | None = None
    time_gap: Duration | None = None
    displacement: LongitudinalDisplacement = "trailingReferencedEntity"
    coordinate_system: CoordinateSystem = "entity"
    dynamic_constraints: DynamicConstraints | None = None


# --- lateral


@dataclass(frozen=True, slots=True)
class AbsoluteTargetLane(Element):
    value: int


@dataclass(frozen=True, slots=True)
class RelativeTargetLane(Element):
    entity_ref: EntityName
    value: int


LaneChangeTarget: TypeAlias = AbsoluteTargetLane | RelativeTargetLane


@dataclass(frozen=True, slots=True)
class LaneChangeAction(Element):
    XML = "PrivateAction/LateralAction/LaneChangeAction"

    lane_change_action_dynamics: TransitionDynamics
    lane_change_target: LaneChangeTarget
    target_lane_offset: Metre = 0.0


@dataclass(frozen=True, slots=True)
class LaneOffsetActionDynamics(Element):
    dynamics_shape: DynamicsShape
    max_lateral_acc: MaxAcceleration | None = None


@dataclass(frozen=True, slots=True)
class AbsoluteTargetLaneOffset(Element):
    value: Metre


@dataclass(frozen=True, slots=True)
class RelativeTargetLaneOffset(Element):
    entity_ref: EntityName
    value: Metre


LaneOffsetTarget: TypeAlias = AbsoluteTargetLaneOffset | RelativeTargetLaneOffset


@dataclass(frozen=True, slots=True)
class LaneOffsetAction(Element):
    XML = "PrivateAction/LateralAction/LaneOffsetAction"

    lane_offset_action_dynamics: LaneOffsetActionDynamics
    lane_offset_target: LaneOffsetTarget
    continuous: bool


@dataclass(frozen=True, slots=True)
class LateralDistanceAction(Element):
    XML = "PrivateAction/LateralAction/LateralDistanceAction"

    entity_ref: EntityName
    continuous: bool
    freespace: bool
    distance: Length | None = None
    displacement: LateralDisplacement = "any"
    coordinate_system: CoordinateSystem = "entity"
    dynamic_constraints: DynamicConstraints | None = None


# --- placing, routing


@dataclass(frozen=True, slots=True)
class TeleportAction(Element):
    XML = "PrivateAction/TeleportAction"

    position: Position


@dataclass(frozen=True, slots=True)
class AssignRouteAction(Element):
    XML = "PrivateAction/RoutingAction/AssignRouteAction"

    route: Route = field(metadata=xml(catalog=True))


@dataclass(frozen=True, slots=True)
class AcquirePositionAction(Element):
    XML = "PrivateAction/RoutingAction/AcquirePositionAction"

    position: Position


@dataclass(frozen=True, slots=True)
class RandomRouteAction(Element):
    XML = "PrivateAction/RoutingAction/RandomRouteAction"


@dataclass(frozen=True, slots=True)
class TrajectoryFollowingMode(Element):
    following_mode: FollowingMode


@dataclass(frozen=True, slots=True)
class FollowTrajectoryAction(Element):
    XML = "PrivateAction/RoutingAction/FollowTrajectoryAction"

    trajectory: Trajectory = field(metadata=xml("TrajectoryRef/Trajectory", former=("Trajectory",), catalog=True))
    time_reference: TimeReference
    trajectory_following_mode: TrajectoryFollowingMode
    initial_distance_offset: Length = 0.0


# --- synchronizing


@dataclass(frozen=True, slots=True)
class TargetDistanceSteadyState(Element):
    distance: Length


@dataclass(frozen=True, slots=True)
class TargetTimeSteadyState(Element):
    time: Duration


SteadyState: TypeAlias = TargetDistanceSteadyState | TargetTimeSteadyState


@dataclass(frozen=True, slots=True)
class AbsoluteSpeed(Element):
    value: Speed
    steady_state: SteadyState | None = field(metadata=xml(inline=True), default=None)


@dataclass(frozen=True, slots=True)
class RelativeSpeedToMaster(Element):
    value: Number
    speed_target_value_type: SpeedTargetValueType
    steady_state: SteadyState | None = field(metadata=xml(inline=True), default=None)


FinalSpeed: TypeAlias = AbsoluteSpeed | RelativeSpeedToMaster


@dataclass(frozen=True, slots=True)
class SynchronizeAction(Element):
    XML = "PrivateAction/SynchronizeAction"

    master_entity_ref: EntityName
    target_position_master: Position
    target_position: Position
    final_speed: FinalSpeed | None = None
    target_tolerance_master: Length | None = None
    target_tolerance: Length | None = None


PrivateAction: TypeAlias = (
    SpeedAction
    | SpeedProfileAction
    | LongitudinalDistanceAction
    | LaneChangeAction
    | LaneOffsetAction
    | LateralDistanceAction
    | TeleportAction
    | AssignRouteAction
    | AcquirePositionAction
    | RandomRouteAction
    | FollowTrajectoryAction
    | SynchronizeAction
    | VisibilityAction
    | ControllerAction
    | ActivateControllerAction
    | AppearanceAction
    | ConnectTrailerAction
    | DisconnectTrailerAction
)
