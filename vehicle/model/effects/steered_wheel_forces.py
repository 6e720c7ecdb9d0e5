"""Driving and braking forces of steered wheels, which act across the car as well."""

from __future__ import annotations

from math import cos, sin
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import BRAKES, SHARP_CURVES, STEER, TURN, ShownBy
from vehicle.model.step_maths import spin_up


@effect(
    name="steered_wheel_forces",
    slot="body",
    order=85,  # after what alters the tyres' forces
    tyres=True,
    physics="a steered wheel that drives pulls the car's nose into the bend, one that brakes holds it out of it",
    equation="F_xf = share_drive F_drive - share_brake F_brake along the front wheels: F_xf cos d ahead, F_xf sin d "
    "across at the front axle; F_drive less what drag and turning parts of the drive take",
    source="R. Rajamani, Vehicle Dynamics and Control, 2nd ed., sec. 8.2 (front tyre forces in the body frame)",
    parameters=(
        Key(
            "drive",
            "-",
            0.0,
            1.0,
            neutral=0.0,
            least=0.1,
            minimum=0.0,
            maximum=1.0,
            meaning="share of the drive in front",
        ),
        Key(
            "brake",
            "-",
            0.0,
            1.0,
            neutral=0.0,
            least=0.1,
            minimum=0.0,
            maximum=1.0,
            meaning="share of the brakes in front",
        ),
    ),
    ties=("understeer", "axle_load_shift"),
    diagnosed=Diagnosed(details="understeer"),
    reveals="braking and accelerating with much steering",
    shown_by=ShownBy(356, (STEER, TURN), (SHARP_CURVES, BRAKES)),
)
def steered_wheel_forces(x: Bus, p: Any, m: Any) -> None:
    if x.vx == 0.0:
        return
    held = p.drive * x.drive_drag + p.brake * x.brake
    force = p.drive * (x.traction - spin_up(x)) - (held if x.vx > 0.0 else -held)
    less = 1.0 - cos(x.steer)
    x.traction -= p.drive * x.traction * less
    x.brake -= p.brake * x.brake * less
    x.resistance -= p.drive * x.drive_drag * less
    across = force * sin(x.steer)
    x.push += across
    x.steered_pull += across
    x.yaw_moment += x.cg_front * across
