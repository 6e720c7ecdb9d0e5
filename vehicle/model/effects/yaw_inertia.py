"""Moment of inertia about z."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import CURVES, STEER, TURN, ShownBy


@effect(
    name="yaw_inertia",
    slot="body",
    tyres=True,
    physics="a car with more mass far from its middle turns in and out more slowly",
    equation="ratio I_z r' = moments",
    source="R. Rajamani, Vehicle Dynamics and Control, 2nd ed., ch. 2 (lateral dynamics)",
    parameters=(
        Key("ratio", "-", 0.5, 2.0, neutral=1.0, least=0.05, minimum=0.05, meaning="inertia over the assumed one"),
    ),
    ties=(
        "tyre_relaxation",
        "steer_lag",
    ),
    reveals="steering steps and fast steering waves at 10 m/s",
    shown_by=ShownBy(380, (STEER, TURN), (CURVES, ("steer_rate", 0.1, "steering by 0.1 rad/s"))),
)
def yaw_inertia(x: Bus, p: Any, m: Any) -> None:
    x.turning_inertia *= p.ratio
