"""Greatest rate of the steering."""

from __future__ import annotations

from math import inf
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.shown_by import COMMAND, TURN, TURNS, ShownBy
from vehicle.model.step_maths import limit_rate


@effect(
    name="steer_rate_limit",
    slot="actuator",
    order=30,
    physics="the steering motor turns no faster than its top speed",
    equation="abs(d') <= rho",
    source="Autoware simple planning simulator, steer_rate_lim",
    parameters=(Key("limit", "rad/s", 0.05, 1.0, neutral=inf, least=0.02, minimum=0.0, meaning="greatest rate"),),
    memory=(Memory("d", start="steer"),),
    ties=("steer_lag",),
    reveals="steering steps of growing size at 3 m/s",
    shown_by=ShownBy(
        260,
        (COMMAND, TURN),
        (("steer_rate", 0.05, "steering by 0.05 rad/s"), TURNS),
        usual=(("steer_rate", 0.2, "steering by 0.2 rad/s"),),
    ),
)
def steer_rate_limit(x: Bus, p: Any, m: Any) -> None:
    start = m.d
    if p.limit == inf:
        m.d = x.steer - x.steer_lead
        return
    x.steer, m.d = limit_rate(start, x.steer, x.steer_lead, p.limit, x.dt)
    x.steer_lead = start - x.steer
    x.steer_glides = 1.0
