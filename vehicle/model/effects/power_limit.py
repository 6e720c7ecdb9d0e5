"""Power limit of the drive."""

from __future__ import annotations

from math import inf
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import DRIVE, SPEED, ShownBy


@effect(
    name="power_limit",
    slot="force",
    order=60,
    physics="at speed the drive runs out of power, not of force",
    equation="traction <= P/(m v)",
    source="M. Mitschke, H. Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed., sec. 3",
    parameters=(Key("limit", "W/kg", 3.0, 40.0, neutral=inf, least=0.5, minimum=0.0, meaning="power over mass"),),
    ties=("drive_gain",),
    reveals="full acceleration from standstill to the highest speed allowed",
    shown_by=ShownBy(
        140,
        (DRIVE, SPEED),
        (("power_wanted", 3.0, "acceleration * speed of 3 W/kg"),),
        usual=(("power_wanted", 11.0, "acceleration * speed of 11 W/kg"),),
    ),
    diagnosed=Diagnosed(hides_in=(("EGO_dr_full_throttle", 50),), seen_as=(("drive_gain", "speed"), ("mass", "speed"))),
)
def power_limit(x: Bus, p: Any, m: Any) -> None:
    if x.traction * x.vx > p.limit * x.mass_ref:
        x.traction = p.limit * x.mass_ref / x.vx
        x.accel_lead = 0.0
