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
    physics="the brake gives another deceleration than the command asks for, beyond what a motor takes over",
    equation="a = a_c + (g - 1)(a_c + a_motor) for a_c < -a_motor, else a_c",
    source="B. Breuer, K. Bill (eds.), Brake Technology Handbook",
    parameters=(
        Key("g", "-", 0.6, 1.2, neutral=1.0, least=0.02, minimum=0.0, meaning="produced over wanted deceleration"),
        Key(
            "motor",
            "m/s^2",
            0.0,
            4.0,  # more than regenerative braking gives on cars on the road
            neutral=0.0,
            least=0.2,
            minimum=0.0,
            late=True,
            meaning="deceleration that an electric motor takes over, before the brakes come in",
        ),
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
    if p.motor > 0.0:
        x.accel_brakes = -p.motor
        start, end = x.accel + x.accel_lead, x.accel - x.accel_lead
        start += (p.g - 1.0) * min(start + p.motor, 0.0)
        end += (p.g - 1.0) * min(end + p.motor, 0.0)
        x.accel = 0.5 * (start + end)
        x.accel_lead = start - x.accel
    elif x.accel < 0.0:
        x.accel *= p.g
        x.accel_lead *= p.g
