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
    physics="brake pressure builds up gradually, and is released at once or gradually, too, beside the drive",
    equation="tau a' = a_c - a while a_c < 0, from a = 0; then release tau b' = -b, a = a_c + b",
    source="B. Breuer, K. Bill (eds.), Brake Technology Handbook, sec. 3.2 (build-up time)",
    parameters=(
        Key("tau", "s", 0.1, 0.8, neutral=0.0, least=0.03, minimum=0.0, meaning="time constant of the build-up"),
        Key("release", "-", 0.0, 1.0, neutral=0.0, least=0.1, minimum=0.0, meaning="time constant of release over tau"),
    ),
    memory=(Memory("a"),),
    ties=("drive_lag", "jerk_limit"),
    reveals="brake steps of several sizes from 8 m/s, beside equal steps of the drive",
    shown_by=ShownBy(110, (BRAKE, SPEED), (BRAKES, CHANGES_COMMAND)),
    diagnosed=Diagnosed(hides_in=(("BRAKE_kp", 10), ("BRAKE_ki", 10))),
)
def brake_lag(x: Bus, p: Any, m: Any) -> None:
    start = m.a
    if p.tau <= 0.0:
        m.a = 0.0
    elif x.accel < 0.0:
        x.accel, m.a = lag(start, x.accel, x.accel_lead, p.tau, x.dt)
        x.accel_lead = start - x.accel
    elif p.release > 0.0 and start < 0.0:  # what is left of the brake acts against the drive
        fading, m.a = lag(start, 0.0, 0.0, p.release * p.tau, x.dt)
        x.accel += fading
        x.accel_lead += start - fading
    else:
        m.a = 0.0
