"""Scale of the steering."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import STEER, TURN, TURNS, ShownBy


@effect(
    name="steer_ratio",
    slot="command",
    order=20,
    physics="gear ratio or wheelbase differ from what the command assumes",
    equation="d = g d_c",
    source="ratio of the steering linkage",
    parameters=(
        Key("g", "-", 0.7, 1.3, neutral=1.0, least=0.01, minimum=0.0, meaning="road-wheel angle over commanded angle"),
    ),
    ties=(
        "understeer",
        "steer_asymmetry",
    ),
    reveals="steady circles at 2 and at 10 m/s, both sides",
    shown_by=ShownBy(300, (STEER, TURN), (TURNS,)),
    diagnosed=Diagnosed(input_scales=("steer_scale",), hides_in=(("EGO_max_steer_angle", 20),)),
)
def steer_ratio(x: Bus, p: Any, m: Any) -> None:
    x.steer *= p.g
    x.steer_lead *= p.g
