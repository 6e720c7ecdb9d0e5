"""Steering that sticks after a standstill."""

from __future__ import annotations

from math import copysign
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.shown_by import COMMAND, MOVES_WHEEL, TURN, TURNS, ShownBy

STANDS = 0.05  # m/s, tyres that roll slower than that stick to the ground


@effect(
    name="steer_sticking",
    slot="actuator",
    order=37,
    physics="a car that came to a standstill keeps its wheels until the command is far enough off; then they are free",
    equation="d = d_s from a standstill (v < 0.05 m/s) on until abs(d_c - d_s) >= width, then d = d_c to the next one",
    source="H. Olsson et al., Friction models and friction compensation, European J. of Control 4, 1998 (break-away)",
    parameters=(
        Key(
            "width",
            "rad",
            0.01,
            0.2,
            neutral=0.0,
            least=0.003,
            minimum=0.0,
            meaning="difference of command and wheel that breaks it away",
        ),
    ),
    memory=(Memory("d", start="steer"), Memory("stuck"), Memory("stood")),
    ties=(
        "steer_stiction",
        "steer_backlash",
        "steer_delay",
    ),
    reveals="several starts from a standstill with slow steering from the first metre on",
    shown_by=ShownBy(285, (COMMAND, TURN), (MOVES_WHEEL, TURNS)),
    diagnosed=Diagnosed(details="steer_stiction", grid_points=12),
)
def steer_sticking(x: Bus, p: Any, m: Any) -> None:
    start, end = x.steer + x.steer_lead, x.steer - x.steer_lead
    if p.width <= 0.0 or x.settle > 0.0:
        m.d = end
        return
    stands = abs(x.vx) < STANDS
    if stands and m.stood == 0.0:
        m.stuck = 1.0
    m.stood = 1.0 if stands else 0.0
    if m.stuck == 0.0 or abs(start - m.d) >= p.width:
        m.stuck = 0.0
        m.d = end
        return
    x.steer, x.steer_lead = m.d, 0.0
    if abs(end - m.d) >= p.width:  # it breaks away within the step
        away = m.d + copysign(p.width, end - m.d)
        late = 0.5 if x.steer_glides == 0.0 else (away - start) / (end - start)  # share of the step before that
        mean = end if x.steer_glides == 0.0 else 0.5 * (away + end)
        x.steer = late * m.d + (1.0 - late) * mean
        x.steer_lead = m.d - x.steer
        m.stuck, m.d = 0.0, end
