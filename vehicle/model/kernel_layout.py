"""Where an effect's numbers stand: the table, the parameters and the memory that the kernel gets."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from vehicle.messages import FloatArray
from vehicle.model.effect import SLOTS, Effect
from vehicle.model.effect_compiler import BUS_DTYPE, compiled, doubles, memory_dtype, parameter_dtype
from vehicle.model.errors import ModelError
from vehicle.model.kernel import ACCELERATION, DYNAMIC, IMPOSED, KINEMATIC, PEDALS, SPEED
from vehicle.model.step_maths import DELAY_LINE
from vehicle.model.vehicle_model import VehicleModel

SLOW = 1.0  # m/s, below it slip angles mean little and a car moves kinematically
ROAD_HOLDS = 60  # order in the slot body after which the road cuts side forces: that of tyre_saturation, the same limit
SLOW_WHEELBASE = 2.0  # m, of the smallest car for which that holds; models of cars: Froude's law


class Layout:
    """A set of effects in the order in which the kernel calls them.

    `table` int64 (n, 3): address, place of parameters, place of memory; `bounds` int64 (12,): where each slot begins,
    then begin and end of both parts of the slot body, before and after the road cuts the side forces (SHAPES and TAKES
    of the kernel);
    `places`: (effect, key) -> index in the parameter array; `starts`: memory that takes a bus field at reset.
    Perception effects act on object tracks, not here, and are left out.
    """

    def __init__(self, effects: Iterable[Effect]) -> None:
        chosen = [e for e in effects if e.slot != "perception"]
        chosen.sort(key=lambda e: (SLOTS.index(e.slot), e.order, e.name))
        self.effects = tuple(chosen)
        self._code = tuple(compiled(e) for e in chosen)  # keeps the machine code alive
        self.table = np.zeros((len(chosen), 3), dtype=np.int64)
        self.bounds = np.zeros(len(SLOTS) + 1, dtype=np.int64)
        self.places: dict[tuple[str, str], int] = {}
        self.starts: list[tuple[int, int, str]] = []
        self.memory_size = 0
        for j, (effect, code) in enumerate(zip(chosen, self._code, strict=True)):
            self.table[j] = code.address, len(self.places), self.memory_size
            for key in parameter_dtype(effect).names or ():
                self.places[effect.name, key] = len(self.places)
            at = self.memory_size
            for m in effect.memory:
                if m.start:
                    self.starts.append((at, m.size, m.start))
                at += m.size
            self.memory_size += doubles(memory_dtype(effect))
            self.bounds[SLOTS.index(effect.slot) + 1 :] += 1
        body = SLOTS.index("body")
        split = int(self.bounds[body]) + sum(e.slot == "body" and e.order <= ROAD_HOLDS for e in chosen)
        self.bounds = np.append(self.bounds, (self.bounds[body], split, split, self.bounds[body + 1]))
        self.tyres = any(e.tyres for e in chosen)
        self.swings = any(e.fine or (e.tyres and e.memory) for e in chosen)  # bent tyres, or with a state: fast motion

    def parameters(self, values: Mapping[str, Mapping[str, float]]) -> FloatArray:
        """The parameters (n,) of these values (effect -> key -> value), in the order of `places`.

        Each has the unit that its effect declares, and is neutral where no value is given.
        """
        neutral = {e.name: e.neutral() for e in self.effects}
        return np.array([values.get(e, neutral[e]).get(k, neutral[e][k]) for e, k in self.places], dtype=np.float64)


def check_delay(effect: Effect, values: Mapping[str, float], dt: float) -> None:
    """Raises ModelError if a dead time does not fit the delay line at steps of `dt` [s]."""
    key = effect.delay
    if key and values[key] / dt > DELAY_LINE - 2:
        raise ModelError(
            f"dead time of {effect.name} too long for a step of {dt:g} s",
            key=key,
            found=f"{values[key]:g}",
            allowed=f"up to {(DELAY_LINE - 2) * dt:g} s",
        )


def input_mode(longitudinal: tuple[str, ...]) -> int:
    """How the longitudinal input columns drive the kernel."""
    if len(longitudinal) == 2 or longitudinal[0] in ("throttle_cmd", "motor_current"):
        return PEDALS
    return {"v": IMPOSED, "speed_cmd": SPEED}.get(longitudinal[0], ACCELERATION)


def body_kind(model: VehicleModel, layout: Layout) -> int:
    """The kernel's body: with tyres if the base has them or an effect acts on them."""
    return DYNAMIC if model.base == "dynamic_bicycle" or layout.tyres else KINEMATIC


def bus_of(model: VehicleModel) -> Any:
    """An array of one bus record with the constants of a car."""
    car, inputs = model.car, model.inputs
    bus = np.zeros(1, dtype=BUS_DTYPE)
    front, rear = car.stiffness(stiff=model.base == "kinematic_bicycle")
    values = {
        "wheelbase": car.wheelbase,
        "cg_front": car.cg_to_front_axle,
        "cg_rear": car.cg_to_rear_axle,
        "cg_height": car.cg_height,
        "track": car.track,
        "ax_x": car.ax_x,
        "ay_x": car.ay_x,
        "slow": SLOW * min(math.sqrt(car.wheelbase / SLOW_WHEELBASE), 1.0),
        "mass": car.mass,
        "mass_ref": car.command_mass,
        "yaw_inertia": car.yaw_inertia,
        "stiffness_front": front,
        "stiffness_rear": rear,
        "wheel_radius": car.wheel_radius,
        "gear_ratio": car.gear_ratio,
        "full_throttle": inputs.full_throttle,
        "full_brake": inputs.full_brake,
        "steer_scale": 1.0,
        "speed_gain": 1.0,
    }
    for name, value in values.items():
        bus[name] = value
    return bus
