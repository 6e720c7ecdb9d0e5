"""Cross slope of the ground."""

from __future__ import annotations

from math import cos
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import DRIVES_10_S, TURN, TURNS_AROUND, ShownBy


@effect(
    name="road_bank",
    slot="road",
    physics="a plane that rises to one side pulls the car sideways and shows on the accelerometer",
    equation="ay = ... + g sin(phi), phi = slope cos(yaw - heading), left side up",
    source="inclined plane",
    parameters=(
        Key("slope", "rad", -0.35, 0.35, neutral=0.0, least=0.005, minimum=-0.5, maximum=0.5, meaning="bank angle"),
        Key(
            "heading",
            "rad",
            -3.15,
            3.15,
            neutral=0.0,
            least=0.1,
            meaning="direction of travel in which the left side is highest",
        ),
    ),
    ties=(
        "roll",
        "gyro_bias",
    ),
    reveals="the same straight driven in both directions, hands off",
    shown_by=ShownBy(230, (TURN, ("ay",)), (DRIVES_10_S, TURNS_AROUND)),
    diagnosed=Diagnosed(surroundings=True),
)
def road_bank(x: Bus, p: Any, m: Any) -> None:
    x.bank += p.slope * cos(x.yaw - p.heading)
