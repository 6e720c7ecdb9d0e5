"""Steering by body roll."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import GRAVITY, Bus
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.maths import lag_end

ROLL_PER_G = 0.1  # rad of body roll at 1 g of lateral acceleration, a common passenger car


@effect(
    name="roll_dynamics",
    slot="body",
    order=40,
    tyres=True,
    physics="the body rolls with a lag, and rolling turns the front wheels outwards",
    equation="d = d_c - gain phi, tau phi' = 0.1 rad ay/g - phi",
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
            meaning="steer angle over roll angle",
        ),
        Key("tau", "s", 0.05, 0.5, neutral=0.0, least=0.05, minimum=0.0, meaning="lag of the roll angle"),
    ),
    memory=(Memory("phi"), Memory("begun")),
    ties=(
        "understeer",
        "tyre_relaxation",
    ),
    reveals="lane changes and steady circles at 10 m/s",
)
def roll_dynamics(x: Bus, p: Any, m: Any) -> None:
    target = ROLL_PER_G * x.vx * x.yaw_rate / GRAVITY
    if m.begun == 0.0:
        m.begun, m.phi = 1.0, target
    m.phi = lag_end(m.phi, target, p.tau, x.dt)
    given = p.gain * m.phi
    x.steer -= given
    x.slip_front -= given
    x.fy_front -= given * x.tangent_front
