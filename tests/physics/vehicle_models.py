"""Models that the tests of motion share: a car with round numbers, nothing acting on it but what a test adds."""

from __future__ import annotations

from collections.abc import Mapping

from vehicle.messages import VehicleState
from vehicle.model.car import make_car
from vehicle.model.plant import Plant
from vehicle.model.vehicle_model import Base, Inputs, VehicleModel

CAR = {
    "wheelbase": 2.5,
    "cg_to_front_axle": 1.2,
    "mass": 1000.0,
    "yaw_inertia": 1300.0,
    "cornering_stiffness_front": 50_000.0,
    "cornering_stiffness_rear": 60_000.0,
    "wheel_radius": 0.3,
    "gear_ratio": 6.0,
}


def model(
    base: Base = "kinematic_bicycle", effects: Mapping[str, Mapping[str, float]] | None = None, **inputs: object
) -> VehicleModel:
    found = VehicleModel(base=base, inputs=Inputs(**inputs), car=make_car(CAR))  # type: ignore[arg-type]
    for name, values in (effects or {}).items():
        found = found.with_effect(name, values)
    return found


def plant(
    base: Base = "kinematic_bicycle",
    effects: Mapping[str, Mapping[str, float]] | None = None,
    *,
    v: float = 0.0,
    every: int = 1,
    dt: float = 1e-3,
    yaw: float = 0.0,
    steer: float = 0.0,
) -> Plant:
    car = Plant(model(base, effects), dt=dt, every=every)
    car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=yaw, v=v, steer=steer))
    return car
