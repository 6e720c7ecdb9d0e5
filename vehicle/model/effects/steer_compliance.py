"""Elastic steering."""

from __future__ import annotations

from math import sqrt
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, effect

NEWTON = 6  # steps of Newton's method, for a force right to a thousandth in the bend


@effect(
    name="steer_compliance",
    slot="body",
    order=65,  # after all that alters the force, before it relaxes
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
    c = 1e-3 * p.c
    tangent, force = x.tangent_front, x.fy_front
    if tangent > 0.0 and x.slip_front != 0.0:
        # Bent tyres, F = K a/sqrt(1 + (K a/M)^2): secant over tangent tells K and M; then Newton's method
        bend = force / (x.slip_front * tangent) - 1.0
        if bend > 1e-9:
            linear = force * sqrt(1.0 + bend)
            stiff, most = linear / x.slip_front, abs(linear) / sqrt(bend)
            force /= 1.0 + c * tangent
            for _ in range(NEWTON):
                q = stiff * (x.slip_front - c * force) / most
                level = 1.0 / sqrt(1.0 + q * q)
                tangent = stiff * level * level * level
                force -= (force - most * q * level) / (1.0 + c * tangent)
            x.slip_front -= c * force
            x.steer -= c * force
            x.fy_front, x.tangent_front = force, tangent / (1.0 + c * tangent)
            return
    x.fy_front = force / (1.0 + c * tangent)
    x.tangent_front = tangent / (1.0 + c * tangent)
    x.steer -= c * x.fy_front
    x.slip_front -= c * x.fy_front
