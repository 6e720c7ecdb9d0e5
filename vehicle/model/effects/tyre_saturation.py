"""Saturation of the tyres' lateral force.

No friction circle: logs show the limit where tyres begin to level off, often far below what the same tyres brake with,
and a circle of it would take the steering away from a car that brakes. Brakes and drive have limits of their own; what
a road holds along and across together is its friction (`vehicle.model.road_hold`).
"""

from __future__ import annotations

from math import inf, tanh
from typing import Any

from vehicle.model.bus import GRAVITY, Bus
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import SHARP_CURVES, STEER, TURN, ShownBy


@effect(
    name="tyre_saturation",
    slot="body",
    order=60,
    tyres=True,
    fine=True,
    physics="lateral force levels off at a share of the load, whatever the tyres do along",
    equation="F = F_max tanh(F_lin/F_max), F_max = limit/g x axle load",
    source="the saturated linear tyre, H. B. Pacejka, Tire and Vehicle Dynamics, 3rd ed., sec. 1.3, made smooth",
    parameters=(
        Key("limit", "m/s^2", 2.0, 12.0, neutral=inf, least=0.2, minimum=0.1, meaning="greatest lateral acceleration"),
    ),
    ties=("understeer",),
    reveals="steady turns of growing lateral acceleration",
    shown_by=ShownBy(340, (STEER, TURN), (SHARP_CURVES,), usual=(("lateral_acceleration", 5.0, "curves of 5 m/s^2"),)),
)
def tyre_saturation(x: Bus, p: Any, m: Any) -> None:
    if p.limit == inf:
        return
    if x.road_friction > 0.0:  # the road cuts the force next: by one limit, the lower one, as two in a row hold less
        x.tyre_limit = p.limit
        return
    load = x.mass * GRAVITY / x.wheelbase
    front = p.limit / GRAVITY * load * x.cg_rear * x.load_front
    rear = p.limit / GRAVITY * load * x.cg_front * x.load_rear
    tf, tr = tanh(x.fy_front / front), tanh(x.fy_rear / rear)
    x.fy_front, x.fy_rear = front * tf, rear * tr
    x.tangent_front *= 1.0 - tf * tf
    x.tangent_rear *= 1.0 - tr * tr
