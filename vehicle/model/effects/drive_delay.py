"""Dead time of the drive: the wanted acceleration arrives late."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.maths import DELAY_LINE, delayed


@effect(
    name="drive_delay",
    slot="command",
    order=80,
    physics="bus, controller and inverter pass the acceleration command on after a dead time",
    equation="a(t) = a_c(t - T)",
    source="R. Rajamani, Vehicle Dynamics and Control, 2nd ed., sec. 5.3",
    parameters=(Key("T", "s", 0.05, 0.5, neutral=0.0, least=0.02, minimum=0.0, maximum=1.0, meaning="dead time"),),
    memory=(Memory("head"), Memory("ring", DELAY_LINE)),
    delay="T",
    ties=("drive_lag", "jerk_limit"),
    reveals="steps of the acceleration command, each held for 2 s",
)
def drive_delay(x: Bus, p: Any, m: Any) -> None:
    head = int(m.head)
    x.accel = delayed(m.ring, head, x.accel, p.T, x.dt)
    m.head = (head + 1) % DELAY_LINE
