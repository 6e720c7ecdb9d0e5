"""S: the simulator's parameters of the paper, each with unit, range and an honest meaning in this twin.

Source of names and presets: J. F. Arango et al., Sensors 2026, 26, 1338, parameter table. The paper used CARLA;
where a parameter belongs to its vehicle physics (PhysX), the meaning here is the equation behind it, on this car. The
defaults of the twin are those of its model file, not a preset: the paper tuned the mass to 8500 kg for a car of 730 kg.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite, radians
from typing import Literal, Protocol, TypeAlias, TypeVar

from vehicle.model.declared_parameter import Declaration
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.errors import ModelError, nearest_name
from vehicle.model.vehicle_model import VehicleModel

Iteration: TypeAlias = Literal[1, 5, 10]
Stage: TypeAlias = Literal["dt", "pe", "rw"]


class Mountable(Protocol):
    """Sensors that can be moved along the car."""

    def with_mount_x(self: Sensors, sensor: str, x: float) -> Sensors:
        """The same sensors with one of them at `x` [m] ahead of the rear axle."""


Sensors = TypeVar("Sensors", bound="Mountable")


@dataclass(frozen=True, slots=True)
class SimulatorParameter:
    """One parameter of S: its declaration and its values of the paper's iterations (None: not used then)."""

    declaration: Declaration
    first: float | None
    fifth: float
    tenth: float

    @property
    def name(self) -> str:
        """The paper's name."""
        return self.declaration.name


def _s(
    name: str, unit: str, low: float, high: float, presets: tuple[float | None, float, float], meaning: str
) -> SimulatorParameter:
    return SimulatorParameter(Declaration(name, unit, low, high, meaning), *presets)


S_PARAMETERS: tuple[SimulatorParameter, ...] = (
    _s("PEDESTRIAN_speed", "m/s", 0.1, 5.0, (3.0, 1.75, 1.75), "walking speed; the scenario's pedestrian_speed"),
    _s(
        "EGO_mass",
        "kg",
        300.0,
        10000.0,
        (1000.0, 4000.0, 8500.0),
        "mass that is accelerated; pedals keep the force calibrated for the model file's mass",
    ),
    _s("EGO_max_steer_angle", "deg", 5.0, 45.0, (25.0, 25.0, 20.0), "end stop: steer_angle_limit.limit"),
    _s(
        "EGO_dr_full_throttle",
        "N m s/rad",
        0.0,
        2.0,
        (0.15, 0.05, 0.05),
        "damping torque over motor speed at full throttle: motor_damping.full",
    ),
    _s(
        "EGO_dr_zero_throttle",
        "N m s/rad",
        0.0,
        2.0,
        (0.10, 0.50, 0.50),
        "damping torque over motor speed at zero throttle: motor_damping.zero",
    ),
    _s("EGO_moi", "kg m^2", 0.0, 5.0, (1.0, 0.75, 0.75), "moment of inertia at the motor shaft: motor_inertia.J"),
    _s(
        "THROTTLE_kp",
        "-",
        0.0,
        5.0,
        (0.5, 1.25, 1.25),
        "share of the acceleration error that the drive-by-wire unit adds to a drive command: kp_drive",
    ),
    _s("THROTTLE_ki", "1/s", 0.0, 5.0, (0.025, 0.005, 0.005), "the same of its integral: accel_controller.ki_drive"),
    _s("THROTTLE_delay", "s", 0.0, 1.0, (None, 0.15, 0.15), "dead time of the drive: drive_delay.T"),
    _s("BRAKE_kp", "-", 0.0, 5.0, (1.0, 0.09, 0.09), "as THROTTLE_kp, while braking: accel_controller.kp_brake"),
    _s("BRAKE_ki", "1/s", 0.0, 5.0, (0.0, 0.0005, 0.0005), "as THROTTLE_ki, while braking: accel_controller.ki_brake"),
    _s("GNSS_x", "m", -3.0, 3.0, (-0.6, -0.6, -1.0), "GNSS antenna ahead of the ego's centre"),
    _s("CAMERA_x", "m", -3.0, 3.0, (0.375, 0.375, 0.4), "camera ahead of the ego's centre"),
)
_BY_NAME = {p.name: p for p in S_PARAMETERS}

