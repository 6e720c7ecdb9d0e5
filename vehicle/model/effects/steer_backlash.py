"""Play of the steering."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.shown_by import COMMAND, TURN, TURNS, ShownBy
from vehicle.model.step_maths import clip


@effect(
    name="steer_backlash",
    slot="actuator",
    order=40,
    physics="gear and joints have play, or dry friction acts while the steering moves, which looks the same: after a "
    "reversal the wheels follow only once it is taken up",
    equation="d_c - b <= d <= d_c + b, d' = 0 inside",
    source="G. Tao, P. V. Kokotovic, Adaptive Control of Systems with Actuator and Sensor Nonlinearities",
    parameters=(
        Key("half_width", "rad", 0.002, 0.04, neutral=0.0, least=0.001, minimum=0.0, meaning="half the play b"),
    ),
    memory=(Memory("d", start="steer"),),
    ties=(
        "steer_stiction",
        "pedal_deadband",
    ),
    reveals="slow steering waves of small amplitude with many reversals",
    shown_by=ShownBy(290, (COMMAND, TURN), (("steer_reversals", 6.0, "6 reversals of the steering"), TURNS)),
)
def steer_backlash(x: Bus, p: Any, m: Any) -> None:
    start = clip(m.d, x.steer + x.steer_lead - p.half_width, x.steer + x.steer_lead + p.half_width)
    m.d = clip(start, x.steer - x.steer_lead - p.half_width, x.steer - x.steer_lead + p.half_width)
    if p.half_width > 0.0:
        x.steer = 0.5 * (start + m.d)
        x.steer_lead = start - x.steer
