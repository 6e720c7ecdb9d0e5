"""Private actions on what drives and shows an entity: visibility, controllers, appearance, trailers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

from openscenario.model.appearance import AnimationAction, LightStateAction
from openscenario.model.entities import Controller, ObjectController
from openscenario.model.enums import AutomaticGearType
from openscenario.model.kinds import Element, EntityName, NonNegative, Number, xml


@dataclass(frozen=True, slots=True)
class SensorReference(Element):
    name: str


@dataclass(frozen=True, slots=True)
class VisibilityAction(Element):
    XML = "PrivateAction/VisibilityAction"

    graphics: bool
    sensors: bool
    traffic: bool
    sensor_references: tuple[SensorReference, ...] = field(
        metadata=xml("SensorReferenceSet/SensorReference"), default=()
    )


@dataclass(frozen=True, slots=True)
class AssignControllerAction(Element):
    """`object_controller` since 1.3, `controller` before."""

    object_controller: ObjectController | None = None
    controller: Controller | None = field(metadata=xml("Controller", catalog=True), default=None)
    activate_lateral: bool | None = None
    activate_longitudinal: bool | None = None
    activate_animation: bool | None = None
    activate_lighting: bool | None = None


@dataclass(frozen=True, slots=True)
class OverrideThrottleAction(Element):
    active: bool
    value: Number
    max_rate: NonNegative | None = None


@dataclass(frozen=True, slots=True)
class OverrideClutchAction(Element):
    active: bool
    value: Number
    max_rate: NonNegative | None = None


@dataclass(frozen=True, slots=True)
class OverrideSteeringWheelAction(Element):
    """`value` [rad]."""

    active: bool
    value: Number
    max_rate: NonNegative | None = None
    max_torque: NonNegative | None = None


@dataclass(frozen=True, slots=True)
class BrakePercent(Element):
    value: Number
    max_rate: NonNegative | None = None


@dataclass(frozen=True, slots=True)
class BrakeForce(Element):
    value: Number
    max_rate: NonNegative | None = None


BrakeInput: TypeAlias = BrakePercent | BrakeForce


@dataclass(frozen=True, slots=True)
class OverrideBrakeAction(Element):
    """`brake_input` since 1.2, `value` [1] before."""

    active: bool
    value: Number | None = None
    brake_input: BrakeInput | None = field(metadata=xml(inline=True), default=None)


@dataclass(frozen=True, slots=True)
class OverrideParkingBrakeAction(Element):
    active: bool
    value: Number | None = None
    brake_input: BrakeInput | None = field(metadata=xml(inline=True), default=None)


@dataclass(frozen=True, slots=True)
class ManualGear(Element):
    number: int


@dataclass(frozen=True, slots=True)
class AutomaticGear(Element):
    gear: AutomaticGearType


GearInput: TypeAlias = ManualGear | AutomaticGear


@dataclass(frozen=True, slots=True)
class OverrideGearAction(Element):
    """`gear` since 1.2, `number` before."""

    active: bool
    number: Number | None = None
    gear: GearInput | None = field(metadata=xml(inline=True), default=None)


@dataclass(frozen=True, slots=True)
class OverrideControllerValueAction(Element):
    throttle: OverrideThrottleAction | None = None
    brake: OverrideBrakeAction | None = None
    clutch: OverrideClutchAction | None = None
    parking_brake: OverrideParkingBrakeAction | None = None
    steering_wheel: OverrideSteeringWheelAction | None = None
    gear: OverrideGearAction | None = None


@dataclass(frozen=True, slots=True)
class ActivateControllerAction(Element):
    """`None` leaves a domain as it is."""

    XML = "PrivateAction/ActivateControllerAction"

    object_controller_ref: str | None = field(metadata=xml(former=("controllerRef",)), default=None)
    lateral: bool | None = None
    longitudinal: bool | None = None
    animation: bool | None = None
    lighting: bool | None = None


@dataclass(frozen=True, slots=True)
class ControllerAction(Element):
    """One to three of its parts, carried out together."""

    XML = "PrivateAction/ControllerAction"

    assign_controller_action: AssignControllerAction | None = None
    override_controller_value_action: OverrideControllerValueAction | None = None
    activate_controller_action: ActivateControllerAction | None = None


@dataclass(frozen=True, slots=True)
class AppearanceAction(Element):
    XML = "PrivateAction/AppearanceAction"

    light_state_action: LightStateAction | None = None
    animation_action: AnimationAction | None = None


@dataclass(frozen=True, slots=True)
class ConnectTrailerAction(Element):
    XML = "PrivateAction/TrailerAction/ConnectTrailerAction"

    trailer_ref: EntityName


@dataclass(frozen=True, slots=True)
class DisconnectTrailerAction(Element):
    XML = "PrivateAction/TrailerAction/DisconnectTrailerAction"
