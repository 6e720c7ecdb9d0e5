"""Drag of turning tyres."""

from __future__ import annotations

from math import sin
from typing import Any

from vehicle.model.bus import GRAVITY, Bus
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import CURVES, DRIVE, SPEED, TURN, ShownBy


@effect(
    name="cornering_drag",
    slot="force",
    physics="in turns the lateral tyre forces have a part that points backward",
    equation="a = -c abs(v r + g sin(bank))",
    source="M. Mitschke, H. Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed. (curve resistance)",
    parameters=(
        Key(
            "c", "-", 0.02, 0.5, neutral=0.0, least=0.01, minimum=0.0, meaning="deceleration over lateral acceleration"
        ),
    ),
    ties=("rolling_resistance",),
    reveals="steady circles at constant command and growing speed",
    shown_by=ShownBy(210, (DRIVE, SPEED, TURN), (CURVES,)),
)
def cornering_drag(x: Bus, p: Any, m: Any) -> None:
    held = x.vx * x.vx * x.curvature + GRAVITY * sin(x.bank)
    if x.push != 0.0:  # what the wind pushes, the tyres hold against
        held -= x.push / x.mass
    x.resistance += p.c * x.mass * abs(held)
