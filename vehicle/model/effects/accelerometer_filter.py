"""Smoothing of the accelerometers.

What went on between two rows is taken for a straight line. Against rows of 1 ms, a time constant of 0.1 s comes out
within 3 % from rows of 10 to 50 ms and within 5 % from 100 ms, if the car has lags of its own and no `ay_x`.
"""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.shown_by import ShownBy
from vehicle.model.step_maths import lag

STEP = 0.014  # s of a step of a replay: between its longest steps of 0.01 s, with tyres, and of 0.02 s


@effect(
    name="accelerometer_filter",
    slot="sensor",
    order=5,  # before gains, turns and offsets, which a linear filter lets pass in any order
    physics="sensor or bus smooths both accelerations before they are logged, which also makes them late",
    equation="tau a_m' = a - a_m for ax and ay (cut-off 1/(2 pi tau))",
    source="digital low-pass filter of an inertial sensor, as data sheets give its bandwidth",
    parameters=(
        Key("tau", "s", 0.02, 0.3, neutral=0.0, least=0.02, minimum=0.0, maximum=2.0, meaning="time constant"),
    ),
    memory=(Memory("x"), Memory("y"), Memory("last_x"), Memory("last_y"), Memory("begun")),
    ties=("force_rise", "body_roll", "body_pitch"),
    reveals="steps of the brake and of the steering, with a clock-synchronous speed and yaw rate logged",
    shown_by=ShownBy(445, (("ax", "ay"), ("v", "vx", "x", "yaw_rate", "yaw"))),
)
def accelerometer_filter(x: Bus, p: Any, m: Any) -> None:
    ax, ay = x.meas_ax, x.meas_ay
    if m.begun == 0.0:
        m.begun, m.x, m.y, m.last_x, m.last_y = 1.0, ax, ay, ax, ay
    if p.tau > 0.0:
        # From what the last row began with to what it ended with: a command may have jumped since. The mean of its last
        # step lies half a step before the end.
        steps = max(x.dt / STEP, 1.0)
        whole = 2.0 * steps / (2.0 * steps - 1.0)
        end_x = m.last_x + whole * (x.ax - x.ax_x * x.yaw_rate * x.yaw_rate - m.last_x)
        end_y = m.last_y + whole * (x.ay + x.lean_y - m.last_y) if x.ay_x == 0.0 else ay
        _, m.x = lag(m.x, 0.5 * (m.last_x + end_x), 0.5 * (m.last_x - end_x), p.tau, x.dt)
        _, m.y = lag(m.y, 0.5 * (m.last_y + end_y), 0.5 * (m.last_y - end_y), p.tau, x.dt)
        x.meas_ax, x.meas_ay = m.x, m.y
    m.last_x, m.last_y = ax, ay
