"""A hill or a hollow of the ground."""

from __future__ import annotations

from math import atan, cos, exp, sin
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import DRIVE, DRIVES_10_S, SPEED, ShownBy


@effect(
    name="road_profile",
    slot="road",
    physics="one smooth hill (or hollow) at a place of the map: grade and bank are the two slopes of the same ground",
    equation="z = h exp(-((x - x0)^2 + (y - y0)^2)/(2 l^2)); tan grade, tan bank: slope of z ahead, to the left",
    source="differential geometry of a height field",
    parameters=(
        Key("height", "m", -3.0, 3.0, neutral=0.0, least=0.1, minimum=-100.0, maximum=100.0, meaning="of the top, h"),
        Key(
            "x",
            "m",
            -100.0,
            100.0,
            neutral=0.0,
            least=1.0,
            where=True,
            meaning="place of the top in the frame of the log, x0",
        ),
        Key("y", "m", -100.0, 100.0, neutral=0.0, least=1.0, where=True, meaning="place of the top, y0"),
        Key(
            "length",
            "m",
            5.0,
            100.0,
            neutral=30.0,
            least=1.0,
            minimum=1.0,
            where=True,
            meaning="top to steepest place, l",
        ),
    ),
    ties=(
        "road_grade",
        "road_bank",
        "rolling_resistance",
    ),
    reveals="several passes over the same place, in both directions and beside each other",
    shown_by=ShownBy(235, (SPEED, ("ax", "ay", *DRIVE), ("x",)), (DRIVES_10_S,)),
    diagnosed=Diagnosed(
        refines=("road_grade", "road_bank"),
        seen_as=(("road_grade", "place"), ("road_bank", "place")),
        surroundings=True,
    ),
)
def road_profile(x: Bus, p: Any, m: Any) -> None:
    if p.height != 0.0:
        dx, dy = (x.x - p.x) / p.length, (x.y - p.y) / p.length
        fall = -p.height / p.length * exp(-0.5 * (dx * dx + dy * dy))
        c, s = cos(x.yaw), sin(x.yaw)
        x.grade += atan(fall * (dx * c + dy * s))
        x.bank += atan(fall * (dy * c - dx * s))
