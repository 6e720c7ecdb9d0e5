"""Slip of both axles."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import CURVES, STEER, TURN, ShownBy


@effect(
    name="cornering_compliance",
    slot="body",
    order=5,
    tyres=True,
    physics="both axles slip in proportion to lateral acceleration: the car swings its tail out and turns in later",
    equation="slip = F/C_0 + D v r on either axle: the tail drifts by D v r more, the path of a steady turn stays",
    source="R. T. Bundorf, Vehicle Design Parameters, Characteristic Speed and Understeer, SAE 670078",
    parameters=(
        Key(
            "D",
            "rad s^2/m",
            0.001,
            0.02,
            neutral=0.0,
            least=0.0005,
            minimum=0.0,
            maximum=0.2,
            meaning="slip angle over lateral acceleration, added to what axle stiffnesses give",
        ),
    ),
    ties=(
        "tyre_relaxation",
        "yaw_inertia",
        "steer_lag",
        "steer_delay",
        "understeer",
    ),
    reveals="steering steps of both signs at 3 and at 10 m/s, with position and heading logged",
    shown_by=ShownBy(390, (STEER, TURN), (CURVES, ("steer_rate", 0.1, "steering by 0.1 rad/s"))),
    diagnosed=Diagnosed(details="understeer"),
)
def cornering_compliance(x: Bus, p: Any, m: Any) -> None:
    load = x.mass / x.wheelbase
    front = 1.0 / (1.0 + p.D * x.tangent_front / (load * x.cg_rear))
    rear = 1.0 / (1.0 + p.D * x.tangent_rear / (load * x.cg_front))
    x.fy_front *= front
    x.tangent_front *= front
    x.fy_rear *= rear
    x.tangent_rear *= rear
