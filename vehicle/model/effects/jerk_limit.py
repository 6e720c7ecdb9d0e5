"""Greatest rate of the acceleration."""

from __future__ import annotations

from math import inf
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.shown_by import ACCELERATES, CHANGES_COMMAND, DRIVE, SPEED, ShownBy
from vehicle.model.step_maths import limit_rate


@effect(
    name="jerk_limit",
    slot="actuator",
    order=40,
    physics="the drive controller ramps its torque to spare driveline and passengers",
    equation="abs(a') <= j",
    source="ISO 15622 (limits of the rate of acceleration)",
    parameters=(Key("limit", "m/s^3", 1.0, 10.0, neutral=inf, least=0.2, minimum=0.0, meaning="greatest rate"),),
    memory=(Memory("a"),),
    ties=(
        "drive_lag",
        "drive_delay",
    ),
    reveals="acceleration steps of growing size, both signs",
    shown_by=ShownBy(40, (DRIVE, SPEED), (ACCELERATES, CHANGES_COMMAND)),
    diagnosed=Diagnosed(hides_in=(("EGO_mass", 30), ("EGO_moi", 40))),
)
def jerk_limit(x: Bus, p: Any, m: Any) -> None:
    start = m.a
    if p.limit == inf:
        m.a = x.accel - x.accel_lead
        return
    x.accel, m.a = limit_rate(start, x.accel, x.accel_lead, p.limit, x.dt)
    x.accel_lead = start - x.accel
