"""Extra first-order lag of the brake."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.shown_by import BRAKE, BRAKES, CHANGES_COMMAND, SPEED, ShownBy
from vehicle.model.step_maths import lag


@effect(
    name="brake_lag",
    slot="actuator",
    order=20,
    physics="brake pressure builds up gradually; it is released at once",
    equation="tau a' = a_c - a while a_c < 0, from a = 0",
    source="B. Breuer, K. Bill (eds.), Brake Technology Handbook, sec. 3.2 (build-up time)",
    parameters=(Key("tau", "s", 0.1, 0.8, neutral=0.0, least=0.03, minimum=0.0, meaning="time constant"),),
    memory=(Memory("a"),),
    ties=("drive_lag", "jerk_limit"),
    reveals="brake steps of several sizes from 8 m/s, beside equal steps of the drive",
    shown_by=ShownBy(110, (BRAKE, SPEED), (BRAKES, CHANGES_COMMAND)),
    diagnosed=Diagnosed(hides_in=(("BRAKE_kp", 10), ("BRAKE_ki", 10))),
)
def brake_lag(x: Bus, p: Any, m: Any) -> None:
    start = m.a
    m.a = min(x.accel - x.accel_lead, 0.0)
    if x.accel < 0.0 < p.tau:
        x.accel, m.a = lag(start, x.accel, x.accel_lead, p.tau, x.dt)
        x.accel_lead = start - x.accel
