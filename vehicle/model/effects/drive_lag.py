"""First-order lag of the drive."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.maths import lag_end, lag_mean


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
    end = lag_end(m.a, x.accel, p.tau, x.dt)
    x.accel = lag_mean(m.a, end, x.accel, p.tau, x.dt)
    m.a = end
