"""The vehicle model of an ego: the file's body, and dynamics that fit a car the model was not made for."""

from __future__ import annotations

import functools
import hashlib
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from openscenario.model.entities import ScenarioObject, Vehicle
from scenarios import path as shipped
from vehicle.model.effect_catalogue import effects_of_files
from vehicle.model.model_file import model_text, read_model
from vehicle.model.vehicle_model import VehicleModel

SAME_CAR = 0.03  # relative difference of wheelbase and mass up to which the model is taken as one of this car


def fitted_model(
    path: Path | None, ego: ScenarioObject, effects: Sequence[Path] = ()
) -> tuple[VehicleModel, dict[str, Any]]:
    """Model for the ego's body, and what the log says about it.

    path: the model file, None for the TABBY EVO that ships; effects: files of effects of the user's own. The bounding
    box is always the scenario's. If the scenario's car differs from the model's by more than SAME_CAR in wheelbase or
    mass, the dynamics are scaled to its wheelbase, mass, axles and performance: a car of the same build and another
    size, not that car.
    """
    file = path if path is not None else shipped("models/tabby_evo.toml")
    model, digest = _read(file, effects)
    vehicle = ego.entity
    assert isinstance(vehicle, Vehicle)
    box, car = vehicle.bounding_box, model.car
    body = {
        "length": box.dimensions.length,
        "width": box.dimensions.width,
        "height": box.dimensions.height,
        "center_x": box.center.x,
    }
    wheelbase = vehicle.axles.front_axle.position_x if vehicle.axles.front_axle else car.wheelbase
    mass = vehicle.mass or _guessed_mass(model, body)
    about: dict[str, Any] = {"name": model.name or file.stem, "file": file.name, "sha256": digest, "scaled": False}
    if effects:
        about["effects"] = {part.name: hashlib.sha256(part.read_bytes()).hexdigest() for part in effects}
    if abs(wheelbase / car.wheelbase - 1) <= SAME_CAR and abs(mass / car.mass - 1) <= SAME_CAR:
        return model.with_car(body), about
    about.update(scaled=True, wheelbase=wheelbase, mass=mass, to=vehicle.name)
    return _scaled(model, vehicle, body, wheelbase, mass), about


def _read(file: Path, effects: Sequence[Path]) -> tuple[VehicleModel, str]:
    """The model of a file, and the digest of the file."""
    if effects or not file.is_file():  # what reads it says what is missing
        return read_model(file, extra=effects_of_files(effects)), hashlib.sha256(file.read_bytes()).hexdigest()
    stat = file.stat()
    return _unchanged(file, stat.st_mtime_ns, stat.st_size)


@functools.lru_cache(maxsize=4)
def _unchanged(file: Path, changed: int, size: int) -> tuple[VehicleModel, str]:
    """Models are immutable, and the variants of one scenario share theirs."""
    return read_model(file), hashlib.sha256(file.read_bytes()).hexdigest()


def with_model_text(model: VehicleModel, about: dict[str, Any]) -> dict[str, Any]:
    """`about` with the whole model as text, so that a log can be held against another one without any file."""
    return {**about, "toml": model_text(model)}


def _scaled(
    model: VehicleModel, vehicle: Vehicle, body: dict[str, float], wheelbase: float, mass: float
) -> VehicleModel:
    car, performance = model.car, vehicle.performance
    heavier, longer = mass / car.mass, wheelbase / car.wheelbase
    steered = vehicle.axles.front_axle
    radius = steered.wheel_diameter / 2 if steered else car.wheel_radius
    top = performance.max_speed if performance.max_speed > 0 else car.max_speed
    faster = min(top, 150.0) / car.max_speed
    stiffness = ("cornering_stiffness_front", "cornering_stiffness_rear")
    stated = {name: getattr(car, name) * heavier for name in stiffness if name not in car.at_default}
    scaled = model.with_car(
        {
            **body,
            **stated,
            "wheelbase": wheelbase,
            "cg_to_front_axle": car.cg_to_front_axle * longer,
            "mass": mass,
            "command_mass": car.command_mass * heavier,
            "yaw_inertia": car.yaw_inertia * heavier * longer**2,
            "wheel_radius": radius,
            "track": vehicle.axles.rear_axle.track_width or car.track,
            "max_speed": min(top, 150.0),
        }
    )
    return _with_limits(scaled, model, vehicle, radius, faster)


def _with_limits(
    scaled: VehicleModel, model: VehicleModel, vehicle: Vehicle, radius: float, faster: float
) -> VehicleModel:
    """Motor, brake and steering of the file's performance and axles, where the model has such effects."""
    import dataclasses

    performance, steered = vehicle.performance, vehicle.axles.front_axle
    names = {applied.name for applied in model.effects}
    forward = _plausible_limit(performance.max_acceleration, model.inputs.full_throttle)
    backward = _plausible_limit(performance.max_deceleration, model.inputs.full_brake)
    inputs = dataclasses.replace(model.inputs, full_throttle=forward, full_brake=backward)
    scaled = dataclasses.replace(scaled, inputs=inputs)
    if "brake_limit" in names:
        scaled = scaled.with_effect("brake_limit", {"limit": backward})
    if "steer_angle_limit" in names and steered is not None and 0 < steered.max_steering < math.pi / 2:
        scaled = scaled.with_effect("steer_angle_limit", {"limit": steered.max_steering})
    if "motor_torque" in names:
        torque = model.value("motor_torque", "torque") or 0.0
        ratio = forward * scaled.car.mass * radius / (torque * scaled.car.gear_ratio) if torque else 1.0
        # Speeds of the motor grow with those of the wheels; the power that goes with both.
        turns = faster * model.car.wheel_radius / radius
        values = {"torque": torque * ratio, "power": (model.value("motor_torque", "power") or 0.0) * ratio * turns}
        for key in ("corner_speed", "rated_speed", "max_speed"):
            values[key] = (model.value("motor_torque", key) or 0.0) * turns
        scaled = scaled.with_effect("motor_torque", values)
    return scaled


def _guessed_mass(model: VehicleModel, body: dict[str, float]) -> float:
    """Mass [kg] of a file that states none: the model's, by the volume of the box."""
    car = model.car
    volume = body["length"] * body["width"] * body["height"]
    return car.mass * volume / (car.length * car.width * car.height)


def _plausible_limit(limit: float, default: float) -> float:
    """A file's limit [m/s^2] where it is a limit: 0 or 200 mean that nobody thought about it."""
    return limit if 0.5 <= limit <= 15.0 else default
