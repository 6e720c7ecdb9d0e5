"""Bias of the heading."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import DRIVES_5_S, ShownBy


@effect(
    name="heading_bias",
    slot="sensor",
    order=60,
    physics="the heading sensor is mounted or calibrated at an angle",
    equation="yaw_measured = yaw + b",
    source="mounting angle of a dual-antenna GNSS",
    parameters=(
        Key(
            "b",
            "rad",
            -0.06,
            0.06,
            neutral=0.0,
            least=0.003,
            minimum=-3.2,
            maximum=3.2,
            meaning="angle shown on a straight heading along x",
        ),
    ),
    ties=("gnss_lever_arm",),
    reveals="straights with positions logged",
    shown_by=ShownBy(500, (("yaw",), ("x",)), (DRIVES_5_S,)),
    diagnosed=Diagnosed(run_setup="zero"),
)
def heading_bias(x: Bus, p: Any, m: Any) -> None:
    x.meas_yaw += p.b
