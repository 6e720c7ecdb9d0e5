"""Gain of the drive."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import ACCELERATES, DRIVE, SPEED, ShownBy


@effect(
    name="drive_gain",
    slot="command",
    order=60,
    physics="the torque map gives another force than the command asks for",
    equation="a = g a_c for a_c > 0",
    source="L. Guzzella, A. Sciarretta, Vehicle Propulsion Systems, 3rd ed.",
    parameters=(
        Key("g", "-", 0.7, 1.2, neutral=1.0, least=0.02, minimum=0.0, meaning="produced over wanted acceleration"),
    ),
    ties=(
        "mass",
        "power_limit",
    ),
    reveals="equal steps of drive and brake command from 3 to 8 m/s",
    shown_by=ShownBy(60, (DRIVE, SPEED), (ACCELERATES,)),
    diagnosed=Diagnosed(
        input_scales=("full_throttle",),
        hides_in=(
            ("EGO_mass", 40),
            ("EGO_dr_full_throttle", 40),
            ("EGO_moi", 30),
            ("THROTTLE_kp", 20),
            ("THROTTLE_ki", 20),
        ),
    ),
)
def drive_gain(x: Bus, p: Any, m: Any) -> None:
    if x.accel > 0.0:
        x.accel *= p.g
        x.accel_lead *= p.g
