"""Ceiling of the commanded speed."""

from __future__ import annotations

from math import inf
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import SPEED, ShownBy
from vehicle.model.step_maths import clip


@effect(
    name="speed_limit",
    slot="command",
    order=5,  # before speed_controller takes the error
    physics="the car's own controller cuts the speed it is asked for; it acts on a commanded speed only",
    equation="abs(speed_cmd) <= limit",
    source="UN Regulation No. 89 (adjustable speed limitation devices)",
    parameters=(
        Key("limit", "m/s", 1.0, 40.0, neutral=inf, least=0.1, minimum=0.0, meaning="greatest speed that is tracked"),
    ),
    ties=(
        "power_limit",
        "aero_drag",
        "wheel_radius",
    ),
    reveals="a commanded speed that rises in steps to the highest allowed",
    shown_by=ShownBy(525, (("speed_cmd",), SPEED), (("speed", 1.0, "1 m/s"),)),
    diagnosed=Diagnosed(input="speed_cmd"),
)
def speed_limit(x: Bus, p: Any, m: Any) -> None:
    x.speed_cmd = clip(x.speed_cmd, -p.limit, p.limit)
