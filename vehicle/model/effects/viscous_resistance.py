"""Resistance in proportion to speed."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import DRIVE, DRIVES_10_S, SPEED, SPEEDS_3_APART, SPEEDS_APART, ShownBy


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
    shown_by=ShownBy(180, (DRIVE, SPEED), (DRIVES_10_S, SPEEDS_APART), usual=(SPEEDS_3_APART,)),
    diagnosed=Diagnosed(hides_in=(("EGO_dr_full_throttle", 20), ("EGO_dr_zero_throttle", 20))),
)
def viscous_resistance(x: Bus, p: Any, m: Any) -> None:
    x.drag -= p.c * x.mass_ref * x.vx
