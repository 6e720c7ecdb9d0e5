"""Nodding of the body under the accelerometer."""

from __future__ import annotations

from math import cos, exp, pi, sin, sqrt
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.shown_by import ACCELERATES_WELL, SPEED, ShownBy


@effect(
    name="body_pitch",
    slot="sensor",
    order=35,
    physics="springs let the body squat and dive; gravity tips with it and adds to what the accelerometer shows",
    equation="ax_measured = ax + gain s, s'' + 2 damping w s' + w^2 (s - ax) = 0, w = 2 pi frequency",
    source="M. Mitschke, H. Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed. (pitch as a mass on springs and dampers)",
    parameters=(
        Key(
            "gain",
            "-",
            0.02,
            0.3,
            neutral=0.0,
            least=0.02,
            minimum=-0.9,
            maximum=5.0,
            meaning="share added when steady",
        ),
        Key("frequency", "Hz", 0.8, 4.0, neutral=1.5, least=0.2, minimum=0.1, meaning="undamped frequency of pitch"),
        Key("damping", "-", 0.1, 0.9, neutral=0.3, least=0.1, minimum=0.0, maximum=0.99, meaning="over critical"),
    ),
    memory=(Memory("nod"), Memory("rate"), Memory("push"), Memory("begun")),
    ties=(
        "pitch",
        "drive_gain",
    ),
    reveals="acceleration and brake steps with speeds logged",
    shown_by=ShownBy(470, (("ax",), SPEED), (ACCELERATES_WELL,)),
    diagnosed=Diagnosed(details="pitch"),
)
def body_pitch(x: Bus, p: Any, m: Any) -> None:
    if m.begun == 0.0:
        m.begun, m.nod, m.push = 1.0, x.meas_ax, x.meas_ax
    w = 2.0 * pi * p.frequency  # exact for an acceleration that held since the last row
    damped = w * sqrt(1.0 - p.damping * p.damping)
    gone, c, s = exp(-p.damping * w * x.dt), cos(damped * x.dt), sin(damped * x.dt)
    off = m.nod - m.push
    m.nod = m.push + gone * (off * c + (m.rate + p.damping * w * off) / damped * s)
    m.rate = gone * (m.rate * c - (w * w * off + p.damping * w * m.rate) / damped * s)
    m.push = x.meas_ax
    x.meas_ax += p.gain * m.nod
