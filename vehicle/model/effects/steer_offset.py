"""Zero error of the steering."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import DRIVES_5_S, STEER, TURN, ShownBy


@effect(
    name="steer_offset",
    slot="command",
    order=90,  # what the steering is turned to: stops, play and rate limit come after it
    physics="the wheels do not stand straight at command zero",
    equation="d = d_c + d_0",
    source="wheel alignment",
    parameters=(
        Key(
            "offset",
            "rad",
            -0.04,
            0.04,
            neutral=0.0,
            least=0.002,
            minimum=-0.5,
            maximum=0.5,
            meaning="angle at command zero",
        ),
    ),
    ties=(
        "gyro_bias",
        "road_bank",
    ),
    reveals="a straight with command zero for 5 s, in both directions",
    shown_by=ShownBy(320, (STEER, TURN), (DRIVES_5_S,)),
    diagnosed=Diagnosed(run_setup="zero"),
)
def steer_offset(x: Bus, p: Any, m: Any) -> None:
    x.steer += p.offset
