"""Elastic steering."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, effect


@effect(
    name="steer_compliance",
    slot="body",
    order=30,
    tyres=True,
    physics="column and bushings give way under the lateral force of the front axle",
    equation="d = d_c - c F_yf",
    source="H. B. Pacejka, Tire and Vehicle Dynamics, 3rd ed., ch. 1 (steer compliance)",
    parameters=(
        Key("c", "rad/kN", 0.0, 0.02, neutral=0.0, least=0.0005, minimum=0.0, meaning="angle given way over force"),
    ),
    ties=("understeer",),
    reveals="steady circles at growing speed",
)
def steer_compliance(x: Bus, p: Any, m: Any) -> None:
    soft = 1.0 / (1.0 + 1e-3 * p.c * x.tangent_front)
    x.fy_front *= soft
    x.tangent_front *= soft
    given = 1e-3 * p.c * x.fy_front
    x.steer -= given
    x.slip_front -= given
