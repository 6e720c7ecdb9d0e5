"""First-order lag of the drive."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.step_maths import lag


@effect(
    name="drive_lag",
    slot="actuator",
    order=10,
    physics="motor current and driveline build the wanted acceleration up gradually",
    equation="tau a' = a_c - a",
    source="R. Rajamani, Vehicle Dynamics and Control, 2nd ed., eq. 5.7",
    parameters=(Key("tau", "s", 0.1, 0.8, neutral=0.0, least=0.03, minimum=0.0, meaning="time constant"),),
    memory=(Memory("a"),),
    ties=("drive_delay", "jerk_limit"),
    reveals="steps of the acceleration command, each held for 2 s",
)
def drive_lag(x: Bus, p: Any, m: Any) -> None:
    start = m.a
    if p.tau <= 0.0:
        m.a = x.accel - x.accel_lead
        return
    x.accel, m.a = lag(start, x.accel, x.accel_lead, p.tau, x.dt)
    x.accel_lead = start - x.accel
