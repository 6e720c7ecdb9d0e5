"""Steady wind from ahead."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import DRIVE, SPEED, TURNS_AROUND, ShownBy


@effect(
    name="headwind",
    slot="force",
    physics="drag depends on the speed through the air, not over ground",
    equation="a = -k (v + w) abs(v + w) + k v abs(v)",
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
    ),
    ties=(
        "aero_drag",
        "viscous_resistance",
        "rolling_resistance",
    ),
    reveals="the same straight at two constant speeds, in both directions",
    shown_by=ShownBy(200, (DRIVE, SPEED), (("speed", 5.0, "5 m/s"), TURNS_AROUND), usual=(("speed", 10.0, "10 m/s"),)),
)
def headwind(x: Bus, p: Any, m: Any) -> None:
    air = x.vx + p.speed
    x.drag -= p.k * x.mass * (air * abs(air) - x.vx * abs(x.vx))
