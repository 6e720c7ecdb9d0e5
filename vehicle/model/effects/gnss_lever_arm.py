"""Antenna away from the reference point."""

from __future__ import annotations

from math import cos, sin
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import TURNS, ShownBy


@effect(
    name="gnss_lever_arm",
    slot="sensor",
    order=10,
    physics="the position shown is that of the antenna",
    equation="x_m = x + X cos(yaw) - Y sin(yaw), y_m = y + X sin(yaw) + Y cos(yaw)",
    source="P. D. Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed.",
    parameters=(
        Key(
            "x",
            "m",
            -4.0,  # the rear overhang of a long bus; the reference point is the middle of the rear axle
            9.0,  # its front: a wheelbase of 6 m and 3 m of overhang
            neutral=0.0,
            least=0.03,
            minimum=-20.0,
            maximum=20.0,
            meaning="ahead of the reference point",
        ),
        Key("y", "m", -2.0, 2.0, neutral=0.0, least=0.03, minimum=-20.0, maximum=20.0, meaning="left of it"),
    ),
    ties=(
        "gnss_latency",
        "heading_bias",
    ),
    reveals="tight circles to both sides at walking speed",
    shown_by=ShownBy(520, (("x",), ("yaw",)), (TURNS,)),
    diagnosed=Diagnosed(run_setup="place", hides_in=(("GNSS_x", 10),)),
)
def gnss_lever_arm(x: Bus, p: Any, m: Any) -> None:
    c, s = cos(x.meas_yaw), sin(x.meas_yaw)
    x.meas_x += p.x * c - p.y * s
    x.meas_y += p.x * s + p.y * c
