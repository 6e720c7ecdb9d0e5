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
    equation="tau y' = u - y, u = max(a_c, 0) + brakes min(a_c, 0), a = y + (1 - brakes) min(a_c, 0)",
    source="R. Rajamani, Vehicle Dynamics and Control, 2nd ed., eq. 5.7",
    parameters=(
        Key("tau", "s", 0.1, 0.8, neutral=0.0, least=0.03, minimum=0.0, meaning="time constant"),
        Key(
            "brakes",
            "-",
            0.0,
            1.0,
            neutral=1.0,
            least=0.1,
            minimum=0.0,
            maximum=1.0,
            meaning="share of a braking command that comes late, too; 0 where the brake is apart from the motor",
        ),
    ),
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
    if p.brakes >= 1.0:
        x.accel, m.a = lag(start, x.accel, x.accel_lead, p.tau, x.dt)
        x.accel_lead = start - x.accel
        return
    share = 1.0 if x.accel > 0.0 else p.brakes
    at_once, its_lead = (1.0 - share) * x.accel, (1.0 - share) * x.accel_lead
    mean, m.a = lag(start, share * x.accel, share * x.accel_lead, p.tau, x.dt)
    x.accel, x.accel_lead = mean + at_once, start - mean + its_lead
