"""Resistance in proportion to speed."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, effect


@effect(
    name="viscous_resistance",
    slot="force",
    physics="bearings, lubricant and motor resist in proportion to speed",
    equation="a = -c v",
    source="J. Y. Wong, Theory of Ground Vehicles, 4th ed.",
    parameters=(Key("c", "1/s", 0.005, 1.0, neutral=0.0, least=0.005, minimum=0.0, meaning="deceleration over speed"),),
    ties=(
        "aero_drag",
        "motor_damping",
    ),
    reveals="coast down from the highest speed allowed to standstill",
)
def viscous_resistance(x: Bus, p: Any, m: Any) -> None:
    x.drag -= p.c * x.mass_ref * x.vx
