"""Greatest deceleration of the brake."""

from __future__ import annotations

from math import inf
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import BRAKE, SPEED, ShownBy


@effect(
    name="brake_limit",
    slot="actuator",
    order=70,
    physics="brake torque or tyre grip ends the growth of deceleration",
    equation="a >= -b",
    source="M. Mitschke, H. Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed., sec. 8",
    parameters=(Key("limit", "m/s^2", 1.0, 9.0, neutral=inf, least=0.1, minimum=0.0, meaning="greatest deceleration"),),
    ties=("brake_gain",),
    reveals="brake steps of growing size up to the full command",
    shown_by=ShownBy(
        130,
        (BRAKE, SPEED),
        (("braking_wanted", 1.0, "braking by 1 m/s^2"),),
        usual=(("braking_wanted", 3.0, "braking by 3 m/s^2"),),
    ),
    diagnosed=Diagnosed(seen_as=(("brake_gain", "acceleration"),)),
)
def brake_limit(x: Bus, p: Any, m: Any) -> None:
    if x.accel - abs(x.accel_lead) < -p.limit:
        start = max(x.accel + x.accel_lead, -p.limit)
        x.accel = 0.5 * (start + max(x.accel - x.accel_lead, -p.limit))
        x.accel_lead = start - x.accel