_EFFECT_OF: Mapping[str, tuple[str, str, float]] = {  # name -> effect, key, factor to SI
    "EGO_max_steer_angle": ("steer_angle_limit", "limit", radians(1.0)),
    "EGO_dr_full_throttle": ("motor_damping", "full", 1.0),
    "EGO_dr_zero_throttle": ("motor_damping", "zero", 1.0),
    "EGO_moi": ("motor_inertia", "J", 1.0),
    "THROTTLE_kp": ("accel_controller", "kp_drive", 1.0),
    "THROTTLE_ki": ("accel_controller", "ki_drive", 1.0),
    "THROTTLE_delay": ("drive_delay", "T", 1.0),
    "BRAKE_kp": ("accel_controller", "kp_brake", 1.0),
    "BRAKE_ki": ("accel_controller", "ki_brake", 1.0),
}
_MOUNT_OF = {"GNSS_x": "gnss", "CAMERA_x": "camera"}


def preset_s(iteration: Iteration, stage: Stage = "dt") -> dict[str, float]:
    """S of the paper's iteration and stage, in the units of the declarations; what it did not use is left out.

    Raises ModelError for another iteration than 1, 5 or 10, and for another stage than dt, pe or rw.
    """
    if iteration not in (1, 5, 10):
        raise ModelError("no such preset", key="iteration", found=str(iteration), allowed="1, 5, 10")
    if stage not in ("dt", "pe", "rw"):
        raise ModelError("no such preset", key="stage", found=str(stage), allowed="dt, pe, rw")
    column = {1: "first", 5: "fifth", 10: "tenth"}[iteration]
    values = {p.name: getattr(p, column) for p in S_PARAMETERS}
    if iteration == 1 and stage != "dt":
        values["PEDESTRIAN_speed"] = 1.75
    return {name: value for name, value in values.items() if value is not None}


def check_s(values: Mapping[str, float | str]) -> dict[str, float]:
    """`values` as numbers of declared names and ranges. Raises ModelError with the nearest name or the range."""
    checked = {}
    for name, value in values.items():
        if name not in _BY_NAME:
            near = nearest_name(name, _BY_NAME)
            allowed = ", ".join(_BY_NAME)
            raise ModelError("unknown parameter of S", key=f"S.{name}", found=name, allowed=allowed, nearest=near)
        try:
            number = float(value)
        except ValueError as error:
            raise ModelError("must be a number", key=f"S.{name}", found=repr(value)) from error
        checked[name] = _BY_NAME[name].declaration.check(number)
    return checked


def apply_s(model: VehicleModel, sensors: Sensors, values: Mapping[str, float | str]) -> tuple[VehicleModel, Sensors]:
    """Model and sensors with these parameters of S set; effects that the model lacks are added.

    PEDESTRIAN_speed belongs to the scenario (see `scenario_parameters`) and changes nothing here. Raises ModelError.
    """
    for name, value in check_s(values).items():
        if name == "EGO_mass":
            ratio = value / model.car.mass  # yaw inertia grows with the mass, its distribution unchanged
            model = model.with_car({"mass": value, "yaw_inertia": model.car.yaw_inertia * ratio})
        elif name in _EFFECT_OF:
            effect, key, factor = _EFFECT_OF[name]
            model = model.with_effect(effect, {key: factor * value})
        elif name in _MOUNT_OF:
            sensors = sensors.with_mount_x(_MOUNT_OF[name], model.car.center_x + value)
    return model, sensors


def s_value(model: VehicleModel, name: str) -> float | None:
    """What a model has as this parameter of S; the neutral value of an effect that it lacks, None if that is infinite
    or the parameter is none of the model's (scenario, sensors). Raises ModelError for an unknown name.
    """
    check_s({name: _BY_NAME[name].declaration.low} if name in _BY_NAME else {name: 0.0})
    if name == "EGO_mass":
        return model.car.mass
    if name not in _EFFECT_OF:
        return None
    effect, key, factor = _EFFECT_OF[name]
    value = model.value(effect, key)
    if value is None:
        value = next(k.neutral for k in find_effect(effect).parameters if k.name == key)
    return value / factor if isfinite(value) else None


def scenario_parameters(values: Mapping[str, float | str]) -> dict[str, float]:
    """The part of S that is a declared parameter of the scenario, under the name it has there."""
    checked = check_s(values)
    return {"pedestrian_speed": checked["PEDESTRIAN_speed"]} if "PEDESTRIAN_speed" in checked else {}
