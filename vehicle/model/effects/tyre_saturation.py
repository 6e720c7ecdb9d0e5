"""Saturation of the tyres' lateral force."""

from __future__ import annotations

from math import inf, sqrt
from typing import Any

from vehicle.model.bus import GRAVITY, Bus
from vehicle.model.effect import Key, effect


@effect(
    name="tyre_saturation",
    slot="body",
    order=60,
    tyres=True,
    fine=True,
    physics="lateral force levels off at friction times load",
    equation="F = F_lin / sqrt(1 + (F_lin/F_max)^2), F_max = limit/g x axle load",
    source="smooth form of the saturated linear tyre, H. B. Pacejka, Tire and Vehicle Dynamics, 3rd ed., sec. 1.3",
    parameters=(
        Key("limit", "m/s^2", 2.0, 12.0, neutral=inf, least=0.2, minimum=0.1, meaning="greatest lateral acceleration"),
    ),
    ties=("understeer",),
    reveals="steady turns of growing lateral acceleration",
)
def tyre_saturation(x: Bus, p: Any, m: Any) -> None:
    load = x.mass * GRAVITY / x.wheelbase
    front = p.limit / GRAVITY * load * x.cg_rear
    rear = p.limit / GRAVITY * load * x.cg_front
    qf, qr = x.fy_front / front, x.fy_rear / rear
    sf, sr = 1.0 / sqrt(1.0 + qf * qf), 1.0 / sqrt(1.0 + qr * qr)
    x.fy_front *= sf
    x.fy_rear *= sr
    x.tangent_front *= sf * sf * sf
    x.tangent_rear *= sr * sr * sr
