"""Rolling resistance."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import DRIVE, DRIVES_10_S, SPEED, SPEEDS_3_APART, SPEEDS_APART, ShownBy


@effect(
    name="rolling_resistance",
    slot="force",
    physics="tyre deformation resists motion independently of speed",
    equation="a = -c when moving",
    source="M. Mitschke, H. Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed., sec. 2.1; c = f_R g",
    parameters=(Key("c", "m/s^2", 0.05, 0.4, neutral=0.0, least=0.02, minimum=0.0, meaning="deceleration"),),
    ties=("road_grade", "lift_off_braking"),
    reveals="coast down from 8 m/s to standstill, in both directions of the road",
    shown_by=ShownBy(170, (DRIVE, SPEED), (DRIVES_10_S, SPEEDS_APART), usual=(SPEEDS_3_APART,)),
    diagnosed=Diagnosed(hides_in=(("EGO_dr_full_throttle", 10), ("EGO_dr_zero_throttle", 30))),
)
def rolling_resistance(x: Bus, p: Any, m: Any) -> None:
    x.resistance += p.c * x.mass
