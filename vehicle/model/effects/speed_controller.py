"""Speed controller inside the car, for cars that take a speed as command."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.shown_by import SPEED, ShownBy


@effect(
    name="speed_controller",
    slot="command",
    order=10,
    physics="the car's own controller turns a wanted speed into a wanted acceleration",
    equation="a_c = kp e + ki int(e), e = speed_cmd - v as the car measures it",
    source="K. J. Astrom, R. M. Murray, Feedback Systems, sec. 10.1 (PI)",
    parameters=(
        Key("kp", "1/s", 0.1, 5.0, neutral=0.0, least=0.05, minimum=0.0, meaning="proportional gain"),
        Key("ki", "1/s^2", 0.0, 2.0, neutral=0.0, least=0.02, minimum=0.0, meaning="integral gain"),
    ),
    memory=(Memory("sum"),),
    ties=("drive_lag",),
    reveals="steps of the commanded speed up and down",
    shown_by=ShownBy(530, (("speed_cmd",), SPEED), (("speed_range", 1.0, "speeds 1 m/s apart"),)),
    diagnosed=Diagnosed(input="speed_cmd"),
)
def speed_controller(x: Bus, p: Any, m: Any) -> None:
    error = x.speed_cmd - x.speed_gain * x.vx
    start = p.kp * error + m.sum
    mean = start / (1.0 + 0.5 * p.kp * x.speed_gain * x.dt)  # the error shrinks during the step by what the car gains
    if x.settle == 0.0:
        m.sum += p.ki * (error - 0.5 * x.speed_gain * mean * x.dt) * x.dt
    x.accel += mean
    x.accel_lead += start - mean
