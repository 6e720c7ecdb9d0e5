"""Roll of the body under the accelerometer."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import CURVES, ShownBy


@effect(
    name="roll",
    slot="sensor",
    order=40,
    physics="rolling outwards in a turn tips the accelerometer, gravity adds to what it shows",
    equation="ay_measured = (1 + k) ay",
    source="T. D. Gillespie, Fundamentals of Vehicle Dynamics, roll in proportion to ay",
    parameters=(Key("gain", "-", 0.0, 0.3, neutral=0.0, least=0.01, minimum=-0.9, maximum=5.0, meaning="share added"),),
    ties=("road_bank",),
    reveals="steady circles at growing speed with yaw rates logged",
    shown_by=ShownBy(480, (("ay",), ("yaw_rate", "yaw")), (CURVES,)),
)
def roll(x: Bus, p: Any, m: Any) -> None:
    x.meas_ay *= 1.0 + p.gain
