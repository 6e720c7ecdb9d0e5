"""A hydrodynamic torque converter between engine and gearbox."""

from __future__ import annotations

from math import sqrt, tanh
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.shown_by import ACCELERATES, DRIVE, SPEED, SPEEDS_3_APART, ShownBy

COUPLED = 0.85  # speed of the turbine over that of the engine from which on nothing is multiplied; cars: 0.8 to 0.9


@effect(
    name="torque_converter",
    slot="actuator",
    order=76,  # after what the engine itself can give, before what the wheels make of it
    physics="the engine turns faster than what it drives: its torque comes later, and larger while the car is slow",
    equation="u: speed of the engine, as a speed of the car; J u' = max(a_c, 0) - w, w = (u^2 - v^2)/stall^2 1 m/s^2, "
    "u >= max(v, idle); a = min(a_c, 0) + mu w, mu = 1 + (ratio - 1) max(0, 1 - v/(0.85 u)); a = a_c for v >= lock",
    source="H. Naunheimer et al., Automotive Transmissions, 2nd ed., sec. 4.4 and 10.1 (characteristics of converters)",
    parameters=(
        Key("ratio", "-", 1.3, 2.6, neutral=1.0, least=0.1, minimum=1.0, maximum=4.0,
            meaning="torque multiplied at standstill"),
        Key("stall", "m/s", 0.8, 4.0, neutral=1.5, least=0.2, minimum=0.2, maximum=10.0,
            meaning="u at which a standing car takes 1 m/s^2 of it"),
        Key("J", "-", 0.03, 0.5, neutral=0.0, least=0.02, minimum=0.0, maximum=2.0,
            meaning="inertia of the engine, as share of the mass of the car"),
        Key("lock", "m/s", 4.0, 30.0, neutral=30.0, least=2.0, minimum=1.0, maximum=30.0, late=True,
            meaning="speed from which on a clutch bridges it"),
        Key("idle", "m/s", 0.0, 3.0, neutral=0.0, least=0.2, minimum=0.0, maximum=6.0, late=True, step=1.0,
            meaning="u of the idling engine, which pushes the car below that speed"),
    ),
    memory=(Memory("u"), Memory("a")),
    ties=("creep", "drive_lag", "drive_gain", "gear_inertia", "drive_torque_limit", "power_limit"),
    reveals="launches from standstill with several pedals, held for 3 s, logged at 20 Hz or more",
    shown_by=ShownBy(94, (DRIVE, SPEED), (ACCELERATES, SPEEDS_3_APART)),
    diagnosed=Diagnosed(
        grid=(("ratio", (1.8,)), ("stall", (1.2, 2.2)), ("J", (0.05, 0.15))),
        seen_as=(("drive_gain", "speed"),),
    ),
)  # fmt: skip
def torque_converter(x: Bus, p: Any, m: Any) -> None:
    v = max(x.vx, 0.0)
    middle = max(x.vx + 0.5 * x.dt * m.a, 0.0)  # speed in the middle of the step, as far as the last one tells
    if middle >= p.lock:
        m.u, m.a = middle, x.accel
        return
    start, mean = x.accel + x.accel_lead, x.accel  # of what is asked for
    asked, k = max(mean, 0.0), p.stall * p.stall
    slowest = max(middle, p.idle)  # the idling engine holds its speed, a car that rolls faster turns the engine along
    held = (slowest * slowest - middle * middle) / k
    if p.J > 0.0:
        u = max(m.u, v, p.idle)
        end = sqrt(middle * middle + k * asked)  # where it would come to rest
        if end > 0.0:
            turned = tanh(end * x.dt / (k * p.J))
            after = end * (u + end * turned) / (end + u * turned)
        else:
            after = u / (1.0 + u * x.dt / (k * p.J))
        given = max(asked - p.J * (after - u) / x.dt, held)
        m.u = max(after, slowest)
        engine = 0.5 * (u + m.u)
    else:
        u = max(sqrt(v * v + k * max(start, 0.0)), p.idle)
        given = max(asked, held)
        m.u = engine = sqrt(middle * middle + k * given)
    more = now = p.ratio - 1.0  # that is multiplied at the start of the step, and in the middle of it
    if u > 0.0:
        more *= max(1.0 - v / (COUPLED * u), 0.0)
    if engine > 0.0:
        now *= max(1.0 - middle / (COUPLED * engine), 0.0)
    x.accel = min(mean, 0.0) + given * (1.0 + now)
    x.accel_lead = min(start, 0.0) + (u * u - v * v) / k * (1.0 + more) - x.accel
    m.a = x.accel
