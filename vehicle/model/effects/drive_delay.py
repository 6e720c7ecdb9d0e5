"""Dead time of the drive: the wanted acceleration arrives late."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import DELAY_MEMORY, Key, Memory, effect
from vehicle.model.shown_by import ACCELERATES, CHANGES_COMMAND, DRIVE, SPEED, ShownBy
from vehicle.model.step_maths import arrived, delayed


@effect(
    name="drive_delay",
    slot="command",
    order=80,
    physics="bus, controller and inverter pass the acceleration command on after a dead time",
    equation="a(t) = a_c(t - T)",
    source="R. Rajamani, Vehicle Dynamics and Control, 2nd ed., sec. 5.3",
    parameters=(Key("T", "s", 0.05, 0.5, neutral=0.0, least=0.02, minimum=0.0, maximum=1.0, meaning="dead time"),),
    memory=(*DELAY_MEMORY, Memory("before")),
    delay="T",
    ties=("drive_lag", "jerk_limit"),
    reveals="steps of the acceleration command, each held for 2 s",
    shown_by=ShownBy(10, (DRIVE, SPEED), (ACCELERATES, CHANGES_COMMAND)),
    diagnosed=Diagnosed(hides_in=(("EGO_mass", 20), ("THROTTLE_delay", 10))),
)
def drive_delay(x: Bus, p: Any, m: Any) -> None:
    x.accel, x.accel_lead = delayed(m, x.accel, x.accel_lead, p.T, x.t, x.dt)
    x.accel_jump, x.accel_arrived = x.accel_lead, arrived(m, p.T, x.t, x.dt)
