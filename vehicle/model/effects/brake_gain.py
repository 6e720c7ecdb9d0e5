"""Gain of the brake."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import BRAKE, BRAKES, SPEED, ShownBy


@effect(
    name="brake_gain",
    slot="command",
    order=60,
    physics="the brake gives another deceleration than the command asks for",
    equation="a = g a_c for a_c < 0",
    source="B. Breuer, K. Bill (eds.), Brake Technology Handbook",
    parameters=(
        Key("g", "-", 0.6, 1.2, neutral=1.0, least=0.02, minimum=0.0, meaning="produced over wanted deceleration"),
    ),
    ties=(
        "mass",
        "brake_limit",
    ),
    reveals="equal steps of drive and brake command from 3 to 8 m/s",
    shown_by=ShownBy(120, (BRAKE, SPEED), (BRAKES,)),
    diagnosed=Diagnosed(
        input_scales=("full_brake",),
        hides_in=(("EGO_mass", 50), ("EGO_dr_zero_throttle", 40), ("BRAKE_kp", 20), ("BRAKE_ki", 20)),
    ),
)
def brake_gain(x: Bus, p: Any, m: Any) -> None:
    if x.accel < 0.0:
        x.accel *= p.g
        x.accel_lead *= p.g
