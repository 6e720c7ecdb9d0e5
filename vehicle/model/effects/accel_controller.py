"""Acceleration controller of the drive-by-wire unit."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.shown_by import ACCELERATES, CHANGES_COMMAND, DRIVE, SPEED, ShownBy
from vehicle.model.step_maths import lag_end


@effect(
    name="accel_controller",
    slot="command",
    order=40,
    physics="the drive-by-wire unit corrects its pedals by the acceleration it measures, apart for throttle and brake",
    equation="a = a_c + kp e + ki int(e), e = a_c - a_m, a_m = dv/dt, filtered with 0.05 s; 0 at standstill",
    source="K. J. Astrom, R. M. Murray, Feedback Systems, sec. 10.1 (PI)",
    parameters=(
        Key("kp_drive", "-", 0.0, 2.0, neutral=0.0, least=0.02, minimum=0.0, meaning="kp while a_c > 0"),
        Key("ki_drive", "1/s", 0.0, 1.0, neutral=0.0, least=0.005, minimum=0.0, meaning="ki while a_c > 0"),
        Key("kp_brake", "-", 0.0, 2.0, neutral=0.0, least=0.02, minimum=0.0, meaning="kp while a_c <= 0"),
        Key("ki_brake", "1/s", 0.0, 1.0, neutral=0.0, least=0.005, minimum=0.0, meaning="ki while a_c <= 0"),
    ),
    memory=(Memory("v"), Memory("a"), Memory("sum"), Memory("dt")),
    ties=("drive_gain", "brake_gain"),
    reveals="acceleration steps uphill and downhill",
    shown_by=ShownBy(50, (DRIVE, SPEED), (ACCELERATES, CHANGES_COMMAND)),
    diagnosed=Diagnosed(needs="drive_train"),
)
def accel_controller(x: Bus, p: Any, m: Any) -> None:
    if x.settle > 0.0:
        m.v, m.a, m.dt = x.vx, x.accel, 0.0
        return
    if m.dt > 0.0:  # a replay that gives the car another speed accelerates nothing
        reached = x.old_vx if x.moved > 0.0 else x.vx
        m.a = lag_end(m.a, (reached - m.v) / m.dt, 0.05, m.dt)
    m.v, m.dt = x.vx, x.dt
    wanted = x.accel
    if wanted <= 0.0 and x.vx <= 0.0:  # standing: nothing to correct
        m.sum = 0.0
        return
    kp, ki = (p.kp_drive, p.ki_drive) if wanted > 0.0 else (p.kp_brake, p.ki_brake)
    error = wanted - m.a
    m.sum += ki * error * x.dt
    x.accel = wanted + kp * error + m.sum
