"""Bias of the lateral accelerometer."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import TURN, ShownBy


@effect(
    name="lateral_accelerometer_bias",
    slot="sensor",
    order=60,
    physics="an accelerometer shows a sideways acceleration while it stands still and level, or it is mounted tilted",
    equation="ay_measured = ay + b",
    source="IEEE Std 1293 (bias of an accelerometer)",
    parameters=(
        Key(
            "b",
            "m/s^2",
            -1.0,
            1.0,
            neutral=0.0,
            least=0.02,
            minimum=-20.0,
            maximum=20.0,
            meaning="sideways acceleration shown at rest",
        ),
    ),
    ties=("road_bank",),
    reveals="5 s of standstill on level ground, or the same straight driven in both directions",
    shown_by=ShownBy(441, (("ay",), TURN)),
    diagnosed=Diagnosed(run_setup="zero"),
)
def lateral_accelerometer_bias(x: Bus, p: Any, m: Any) -> None:
    x.meas_ay += p.b
