"""Fading of the brake."""

from __future__ import annotations

from math import exp
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.shown_by import BRAKE, BRAKES, SPEED, ShownBy


@effect(
    name="brake_fade",
    slot="actuator",
    order=75,  # after brake_limit: only what the brake gives heats it
    physics="hot linings grip less: braking heats the discs, the air cools them; they are cold when a log begins",
    equation="a = a_c/(1 + k w) for a_c < 0, w' = abs(a v) - w/tau",
    source="R. Limpert, Brake Design and Safety, 3rd ed. (temperature of a lumped disc; fade)",
    parameters=(
        Key(
            "k",
            "s^2/m^2",
            0.0002,
            0.02,
            neutral=0.0,
            least=0.0002,
            minimum=0.0,
            meaning="loss of gain per energy held in the discs over mass (kg/J)",
        ),
        Key(
            "tau",
            "s",
            20.0,
            600.0,
            neutral=120.0,
            least=10.0,
            minimum=1.0,
            meaning="time in which the discs cool to 37 %",
        ),
    ),
    memory=(Memory("heat"),),
    ties=(
        "brake_gain",
        "brake_limit",
    ),
    reveals="ten stops from 20 m/s one after the other, a pause of minutes, one more stop",
    shown_by=ShownBy(125, (BRAKE, SPEED), (BRAKES, ("speed", 5.0, "5 m/s")), usual=(("speed", 10.0, "10 m/s"),)),
    diagnosed=Diagnosed(refines=("brake_gain",), seen_as=(("brake_gain", "brake_energy"), ("brake_gain", "time"))),
)
def brake_fade(x: Bus, p: Any, m: Any) -> None:
    if p.k <= 0.0 or x.settle > 0.0:
        return
    warming = 0.0
    if x.accel < 0.0:
        gain = 1.0 / (1.0 + p.k * m.heat)
        x.accel *= gain
        x.accel_lead *= gain
        v = abs(x.vx)
        left = max(v + x.accel * x.dt, 0.0)
        warming = 0.5 * (v * v - left * left)  # what the brake takes from the car in this step
    share = x.dt / p.tau
    kept = exp(-share)
    m.heat = m.heat * kept + warming * (1.0 - kept) / share
