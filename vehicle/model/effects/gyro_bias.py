"""Bias of the yaw-rate sensor."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import ShownBy


@effect(
    name="gyro_bias",
    slot="sensor",
    order=60,
    physics="a gyroscope shows a rate while it stands still",
    equation="r_measured = r + b",
    source="IEEE Std 952 (bias of a rate gyro)",
    parameters=(
        Key(
            "b", "rad/s", -0.04, 0.04, neutral=0.0, least=0.001, minimum=-1.0, maximum=1.0, meaning="rate shown at rest"
        ),
    ),
    ties=("steer_offset",),
    reveals="5 s of standstill, and a straight with headings logged",
    shown_by=ShownBy(420, (("yaw_rate",), ("yaw", "x"))),
    diagnosed=Diagnosed(run_setup="zero"),
)
def gyro_bias(x: Bus, p: Any, m: Any) -> None:
    x.meas_yaw_rate += p.b
