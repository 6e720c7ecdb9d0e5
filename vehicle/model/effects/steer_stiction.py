"""Sticking friction of the steering."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, Memory, effect


@effect(
    name="steer_stiction",
    slot="actuator",
    order=35,
    physics="the linkage does not move until the error is large enough",
    equation="d' = 0 while abs(d_c - d) < s",
    source="H. Olsson et al., Friction models and friction compensation, European J. of Control 4, 1998",
    parameters=(
        Key(
            "width", "rad", 0.002, 0.04, neutral=0.0, least=0.001, minimum=0.0, meaning="error that moves the linkage s"
        ),
    ),
    memory=(Memory("d", start="steer"),),
    ties=("steer_backlash",),
    reveals="slow steering ramps of small amplitude with reversals",
)
def steer_stiction(x: Bus, p: Any, m: Any) -> None:
    start = x.steer + x.steer_lead
    if abs(start - m.d) < p.width:
        start = m.d
    end = x.steer - x.steer_lead
    if abs(end - start) < p.width:
        end = start
    if p.width > 0.0:
        x.steer = 0.5 * (start + end)
        x.steer_lead = start - x.steer
    m.d = end
