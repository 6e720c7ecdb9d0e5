"""Light states and animations."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

from openscenario.model.declarations import File
from openscenario.model.enums import (
    ColorType,
    LightMode,
    PedestrianGestureType,
    PedestrianMotionType,
    VehicleComponentType,
    VehicleLightType,
)
from openscenario.model.kinds import Duration, Element, NonNegative, Second, Share, TransitionTime, xml


@dataclass(frozen=True, slots=True)
class VehicleLight(Element):
    vehicle_light_type: VehicleLightType


@dataclass(frozen=True, slots=True)
class UserDefinedLight(Element):
    user_defined_light_type: str


LightType: TypeAlias = VehicleLight | UserDefinedLight


@dataclass(frozen=True, slots=True)
class ColorRgb(Element):
    red: Share
    green: Share
    blue: Share


@dataclass(frozen=True, slots=True)
class ColorCmyk(Element):
    cyan: Share
    magenta: Share
    yellow: Share
    key: Share


@dataclass(frozen=True, slots=True)
class Color(Element):
    color_type: ColorType
    value: ColorRgb | ColorCmyk | None = field(metadata=xml(inline=True), default=None)


@dataclass(frozen=True, slots=True)
class LightState(Element):
    """`luminous_intensity` [cd]."""

    mode: LightMode
    luminous_intensity: NonNegative | None = None
    flashing_on_duration: Duration = 0.5
    flashing_off_duration: Duration = 0.5
    color: Color | None = None


@dataclass(frozen=True, slots=True)
class LightStateAction(Element):
    light_type: LightType
    light_state: LightState
    transition_time: TransitionTime = 0.0


@dataclass(frozen=True, slots=True)
class VehicleComponent(Element):
    vehicle_component_type: VehicleComponentType


@dataclass(frozen=True, slots=True)
class UserDefinedComponent(Element):
    user_defined_component_type: str


@dataclass(frozen=True, slots=True)
class ComponentAnimation(Element):
    component: VehicleComponent | UserDefinedComponent = field(metadata=xml(inline=True))


@dataclass(frozen=True, slots=True)
class PedestrianGesture(Element):
    gesture: PedestrianGestureType


@dataclass(frozen=True, slots=True)
class PedestrianAnimation(Element):
    motion: PedestrianMotionType | None = None
    user_defined_pedestrian_animation: str = ""
    pedestrian_gestures: tuple[PedestrianGesture, ...] = ()


@dataclass(frozen=True, slots=True)
class AnimationFile(Element):
    file: File
    time_offset: Second = 0.0


@dataclass(frozen=True, slots=True)
class UserDefinedAnimation(Element):
    user_defined_animation_type: str


AnimationType: TypeAlias = ComponentAnimation | PedestrianAnimation | AnimationFile | UserDefinedAnimation


@dataclass(frozen=True, slots=True)
class AnimationState(Element):
    state: Share


@dataclass(frozen=True, slots=True)
class AnimationAction(Element):
    animation_type: AnimationType
    animation_state: AnimationState | None = None
    loop: bool = False
    animation_duration: Duration | None = None
