"""Bias of the longitudinal accelerometer."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import SPEED, ShownBy


@effect(
    name="accelerometer_bias",
    slot="sensor",
    order=60,
    physics="an accelerometer shows an acceleration while it stands still and level",
    equation="ax_measured = ax + b",
    source="IEEE Std 1293 (bias of an accelerometer)",
    parameters=(
        Key(
            "b",
            "m/s^2",
            -0.6,
            0.6,
            neutral=0.0,
            least=0.02,
            minimum=-20.0,
            maximum=20.0,
            meaning="acceleration shown at rest",
        ),
    ),
    ties=("road_grade",),
    reveals="5 s of standstill on level ground",
    shown_by=ShownBy(440, (("ax",), SPEED)),
    diagnosed=Diagnosed(run_setup="zero"),
)
def accelerometer_bias(x: Bus, p: Any, m: Any) -> None:
    x.meas_ax += p.b
