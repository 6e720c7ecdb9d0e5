"""Dead time of the steering."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import DELAY_MEMORY, Key, Memory, effect
from vehicle.model.shown_by import COMMAND, MOVES_WHEEL, TURN, TURNS, ShownBy
from vehicle.model.step_maths import delayed


@effect(
    name="steer_delay",
    slot="command",
    order=80,
    physics="bus and controller pass the steering command on after a dead time",
    equation="d(t) = d_c(t - T)",
    source="Autoware simple planning simulator, steering with delay (delay_steer_acc)",
    parameters=(Key("T", "s", 0.03, 0.5, neutral=0.0, least=0.02, minimum=0.0, maximum=1.0, meaning="dead time"),),
    memory=(*DELAY_MEMORY, Memory("before", start="steer")),
    delay="T",
    ties=("steer_lag", "tyre_relaxation", "yaw_rate_latency"),
    reveals="steps of the steering command of both signs at 5 m/s",
    # 0.2 s of 0.04 rad/s turn a car at 5 m/s by 0.015 rad/s.
    shown_by=ShownBy(
        240, (COMMAND, TURN), (MOVES_WHEEL, TURNS), usual=(("steer_rate", 0.04, "steering by 0.04 rad/s"),)
    ),
)
def steer_delay(x: Bus, p: Any, m: Any) -> None:
    x.steer, x.steer_lead = delayed(m, x.steer, x.steer_lead, p.T, x.t, x.dt)
