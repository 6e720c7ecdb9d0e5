"""A manoeuvre driven with a model as the car: the commands it takes, and the motion that comes of it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pytest_dvp.gap.diagnose.experiment import Values
from pytest_dvp.gap.manoeuvres.catalogue import Manoeuvre
from pytest_dvp.gap.manoeuvres.driving_limits import Area, Envelope
from pytest_dvp.gap.manoeuvres.limit_violations import violations
from pytest_dvp.gap.manoeuvres.simulated_driver import PERIOD, Driver, DriverDemand, Motion
from pytest_dvp.logs.log_contents import FloatArray

if TYPE_CHECKING:
    from vehicle.model.car import Car
    from vehicle.model.command_inputs import Inputs
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel

LONGEST = 180.0  # s, of one manoeuvre
SIZES = (1.0, 0.85, 0.7, 0.55)  # tried until one keeps within the envelope
STEP = 0.01  # s, of the model

Respond = Callable[[DriverDemand], tuple[float, float, float, float, float]]
"""What a car does in one period with the wish held: x, y [m], yaw [rad], v [m/s], yaw rate [rad/s] at its end."""


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Drive:
    """One manoeuvre as driven, 50 rows a second.

    t (n,) [s]; wishes (n, 3): acceleration [m/s^2], road-wheel angle [rad], speed [m/s] asked for; motion (n, 5): x, y
    [m] of the rear axle, yaw [rad] without turns of 2 pi, v [m/s], yaw rate [rad/s] at t. It starts at 0, 0 along x.
    finished: whether it came to its end, at a standstill, within LONGEST.
    """

    manoeuvre: Manoeuvre
    size: float
    area: Area
    t: FloatArray
    wishes: FloatArray
    motion: FloatArray
    finished: bool = True

    @property
    def seconds(self) -> float:
        """Duration [s]."""
        return float(self.t[-1])


def drive(manoeuvre: Manoeuvre, car: Car, respond: Respond, envelope: Envelope, size: float = 1.0) -> Drive:
    """Drive a manoeuvre with anything that answers to wishes; it stands at 0, 0 along x."""
    front = car.center_x + 0.5 * car.length
    driver = Driver(envelope, car.wheelbase, front, size=size, round_about=manoeuvre.round_about)
    running = manoeuvre.drive(driver)
    wishes: list[DriverDemand] = []
    motion = [(0.0, 0.0, 0.0, 0.0, 0.0)]
    wish = next(running)
    finished = False
    try:
        while len(wishes) < LONGEST / PERIOD:
            wishes.append(wish)
            shown = respond(wish)
            motion.append(shown)
            wish = running.send(Motion(*shown[:4]))
    except StopIteration:
        finished = True
    t = np.round(np.arange(len(wishes)) * PERIOD, 6)
    return Drive(manoeuvre, size, driver.area, t, np.array(wishes), np.array(motion[:-1]), finished)


def perform(manoeuvre: Manoeuvre, model: VehicleModel, values: Values, envelope: Envelope,
            sizes: tuple[float, ...] = SIZES, effects: Sequence[Effect] = ()) -> Drive | None:  # fmt: skip
    """The largest of `sizes` that is driven to its end and keeps within the envelope with this model and values, None
    if none does; effects: the user's own."""
    full = with_values(model, values, effects)
    for size in sizes:
        found = drive(manoeuvre, model.car, responder(full), envelope, size)
        left = violations(found.t, found.motion, found.wishes[:, 1], envelope, found.area, model.car)
        if found.finished and not left:
            return found
    return None


def responder(model: VehicleModel) -> Respond:
    """The model as a car that stands at the origin."""
    from vehicle.model.plant import Plant

    plant = Plant(model, dt=STEP, every=round(PERIOD / STEP))
    inputs, hold = model.inputs, round(PERIOD / STEP)
    row = np.zeros((1, 6))
    plain = inputs.longitudinal == ("accel_cmd",)

    def respond(wish: DriverDemand) -> tuple[float, float, float, float, float]:
        row[0, 0] = wish.steer  # a plant takes the angle, whatever scale its log column has
        if plain:
            row[0, 1] = wish.accel
        else:
            for column, value in inputs_of(inputs, np.array([wish.accel]), np.array([wish.speed])).items():
                _set(row, inputs, column, float(value[0]))
        last: list[float] = plant.drive(row, hold)[-1].tolist()
        return last[1], last[2], last[4], last[5], last[8]

    return respond


def _set(row: FloatArray, inputs: Inputs, name: str, value: float) -> None:
    """One input column in the kernel's command row."""
    if name == "motor_current":
        row[0, 2:4] = max(value, 0.0) / inputs.full_current, max(-value, 0.0) / inputs.full_current
    elif name == "brake_pressure":
        row[0, 3] = value / inputs.full_pressure
    else:
        row[0, {"accel_cmd": 1, "throttle_cmd": 2, "brake_cmd": 3, "speed_cmd": 4, "v": 5}[name]] = value


def columns(found: Drive, inputs: Inputs) -> dict[str, FloatArray]:
    """Commands of a drive as the log columns (n,) that drive a model, "t" [s] first, each in the unit of its column."""
    named: dict[str, FloatArray] = {
        "t": found.t,
        inputs.steer: (found.wishes[:, 1] - inputs.steer_zero) / inputs.steer_scale,
    }
    return named | inputs_of(inputs, found.wishes[:, 0], found.wishes[:, 2])


def inputs_of(inputs: Inputs, accel: FloatArray, speed: FloatArray) -> dict[str, FloatArray]:
    """Accelerations (n,) [m/s^2] or speeds (n,) [m/s] as the columns (n,) that the model takes."""
    throttle = np.clip(accel / inputs.full_throttle, 0.0, 1.0)
    brake = np.clip(-accel / inputs.full_brake, 0.0, 1.0)
    every = {
        "accel_cmd": accel,
        "throttle_cmd": throttle,
        "brake_cmd": brake,
        "brake_pressure": brake * inputs.full_pressure,
        "motor_current": (throttle - brake) * inputs.full_current,
        "speed_cmd": speed,
        "v": speed,
    }
    return {name: every[name] for name in inputs.longitudinal}


def with_values(model: VehicleModel, values: Values, effects: Sequence[Effect] = ()) -> VehicleModel:
    """The model with fitted values in it: of effects, of its input map ("inputs") and of its car ("parameters").

    effects: the user's own, of which values may be given.
    """
    by_name: dict[str, dict[str, float]] = {}
    for (name, key), value in values.items():
        by_name.setdefault(name, {})[key] = value
    if "inputs" in by_name:
        scales: dict[str, Any] = dict(by_name.pop("inputs"))
        model = dataclasses.replace(model, inputs=dataclasses.replace(model.inputs, **scales))
    if "parameters" in by_name:
        model = model.with_car(by_name.pop("parameters"))
    own = {e.name: e for e in (*effects, *(applied.effect for applied in model.effects))}
    for name, given in by_name.items():
        if all(math.isfinite(v) for v in given.values()):
            model = model.with_effect(own.get(name, name), given)
    return model
