"""Elastic steering."""

from __future__ import annotations

from math import cosh, log, sinh, sqrt, tanh
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import SHARP_CURVES, STEER, TURN, ShownBy

NEWTON = 7  # steps of Newton's method, for a force right to a thousandth in the bend
STEEPEST = 1e9  # secant over tangent of a tyre's force: beyond it, it does not change any more


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
    shown_by=ShownBy(360, (STEER, TURN), (SHARP_CURVES,)),
)
def steer_compliance(x: Bus, p: Any, m: Any) -> None:
    c = 1e-3 * p.c
    tangent, force = x.tangent_front, x.fy_front
    if tangent > 0.0 and x.slip_front != 0.0:
        # Bent tyres, F = M tanh(q), q = K a/M: secant over tangent, sinh(2q)/2q, tells K and M; then Newton's method
        bend = min(force / (x.slip_front * tangent), STEEPEST)
        if bend > 1.0 + 1e-9:
            z = min(sqrt(6.0 * (bend - 1.0)), 3.0 + 1.2 * log(bend))
            for _ in range(NEWTON):
                z -= (sinh(z) - bend * z) / (cosh(z) - bend)
            most = abs(force) / tanh(0.5 * z)
            stiff = 0.5 * z * most / abs(x.slip_front)
            for _ in range(NEWTON):
                level = tanh(stiff * (x.slip_front - c * force) / most)
                tangent = stiff * (1.0 - level * level)
                force -= (force - most * level) / (1.0 + c * tangent)
            x.slip_front -= c * force
            x.steer -= c * force
            x.fy_front, x.tangent_front = force, tangent / (1.0 + c * tangent)
            return
    x.fy_front = force / (1.0 + c * tangent)
    x.tangent_front = tangent / (1.0 + c * tangent)
    x.steer -= c * x.fy_front
    x.slip_front -= c * x.fy_front
