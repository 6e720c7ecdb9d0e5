"""Rise of the force at the road."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.shown_by import ACCELERATES, CHANGES_COMMAND, DRIVE, SPEED, ShownBy
from vehicle.model.step_maths import lag


@effect(
    name="force_rise",
    slot="actuator",
    order=95,  # after what asks for the force
    physics="wheels spin up and tyres slip before they push or brake: some milliseconds, more with a motor",
    equation="tau a' = a_c - a, of drive and brake alike",
    source="H. B. Pacejka, Tire and Vehicle Dynamics, 3rd ed. (wheel of inertia I, slip stiffness C: lag I v/(C R^2))",
    parameters=(
        Key(
            "tau",
            "s",
            0.001,
            0.04,
            neutral=0.0,
            least=0.0005,
            minimum=0.0,
            maximum=0.05,
            meaning="time constant; a longer one is a drive_lag",
        ),
    ),
    memory=(Memory("a"),),
    ties=("drive_delay", "drive_lag", "brake_lag", "jerk_limit"),
    reveals="steps of the acceleration command of both signs, logged at 50 Hz or more",
    shown_by=ShownBy(30, (DRIVE, SPEED), (ACCELERATES, CHANGES_COMMAND)),
    diagnosed=Diagnosed(details="drive_lag", hides_in=(("EGO_mass", 60),)),
)
def force_rise(x: Bus, p: Any, m: Any) -> None:
    start = m.a if x.vx != 0.0 else max(m.a, 0.0)  # brakes hold a car that stands with no force at all
    if p.tau <= 0.0:
        m.a = x.accel - x.accel_lead
        return
    x.accel, m.a = lag(start, x.accel, x.accel_lead, p.tau, x.dt)
    x.accel_lead = start - x.accel
