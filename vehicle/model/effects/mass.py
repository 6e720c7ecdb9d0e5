"""Effective mass: payload and turning parts."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import ACCELERATES, DRIVE, SPEED, ShownBy


@effect(
    name="mass",
    slot="command",
    order=88,  # after what reads the pedals: a command that counts as released is one of the stack, whatever it moves
    physics="the same force moves more mass than the commands were calibrated for",
    equation="a = a_c / ratio",
    source="M. Mitschke, H. Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed. (rotating masses)",
    parameters=(
        Key("ratio", "-", 0.7, 1.4, neutral=1.0, least=0.02, minimum=0.05, meaning="effective over nominal mass"),
    ),
    ties=(
        "drive_gain",
        "brake_gain",
        "motor_inertia",
    ),
    reveals="equal steps of drive and brake command from 3 to 8 m/s",
    shown_by=ShownBy(70, (DRIVE, SPEED), (ACCELERATES,)),
    diagnosed=Diagnosed(
        input_scales=("full_throttle", "full_brake"),
        hides_in=(("EGO_moi", 10), ("THROTTLE_kp", 30), ("THROTTLE_ki", 30), ("BRAKE_kp", 30), ("BRAKE_ki", 30)),
    ),
)
def mass(x: Bus, p: Any, m: Any) -> None:
    x.accel /= p.ratio
    x.accel_lead /= p.ratio
    x.accel_jump /= p.ratio
    x.accel_arrived /= p.ratio
