"""First-order lag of the steering."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.shown_by import COMMAND, MOVES_WHEEL, TURN, TURNS, ShownBy
from vehicle.model.step_maths import lag


@effect(
    name="steer_lag",
    slot="actuator",
    order=10,
    physics="the steering actuator follows its command with a time constant",
    equation="tau d' = d_c - d",
    source="Autoware simple planning simulator, steering with first-order lag (delay_steer_acc)",
    parameters=(Key("tau", "s", 0.05, 0.6, neutral=0.0, least=0.02, minimum=0.0, meaning="time constant"),),
    memory=(Memory("d", start="steer"),),
    ties=("steer_delay", "tyre_relaxation"),
    reveals="steps of the steering command of both signs at 5 m/s",
    # 0.2 s of 0.04 rad/s turn a car at 5 m/s by 0.015 rad/s.
    shown_by=ShownBy(
        250, (COMMAND, TURN), (MOVES_WHEEL, TURNS), usual=(("steer_rate", 0.04, "steering by 0.04 rad/s"),)
    ),
)
def steer_lag(x: Bus, p: Any, m: Any) -> None:
    start = m.d
    if p.tau <= 0.0:
        m.d = x.steer - x.steer_lead
        return
    x.steer, m.d = lag(start, x.steer, x.steer_lead, p.tau, x.dt)
    x.steer_lead = start - x.steer
    x.steer_glides = 1.0
