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
    equation="a = a_c - a_b + a_b/(1 + k w), a_b = min(a_c + a_motor, 0), w' = abs(a_b v)/(1 + k w) - w/tau, "
    "a_motor: the motor of brake_gain",
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
        pressed = 1.0  # share of the deceleration that is of the discs
        if x.accel_brakes < 0.0:
            start = min(x.accel + x.accel_lead - x.accel_brakes, 0.0)
            braked = 0.5 * (start + min(x.accel - x.accel_lead - x.accel_brakes, 0.0))
            x.accel -= (1.0 - gain) * braked
            x.accel_lead -= (1.0 - gain) * (start - braked)
            pressed = gain * braked / x.accel
        else:
            x.accel *= gain
            x.accel_lead *= gain
        v = abs(x.vx)
        left = max(v + x.accel * x.dt, 0.0)
        warming = pressed * 0.5 * (v * v - left * left)  # what the brake takes from the car in this step
    share = x.dt / p.tau
    kept = exp(-share)
    m.heat = m.heat * kept + warming * (1.0 - kept) / share
