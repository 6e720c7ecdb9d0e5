"""Aerodynamic drag."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import DRIVE, SPEED, SPEEDS_3_APART, ShownBy


@effect(
    name="aero_drag",
    slot="force",
    physics="air resists with the square of speed",
    equation="a = -k v^2, k = rho c_d A / (2 m)",
    source="M. Mitschke, H. Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed., sec. 2.2",
    parameters=(Key("k", "1/m", 0.0002, 0.02, neutral=0.0, least=0.0001, minimum=0.0, meaning="drag over mass"),),
    ties=("viscous_resistance", "pedal_deadband"),
    reveals="coast down from the highest speed allowed",
    # 0.002 / m makes 0.2 m/s^2 at 10 m/s, and 0.02 / m half a m/s^2 at 5.
    shown_by=ShownBy(
        190, (DRIVE, SPEED), (("speed", 5.0, "5 m/s"), SPEEDS_3_APART), usual=(("speed", 10.0, "10 m/s"),)
    ),
    diagnosed=Diagnosed(hides_in=(("EGO_dr_full_throttle", 30),)),
)
def aero_drag(x: Bus, p: Any, m: Any) -> None:
    x.drag -= p.k * x.mass_ref * x.vx * abs(x.vx)
