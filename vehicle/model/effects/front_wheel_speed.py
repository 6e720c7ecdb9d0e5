"""Speed that is taken from the steered wheels."""

from __future__ import annotations

from math import cos, sin
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import CURVES, DRIVES_5_S, ShownBy


@effect(
    name="front_wheel_speed",
    slot="sensor",
    order=30,  # before the errors of the sensor itself
    physics="the speed is taken from the front wheels, which turn faster in a bend: their path is longer",
    equation="v_measured = (1 - share) v + share (v cos d + (vy + L r) sin d), vy at the rear axle",
    source="R. Rajamani, Vehicle Dynamics and Control, 2nd ed., sec. 2.2 (velocity of the front axle)",
    parameters=(
        Key(
            "share", "-", 0.0, 1.0, neutral=0.0, least=0.2, minimum=0.0, maximum=1.0,
            meaning="of the front axle in the speed shown: 1 front wheels only, 0.5 the mean of all four",
        ),
    ),
    ties=("wheel_slip", "wheel_radius"),
    reveals="slow circles with much steering, with positions or yaw rates logged",
    shown_by=ShownBy(413, (("v",), ("x", "yaw_rate")), (CURVES, DRIVES_5_S)),
)  # fmt: skip
def front_wheel_speed(x: Bus, p: Any, m: Any) -> None:
    across = x.vy_rear + x.wheelbase * x.meas_yaw_rate
    x.meas_v += p.share * (x.vx * (cos(x.steer) - 1.0) + across * sin(x.steer))
