"""IMU turned about the vertical."""

from __future__ import annotations

from math import cos, sin
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import ACCELERATES_WELL, CURVES, ShownBy


@effect(
    name="imu_misalignment",
    slot="sensor",
    order=50,
    physics="the sensor's axes are not those of the car",
    equation="ax_m = ax cos a + ay sin a, ay_m = -ax sin a + ay cos a",
    source="rotation of a vector",
    parameters=(
        Key(
            "angle",
            "rad",
            -0.2,
            0.2,
            neutral=0.0,
            least=0.01,
            minimum=-3.2,
            maximum=3.2,
            meaning="of the sensor about z, left positive",
        ),
    ),
    ties=(
        "accelerometer_bias",
        "road_bank",
    ),
    reveals="straight acceleration and braking, then a steady circle",
    shown_by=ShownBy(450, (("ax",), ("ay",)), (ACCELERATES_WELL, CURVES)),
)
def imu_misalignment(x: Bus, p: Any, m: Any) -> None:
    ax, ay, c, s = x.meas_ax, x.meas_ay, cos(p.angle), sin(p.angle)
    x.meas_ax = ax * c + ay * s
    x.meas_ay = ay * c - ax * s
