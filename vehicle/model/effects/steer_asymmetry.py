"""Different scale to the left and to the right."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import STEER, TURN, ShownBy


@effect(
    name="steer_asymmetry",
    slot="command",
    order=30,
    physics="rack, linkage or sensor are not symmetrical",
    equation="d = g_left d_c for d_c > 0, g_right d_c else",
    source="ratio of the steering linkage",
    parameters=(
        Key("g_left", "-", 0.7, 1.3, neutral=1.0, least=0.01, minimum=0.0, meaning="scale to the left"),
        Key("g_right", "-", 0.7, 1.3, neutral=1.0, least=0.01, minimum=0.0, meaning="scale to the right"),
    ),
    ties=(
        "steer_ratio",
        "steer_offset",
    ),
    reveals="steady circles to both sides at 3 m/s",
    shown_by=ShownBy(
        310,
        (STEER, TURN),
        (("turn_left", 0.05, "left curves of 0.05 rad/s"), ("turn_right", 0.05, "right curves of 0.05 rad/s")),
    ),
    diagnosed=Diagnosed(contains="steer_ratio", scaled_by=(("steer_scale", "g_left"),)),
)
def steer_asymmetry(x: Bus, p: Any, m: Any) -> None:
    g = p.g_left if x.steer > 0.0 else p.g_right
    x.steer *= g
    x.steer_lead *= g
