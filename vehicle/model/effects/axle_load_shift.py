"""Axle loads that move when the car brakes or accelerates, and the cornering stiffness with them."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import GRAVITY, Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import ACCELERATES, BRAKES, CURVES, STEER, TURN, ShownBy
from vehicle.model.step_maths import spin_up


@effect(
    name="axle_load_shift",
    slot="body",
    order=25,
    tyres=True,
    physics="braking loads the front axle and frees the rear one, whose tyres then hold less: the car turns in more",
    equation="C_front = C_0 (1 - c a L/(g l_r)), C_rear = C_0 (1 + c a L/(g l_f)), what tyres hold at most likewise, "
    "a: what the wheels push along over mass, less what speeds turning parts up",
    source="M. Mitschke, H. Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed., sec. 25 (braking in a turn)",
    parameters=(
        Key(
            "c",
            "-",
            0.0,
            0.5,
            neutral=0.0,
            least=0.02,
            minimum=0.0,
            maximum=1.0,
            meaning="height over wheelbase, times how far stiffness follows load",
        ),
    ),
    ties=(
        "understeer",
        "load_transfer",
    ),
    reveals="a steady curve in which the car first accelerates and then brakes",
    shown_by=ShownBy(355, (STEER, TURN), (CURVES, BRAKES), usual=(ACCELERATES,)),
    diagnosed=Diagnosed(details="understeer"),
)
def axle_load_shift(x: Bus, p: Any, m: Any) -> None:
    held = x.brake + x.resistance
    along = x.traction - spin_up(x) - (held if x.vx >= 0.0 else -held)
    shift = p.c * along / x.mass / GRAVITY * x.wheelbase
    x.load_front = front = min(max(1.0 - shift / x.cg_rear, 0.2), 1.8)
    x.load_rear = rear = min(max(1.0 + shift / x.cg_front, 0.2), 1.8)
    x.fy_front *= front
    x.tangent_front *= front
    x.fy_rear *= rear
    x.tangent_rear *= rear
