"""Slope of the ground."""

from __future__ import annotations

from math import cos
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import DRIVE, DRIVES_10_S, SPEED, TURNS_AROUND, ShownBy


@effect(
    name="road_grade",
    slot="road",
    physics="a plane that rises along a heading pulls the car back by gravity",
    equation="a = -g sin(theta), theta = slope cos(yaw - heading)",
    source="inclined plane",
    parameters=(
        Key("slope", "rad", -0.08, 0.08, neutral=0.0, least=0.003, minimum=-0.5, maximum=0.5, meaning="rise angle"),
        Key("heading", "rad", -3.15, 3.15, neutral=0.0, least=0.1, meaning="direction in which the plane rises"),
    ),
    ties=("rolling_resistance",),
    reveals="the same straight driven in both directions at constant command",
    shown_by=ShownBy(220, (SPEED, ("ax", *DRIVE)), (DRIVES_10_S, TURNS_AROUND)),
    diagnosed=Diagnosed(surroundings=True),
)
def road_grade(x: Bus, p: Any, m: Any) -> None:
    x.grade += p.slope * cos(x.yaw - p.heading)
