"""Steady wind."""

from __future__ import annotations

from math import cos, inf
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import DRIVE, SPEED, TURNS_AROUND, ShownBy


@effect(
    name="headwind",
    slot="force",
    physics="drag depends on the speed through the air, not over ground",
    equation="a = -k (v + u) abs(v + u) + k v abs(v), u = w cos(yaw - heading), without heading u = w",
    source="SAE J1263 (wind correction of coast-down tests)",
    parameters=(
        Key(
            "speed",
            "m/s",
            -12.0,
            12.0,
            neutral=0.0,
            least=0.5,
            minimum=-40.0,
            maximum=40.0,
            meaning="wind against the car w",
        ),
        Key(
            "k",
            "1/m",
            0.0002,
            0.02,
            neutral=0.0,
            least=0.0002,
            minimum=0.0,
            meaning="drag over speed squared, as aero_drag",
        ),
        Key(
            "heading",
            "rad",
            -3.15,
            3.15,
            neutral=inf,
            least=0.1,
            meaning="direction the wind comes from; without it, always from ahead",
        ),
    ),
    ties=(
        "aero_drag",
        "viscous_resistance",
        "rolling_resistance",
    ),
    reveals="the same straight at two constant speeds, in both directions",
    shown_by=ShownBy(200, (DRIVE, SPEED), (("speed", 5.0, "5 m/s"), TURNS_AROUND), usual=(("speed", 10.0, "10 m/s"),)),
    diagnosed=Diagnosed(held=("heading",), surroundings=True),
)
def headwind(x: Bus, p: Any, m: Any) -> None:
    ahead = p.speed if p.heading == inf else p.speed * cos(x.yaw - p.heading)
    air = x.vx + ahead
    x.drag -= p.k * x.mass_ref * (air * abs(air) - x.vx * abs(x.vx))
