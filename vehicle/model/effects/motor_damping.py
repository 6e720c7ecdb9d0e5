"""Speed-proportional damping inside the motor."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import ACCELERATES, DRIVE, SPEED, ShownBy
from vehicle.model.step_maths import clip


@effect(
    name="motor_damping",
    slot="force",
    physics="the motor resists its own turning, differently with and without throttle (regeneration, friction)",
    equation="F = -c (i/r)^2 v, c = zero + (full - zero) throttle",
    source="PhysX vehicle SDK, damping rates of the engine, as CARLA exposes them (damping_rate_*)",
    parameters=(
        Key("full", "N m s/rad", 0.0, 1.0, neutral=0.0, least=0.005, minimum=0.0, meaning="damping at full throttle"),
        Key("zero", "N m s/rad", 0.0, 1.0, neutral=0.0, least=0.005, minimum=0.0, meaning="damping at zero throttle"),
    ),
    ties=("viscous_resistance", "lift_off_braking"),
    reveals="coast down after full throttle, and full throttle, at several speeds",
    shown_by=ShownBy(100, (DRIVE, SPEED), (ACCELERATES,)),
    diagnosed=Diagnosed(needs="drive_train"),
)
def motor_damping(x: Bus, p: Any, m: Any) -> None:
    throttle = clip(x.accel / x.full_throttle, 0.0, 1.0)
    ratio = x.gear_ratio / x.wheel_radius
    held = (p.zero + (p.full - p.zero) * throttle) * ratio * ratio * abs(x.vx)
    x.resistance += held
    x.drive_drag += held
