"""Effective mass: payload and turning parts."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import ACCELERATES, DRIVE, SPEED, ShownBy


@effect(
    name="mass",
    slot="force",
    order=90,  # after all forces and their limits, which a load leaves as they are
    physics="the same forces move more mass than they were calibrated for; its weight and what goes with it grow along",
    equation="a = (F_drive - F_brake - F_air)/(ratio m), F as without a load and within the same limits",
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
    share = 1.0 / p.ratio  # forces are those that move the nominal mass as they move the laden one
    x.traction *= share
    x.accel_lead *= share
    x.brake *= share
    x.drag *= share
    x.resistance -= (1.0 - share) * x.drive_drag  # rolling resistance goes with the weight
    x.drive_drag *= share
    x.rotating_mass *= share
