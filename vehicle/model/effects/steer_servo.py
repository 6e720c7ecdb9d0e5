"""Servo loop of the steering: of second order."""

from __future__ import annotations

import math
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.shown_by import COMMAND, MOVES_WHEEL, TURN, TURNS, ShownBy


@effect(
    name="steer_servo",
    slot="actuator",
    order=11,  # with steer_lag
    physics="a position loop turns motor and wheels, which have inertia: it starts late, and may overshoot",
    equation="tau^2 d'' + 2 damping tau d' + d = d_c",
    source="P. Pfeffer, M. Harrer (eds.), Steering Handbook (steering actuators); natural frequency 1/(2 pi tau)",
    parameters=(
        Key("tau", "s", 0.02, 0.3, neutral=0.0, least=0.01, minimum=0.0, maximum=2.0, meaning="1/natural frequency"),
        Key(
            "damping",
            "-",
            0.3,
            1.2,
            neutral=0.8,
            least=0.1,
            minimum=0.02,
            maximum=20.0,
            meaning="share of the damping at which it stops overshooting",
        ),
    ),
    memory=(Memory("d", start="steer"), Memory("rate")),
    ties=("steer_lag", "steer_delay", "tyre_relaxation"),
    reveals="steps of the steering command of both signs at 5 m/s, logged at 50 Hz or more",
    shown_by=ShownBy(
        252, (COMMAND, TURN), (MOVES_WHEEL, TURNS), usual=(("steer_rate", 0.04, "steering by 0.04 rad/s"),)
    ),
    diagnosed=Diagnosed(details="steer_lag", contains="steer_lag"),  # which it is where it is damped by far
)
def steer_servo(x: Bus, p: Any, m: Any) -> None:
    if p.tau <= 0.0:
        m.d, m.rate = x.steer - x.steer_lead, 0.0
        return
    w, z = 1.0 / p.tau, p.damping
    start, rate, dt = m.d, m.rate, x.dt
    slope = -2.0 * x.steer_lead / dt  # the command runs straight within the step; what is left of the start rings
    begin = x.steer + x.steer_lead - 2.0 * z * p.tau * slope
    away, its_rate = start - begin, rate - slope
    q = 1.0 - z * z
    if abs(q) < 1e-8:
        cosine = math.exp(-w * dt)
        sine = dt * cosine
    elif q > 0.0:
        turn = w * math.sqrt(q)
        decay = math.exp(-z * w * dt)
        cosine, sine = decay * math.cos(turn * dt), decay * math.sin(turn * dt) / turn
    else:
        turn = w * math.sqrt(-q)
        slow, fast = math.exp((turn - z * w) * dt), math.exp(-(turn + z * w) * dt)
        cosine, sine = 0.5 * (slow + fast), 0.5 * (slow - fast) / turn
    m.d = begin + slope * dt + away * cosine + (its_rate + z * w * away) * sine
    m.rate = slope + its_rate * cosine - (w * w * away + z * w * its_rate) * sine
    # the mean follows from the equation, integrated over the step
    x.steer -= (2.0 * z * p.tau * (m.d - start) + p.tau * p.tau * (m.rate - rate)) / dt
    x.steer_lead = start - x.steer
    x.steer_glides = 1.0
