"""Slip of the wheels from whose turning the speed is taken."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import ACCELERATES, BRAKES, DRIVES_5_S, ShownBy
from vehicle.model.step_maths import spin_up


@effect(
    name="wheel_slip",
    slot="sensor",
    physics="a wheel that brakes turns slower, and one that drives turns faster, than the car moves over ground",
    equation="v_measured = v (1 - c_brake b + c_drive a), b: braking force over mass, a: "
    "that of the drive, less what its drag and turning parts take (back: -a)",
    source="H. B. Pacejka, Tire and Vehicle Dynamics, 3rd ed., sec. 1.2 (linear longitudinal slip stiffness)",
    parameters=(
        Key(
            "c_brake", "s^2/m", 0.0, 0.02, neutral=0.0, least=0.001, minimum=0.0, maximum=0.2,
            meaning="slip of a braked wheel",
        ),
        Key(
            "c_drive", "s^2/m", 0.0, 0.02, neutral=0.0, least=0.001, minimum=0.0, maximum=0.2,
            meaning="slip of a driven one",
        ),
    ),
    ties=("wheel_radius", "brake_gain", "gnss_latency"),
    reveals="hard braking and hard acceleration on a straight, with positions logged",
    shown_by=ShownBy(411, (("v",), ("x", "ax")), (DRIVES_5_S, BRAKES), usual=(ACCELERATES,)),
)  # fmt: skip
def wheel_slip(x: Bus, p: Any, m: Any) -> None:
    push = x.traction - spin_up(x)
    along = (push if x.vx >= 0.0 else -push) - x.drive_drag  # drives the car on, or against its rolling back
    x.meas_v *= 1.0 + (p.c_drive * along - p.c_brake * x.brake) / x.mass_ref
