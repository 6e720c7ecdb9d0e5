"""First-order lag of the drive."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.shown_by import ACCELERATES, CHANGES_COMMAND, DRIVE, SPEED, ShownBy
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
    shown_by=ShownBy(20, (DRIVE, SPEED), (ACCELERATES, CHANGES_COMMAND)),
    diagnosed=Diagnosed(
        hides_in=(("EGO_mass", 10), ("EGO_moi", 20), ("THROTTLE_delay", 20), ("THROTTLE_kp", 10), ("THROTTLE_ki", 10))
    ),
)
def drive_lag(x: Bus, p: Any, m: Any) -> None:
    start = m.a
    if p.tau <= 0.0:
        m.a = x.accel - x.accel_lead
        return
    x.accel, m.a = lag(start, x.accel, x.accel_lead, p.tau, x.dt)
    x.accel_lead = start - x.accel
