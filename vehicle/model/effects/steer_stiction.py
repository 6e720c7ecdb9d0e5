"""Sticking friction of the steering."""

from __future__ import annotations

from math import copysign
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.shown_by import COMMAND, TURN, TURNS, ShownBy
from vehicle.model.step_maths import clip


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
    shown_by=ShownBy(280, (COMMAND, TURN), (("steer_reversals", 6.0, "6 reversals of the steering"), TURNS)),
    diagnosed=Diagnosed(grid_points=60),
)
def steer_stiction(x: Bus, p: Any, m: Any) -> None:
    start, end = x.steer + x.steer_lead, x.steer - x.steer_lead
    if p.width <= 0.0:
        m.d = end
        return
    if abs(start - m.d) >= p.width:
        m.d = start
    start = m.d
    if x.steer_glides == 0.0:  # a command that jumps within the step
        if abs(end - start) >= p.width:
            m.d = end
        x.steer = 0.5 * (start + m.d)
    else:  # one that moves on straight drags the linkage along in jumps of s, each time it is s ahead
        ahead = x.steer + x.steer_lead - start
        s, mean = copysign(p.width, end - start), start
        for k in range(int(abs(end - start) / p.width + 1e-9)):
            gone = (ahead - (k + 1) * s) / (2.0 * x.steer_lead)  # share of the step before this jump
            mean += s * (1.0 - clip(gone, 0.0, 1.0))
            m.d += s
        x.steer = mean
    x.steer_lead = start - x.steer
