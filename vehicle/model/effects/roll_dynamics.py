"""Steering by body roll."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.shown_by import CURVES, STEER, TURN, ShownBy
from vehicle.model.step_maths import held_across, lag


@effect(
    name="roll_dynamics",
    slot="body",
    order=40,
    tyres=True,
    physics="the body rolls with a lag, and rolling turns the front wheels outwards (phi: roll over roll at 1 g)",
    equation="d = d_c - gain phi, tau phi' = v r/g + sin(bank) - phi",
    source="J. C. Dixon, Suspension Geometry and Computation (roll steer coefficient)",
    parameters=(
        Key(
            "gain",
            "-",
            0.0,
            0.3,
            neutral=0.0,
            least=0.02,
            minimum=-1.0,
            maximum=1.0,
            meaning="steer angle per g of lateral acceleration",
        ),
        Key("tau", "s", 0.05, 0.5, neutral=0.0, least=0.05, minimum=0.0, meaning="lag of the roll angle"),
    ),
    memory=(Memory("phi"), Memory("begun")),
    ties=(
        "understeer",
        "tyre_relaxation",
    ),
    reveals="lane changes and steady circles at 10 m/s",
    shown_by=ShownBy(400, (STEER, TURN), (CURVES, ("steer_rate", 0.1, "steering by 0.1 rad/s"))),
)
def roll_dynamics(x: Bus, p: Any, m: Any) -> None:
    target = held_across(x)
    if m.begun == 0.0:
        m.begun, m.phi = 1.0, target
    phi = target
    if p.tau > 0.0:
        phi, m.phi = lag(m.phi, target, 0.0, p.tau, x.dt)
    given = p.gain * phi
    x.steer -= given
    x.slip_front -= given
    x.fy_front -= given * x.tangent_front
