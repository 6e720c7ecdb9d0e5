"""Scale of the steering that changes with speed."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import STEER, TURN, TURNS, ShownBy


@effect(
    name="steer_assist",
    slot="command",
    order=22,  # with steer_ratio
    physics="the steering gives another angle the faster the car is: variable ratio or weaker assistance",
    equation="d = d_c (1 + g v/(v + v0)), v = abs(v)",
    source="P. Pfeffer, M. Harrer (eds.), Steering Handbook (speed-dependent assistance, active front steering)",
    parameters=(
        Key(
            "g",
            "-",
            -0.5,
            0.5,
            neutral=0.0,
            least=0.02,
            minimum=-0.9,
            maximum=3.0,
            meaning="change of the scale at a speed far above v0",
        ),
        Key("v0", "m/s", 2.0, 20.0, neutral=8.0, least=1.0, minimum=0.1, meaning="speed of half the change"),
    ),
    ties=(
        "steer_ratio",
        "understeer",
        "steer_compliance",
    ),
    reveals="steady circles at 2, 5 and 10 m/s: understeer grows with v^2, this one levels off",
    shown_by=ShownBy(
        305, (STEER, TURN), (TURNS, ("speed", 2.0, "2 m/s")), usual=(("speed_range", 2.0, "speeds 2 m/s apart"),)
    ),
    diagnosed=Diagnosed(
        refines=("steer_ratio", "understeer"), seen_as=(("steer_ratio", "speed"), ("understeer", "speed"))
    ),
)
def steer_assist(x: Bus, p: Any, m: Any) -> None:
    if p.g != 0.0:
        v = abs(x.vx)
        gain = 1.0 + p.g * v / (v + p.v0)
        x.steer *= gain
        x.steer_lead *= gain
