"""Aerodynamic drag."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, effect


@effect(
    name="aero_drag",
    slot="force",
    physics="air resists with the square of speed",
    equation="a = -k v^2, k = rho c_d A / (2 m)",
    source="M. Mitschke, H. Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed., sec. 2.2",
    parameters=(Key("k", "1/m", 0.0002, 0.02, neutral=0.0, least=0.0001, minimum=0.0, meaning="drag over mass"),),
    ties=("viscous_resistance", "pedal_deadband"),
    reveals="coast down from the highest speed allowed",
)
def aero_drag(x: Bus, p: Any, m: Any) -> None:
    x.drag -= p.k * x.mass_ref * x.vx * abs(x.vx)
