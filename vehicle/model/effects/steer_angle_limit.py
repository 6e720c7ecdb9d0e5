"""End stops of the steering."""

from __future__ import annotations

from math import inf
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import COMMAND, TURN, TURNS, ShownBy
from vehicle.model.step_maths import clip


@effect(
    name="steer_angle_limit",
    slot="actuator",
    order=5,  # before lag and rate limit, so that they do not wind up beyond the stop
    physics="the road wheels reach their end stops",
    equation="abs(d) <= d_m",
    source="geometry of the steering linkage",
    parameters=(
        Key("limit", "rad", 0.08, 0.6, neutral=inf, least=0.01, minimum=0.0, maximum=1.5, meaning="greatest angle"),
    ),
    ties=("steer_ratio",),
    reveals="slow full-lock turns to both sides",
    shown_by=ShownBy(
        270,
        (COMMAND, TURN),
        (("steer_angle", 0.08, "0.08 rad at the road wheel"), TURNS),
        usual=(("steer_angle", 0.2, "0.2 rad at the road wheel"),),
    ),
    diagnosed=Diagnosed(hides_in=(("EGO_max_steer_angle", 10),)),
)
def steer_angle_limit(x: Bus, p: Any, m: Any) -> None:
    start = clip(x.steer + x.steer_lead, -p.limit, p.limit)
    if abs(x.steer) + abs(x.steer_lead) > p.limit:
        x.steer = 0.5 * (start + clip(x.steer - x.steer_lead, -p.limit, p.limit))
        x.steer_lead = start - x.steer
