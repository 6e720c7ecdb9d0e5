"""Build-up of lateral force over distance."""

from __future__ import annotations

from math import expm1
from typing import Any

from vehicle.model.bus import BLEND_TIME, Bus
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.shown_by import CURVES, STEER, TURN, ShownBy

MEMORY = ("front", "rear", "front_steady", "rear_steady", "front_tangent", "rear_tangent", "gone", "follow", "begun")


@effect(
    name="tyre_relaxation",
    slot="body",
    order=80,
    tyres=True,
    physics="a tyre must roll some way before its lateral force follows its slip",
    equation="sigma/v F' = F_ss - F",
    source="H. B. Pacejka, Tire and Vehicle Dynamics, 3rd ed. (relaxation length)",
    parameters=(Key("length", "m", 0.1, 3.0, neutral=0.0, least=0.05, minimum=0.0, meaning="relaxation length sigma"),),
    memory=tuple(Memory(name) for name in MEMORY),
    ties=(
        "steer_lag",
        "steer_delay",
    ),
    reveals="steering steps of both signs at 3 and at 10 m/s",
    shown_by=ShownBy(370, (STEER, TURN), (CURVES, ("steer_rate", 0.1, "steering by 0.1 rad/s"))),
)
def tyre_relaxation(x: Bus, p: Any, m: Any) -> None:
    if m.begun == 0.0:
        m.begun, m.front, m.rear = 1.0, x.fy_front, x.fy_rear
        m.front_steady, m.rear_steady = x.fy_front, x.fy_rear
    elif m.gone > 0.0:  # the last step: slip moved straight from its start to its end
        m.front += m.gone * (m.front_steady - m.front) + m.follow * m.front_tangent * x.slip_change_front
        m.rear += m.gone * (m.rear_steady - m.rear) + m.follow * m.rear_tangent * x.slip_change_rear
    if x.vx < 2.0 * x.slow:  # a car that moves without slip (`vehicle.model.kernel`) has the forces of its path
        s = min(max(x.vx / x.slow - 1.0, 0.0), 1.0)
        kinematic = 1.0 - s * s * (3.0 - 2.0 * s)
        taken = x.dt * kinematic / (x.dt * kinematic + BLEND_TIME * (1.0 - kinematic))
        across = x.mass * x.vx * x.yaw_rate / x.wheelbase
        m.front += taken * (x.cg_rear * across - m.front)
        m.rear += taken * (x.cg_front * across - m.rear)
    m.front_steady, m.rear_steady = x.fy_front, x.fy_rear
    m.front_tangent, m.rear_tangent = x.tangent_front, x.tangent_rear
    if p.length <= 0.0:
        m.front, m.rear, m.gone = x.fy_front, x.fy_rear, 0.0
        x.fy_front_lead = x.fy_rear_lead = 0.0
        return
    way = max(x.vx, x.slow) * x.dt / p.length
    m.gone = -expm1(-way)
    share = m.gone / way
    m.follow = 1.0 - share
    x.fy_front += (m.front - x.fy_front) * share
    x.fy_rear += (m.rear - x.fy_rear) * share
    mean = 1.0 - 2.0 * (1.0 - share) / way
    x.tangent_front *= mean
    x.tangent_rear *= mean
    x.fy_front_lead = m.front - x.fy_front - x.tangent_front * x.steer_lead
    x.fy_rear_lead = m.rear - x.fy_rear
