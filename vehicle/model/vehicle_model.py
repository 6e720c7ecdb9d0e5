"""A vehicle model: base, inputs, car and effects. Immutable data; `vehicle.model.plant` makes it run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import inf, isfinite
from typing import Literal, TypeAlias, get_args

from vehicle.messages import VehicleDescription
from vehicle.model.car import Car
from vehicle.model.command_inputs import Inputs
from vehicle.model.effect import Effect
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.errors import ModelError, nearest_name
from vehicle.model.remainder import Remainder
from vehicle.model.remainder_shape import RemainderShape

Base: TypeAlias = Literal["kinematic_bicycle", "dynamic_bicycle"]
__all__ = ["BASES", "AppliedEffect", "Base", "Inputs", "Interval", "VehicleModel", "check_base"]

BASES: tuple[Base, ...] = get_args(Base)

MAX_STEER = 0.6  # rad, of a model without steer_angle_limit


@dataclass(frozen=True, slots=True)
class Interval:
    """A fitted value's 95 % interval."""

    low: float
    high: float


@dataclass(frozen=True, slots=True)
class AppliedEffect:
    """An effect with its parameter values, where they come from, and how sure they are."""

    effect: Effect
    values: Mapping[str, float]
    intervals: Mapping[str, Interval] = field(default_factory=dict)
    fitted_on: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.effect.name


@dataclass(frozen=True, slots=True)
class VehicleModel:
    """A car and the effects that act on it, in the order of its file.

    remainder: what the model is known not to explain; remainder_shape: how that repeats itself. given: keys of
    [inputs] and [parameters] that its file states, the others being defaults (None: there is no file).
    """

    base: Base
    inputs: Inputs
    car: Car
    effects: tuple[AppliedEffect, ...] = ()
    name: str = ""
    remainder: Remainder = field(default_factory=dict)
    remainder_shape: RemainderShape = field(default_factory=RemainderShape)
    given: frozenset[str] | None = field(default=None, compare=False, repr=False)

    @property
    def drives_nothing(self) -> str:
        """Why no command moves the model along, "" if one does: a speed that is asked for needs a controller."""
        if self.inputs.longitudinal != ("speed_cmd",) or any(a.name == "speed_controller" for a in self.effects):
            return ""
        return (
            'longitudinal = "speed_cmd" drives nothing, because the model has no effect speed_controller; add one: '
            '[[effect]] name = "speed_controller", [effect.parameters] kp = 1.0'
        )

    def value(self, effect: str, key: str) -> float | None:
        """Value of an effect's parameter, None if the model lacks the effect."""
        for applied in self.effects:
            if applied.name == effect:
                return applied.values[key]
        return None

    def with_effect(
        self, name: str | Effect, values: Mapping[str, float], *, fitted_on: tuple[str, ...] = ()
    ) -> VehicleModel:
        """The model with an effect added, or with these of its values changed if it is there. Raises ModelError."""
        found = name if isinstance(name, Effect) else find_effect(name)
        old = next((a for a in self.effects if a.name == found.name), None)
        merged = found.complete({**(old.values if old else {}), **values})
        applied = AppliedEffect(found, merged, fitted_on=fitted_on)
        if old is None:
            check_base(found, self.base)
            return replace(self, effects=(*self.effects, applied))
        return replace(self, effects=tuple(applied if a is old else a for a in self.effects))

    def without_effect(self, name: str) -> VehicleModel:
        """The model without an effect. Raises ModelError if it has none of that name."""
        kept = tuple(a for a in self.effects if a.name != name)
        if len(kept) == len(self.effects):
            names = [a.name for a in self.effects]
            raise ModelError("effect is not in the model", key=name, found=name, nearest=nearest_name(name, names))
        return replace(self, effects=kept)

    def with_car(self, values: Mapping[str, float]) -> VehicleModel:
        """The model with base parameters changed. Raises ModelError."""
        return replace(self, car=self.car.with_values(values))

    def description(self) -> VehicleDescription:
        """What a driving stack may know of this car: its data sheet, sensors left at their defaults.

        Forces are those of `command_mass`: a payload or a mass set through S is not known to the stack.
        """
        car = self.car
        torque = self._known("motor_torque", "torque", inf)
        inertia = self._known("motor_inertia", "J", 0.0) * (car.gear_ratio / car.wheel_radius) ** 2
        force = torque * car.gear_ratio / car.wheel_radius
        return VehicleDescription(
            length=car.length,
            width=car.width,
            height=car.height,
            wheelbase=car.wheelbase,
            center_x=car.center_x,
            max_steer=self._known("steer_angle_limit", "limit", MAX_STEER),
            max_speed=car.max_speed,
            max_acceleration=min(self.inputs.full_throttle * car.command_mass, force) / (car.command_mass + inertia),
            max_deceleration=min(self.inputs.full_brake, self._known("brake_limit", "limit", inf)),
            mass=car.command_mass,
            steer_delay=self._known("steer_delay", "T", 0.0) + self._known("steer_lag", "tau", 0.0),
            drive_delay=self._known("drive_delay", "T", 0.0) + self._known("drive_lag", "tau", 0.0),
        )

    def _known(self, effect: str, key: str, otherwise: float) -> float:
        value = self.value(effect, key)
        return value if value is not None and isfinite(value) else otherwise


def check_base(effect: Effect, base: str) -> None:
    """Raises ModelError if the effect does not act on this base."""
    if base not in effect.base:
        raise ModelError(
            "effect does not act on this base", key=effect.name, found=base, allowed=", ".join(effect.base)
        )
