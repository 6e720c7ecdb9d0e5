"""Scale of the steering."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, effect


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
)
def steer_ratio(x: Bus, p: Any, m: Any) -> None:
    x.steer *= p.g
    x.steer_lead *= p.g
