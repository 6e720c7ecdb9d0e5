"""Swaying of the body under the accelerometer."""

from __future__ import annotations

from math import cos, exp, pi, sin, sqrt
from typing import Any

from vehicle.model.bus import GRAVITY, Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.shown_by import CURVES, ShownBy


@effect(
    name="body_roll",
    slot="body",
    order=90,  # after everything that alters the forces
    tyres=True,
    physics="springs let the body sway out of the turn; gravity tips with it and adds to what the accelerometer shows",
    equation="ay_measured = ay + gain s + lead s' + inertia s'', s'' + 2 damping w s' + w^2 (s - F_y/m) = 0, "
    "w = 2 pi frequency, F_y: what wheels and ground do to each other across the body",
    source="M. Mitschke, H. Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed. (roll as a mass on springs and dampers)",
    parameters=(
        Key(
            "gain",
            "-",
            0.02,
            0.4,
            neutral=0.0,
            least=0.02,
            minimum=-0.9,
            maximum=5.0,
            meaning="share added when steady",
        ),
        Key("frequency", "Hz", 0.8, 4.0, neutral=2.0, least=0.2, minimum=0.1, meaning="undamped frequency of roll"),
        Key("damping", "-", 0.1, 0.9, neutral=0.3, least=0.1, minimum=0.0, maximum=0.99, meaning="over critical"),
        Key(
            "lead",
            "s",
            -0.1,
            0.1,
            neutral=0.0,
            least=0.002,
            minimum=-0.4,
            maximum=0.4,
            meaning="what dampers and tyres pass on of the rate of sway",
        ),
        Key(
            "inertia",
            "s^2",
            -0.02,
            0.02,
            neutral=0.0,
            least=0.0002,
            minimum=-0.06,
            maximum=0.06,
            meaning="sway of the body against its wheels: - m_unsprung/m h gain/g at its own height",
        ),
    ),
    memory=(Memory("sway"), Memory("rate"), Memory("begun")),
    ties=(
        "roll",
        "road_bank",
    ),
    reveals="steering steps and lane changes at 10 m/s",
    shown_by=ShownBy(490, (("ay",), ("yaw_rate", "yaw")), (CURVES,)),
    diagnosed=Diagnosed(details="roll"),
)
def body_roll(x: Bus, p: Any, m: Any) -> None:
    # Of the ground on the body: wind acts where the mass is, and leans it by what the tyres hold against it
    pushed = (x.fy_front * cos(x.steer) + x.fy_rear + x.steered_pull) / x.mass
    if x.vx < 2.0 * x.slow:  # a car that moves without slip (`vehicle.model.kernel`) is held by the forces of its path
        s = max(x.vx / x.slow - 1.0, 0.0)
        held = x.vx * x.vx * x.curvature + GRAVITY * sin(x.bank)
        pushed = held + s * s * (3.0 - 2.0 * s) * (pushed - held)
    if m.begun == 0.0:
        m.begun, m.sway = 1.0, pushed
    w = 2.0 * pi * p.frequency  # exact for a push that holds over the step
    swaying = w * w * (pushed - m.sway) - 2.0 * p.damping * w * m.rate
    x.lean_y += p.gain * m.sway + p.lead * m.rate + p.inertia * swaying
    damped = w * sqrt(1.0 - p.damping * p.damping)
    gone, c, s = exp(-p.damping * w * x.dt), cos(damped * x.dt), sin(damped * x.dt)
    off = m.sway - pushed
    m.sway = pushed + gone * (off * c + (m.rate + p.damping * w * off) / damped * s)
    m.rate = gone * (m.rate * c - (w * w * off + p.damping * w * m.rate) / damped * s)
