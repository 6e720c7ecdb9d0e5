"""Torque curve of an electric motor with a fixed gear."""

from __future__ import annotations

from math import inf
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import ACCELERATES, DRIVE, SPEED, ShownBy


@effect(
    name="motor_torque",
    slot="force",
    order=40,
    physics="an electric motor gives full torque up to a corner speed, then falls to its rated power, then ends",
    equation="traction <= T(w) i/r, w = v i/r: T = T_max to w_1, linear to P/w_2 at w_2, P/w above, 0 above w_max",
    source="data sheet of the motor; TABBY EVO: 128 N m at 500 rpm, 29.5 kW at 2500 rpm, 5500 rpm, 5.8:1",
    parameters=(
        Key("torque", "N m", 20.0, 500.0, neutral=inf, least=2.0, minimum=0.0, meaning="greatest torque T_max"),
        Key("corner_speed", "rad/s", 10.0, 300.0, neutral=0.0, least=5.0, minimum=0.0, meaning="w_1"),
        Key("power", "W", 3e3, 2e5, neutral=inf, least=500.0, minimum=0.0, meaning="rated power P"),
        Key("rated_speed", "rad/s", 50.0, 600.0, neutral=0.0, least=10.0, minimum=0.0, meaning="w_2, where P begins"),
        Key("max_speed", "rad/s", 100.0, 2000.0, neutral=inf, least=10.0, minimum=0.0, meaning="w_max"),
    ),
    ties=("power_limit",),
    reveals="full acceleration from standstill to the highest speed allowed",
    shown_by=ShownBy(80, (DRIVE, SPEED), (ACCELERATES,)),
    diagnosed=Diagnosed(needs="drive_train"),
)
def motor_torque(x: Bus, p: Any, m: Any) -> None:
    ratio = x.gear_ratio / x.wheel_radius
    speed = x.vx * ratio
    most = p.torque
    if speed > p.max_speed:
        most = 0.0
    elif speed >= p.rated_speed and speed > 0.0:
        most = min(most, p.power / speed)
    elif speed > p.corner_speed:
        share = (speed - p.corner_speed) / (p.rated_speed - p.corner_speed)
        most += share * (min(p.power / p.rated_speed, most) - most)
    if x.traction > most * ratio:
        x.traction = most * ratio
        x.accel_lead = 0.0
