"""Front wheels that steer by less than their different curves ask for."""

from __future__ import annotations

from math import sin
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import SHARP_CURVES, STEER, TURN, ShownBy


@effect(
    name="parallel_steering",
    slot="body",
    order=70,
    tyres=True,
    physics="wheels that steer alike work against each other in a tight bend: the pair turns the car back",
    equation="M = share t/2 sin d C_f/2 (b_r - b_l), b: direction in which the left and the right wheel move",
    source="M. Mitschke, H. Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed. (steering geometry of A. Ackermann)",
    parameters=(
        Key(
            "share",
            "-",
            0.0,
            1.5,  # beyond 1 the outer wheel steers by more than the inner one, as in fast cars
            neutral=0.0,
            least=0.1,
            minimum=-1.0,
            maximum=2.0,
            meaning="0: each wheel rolls along its own curve, 1: both steer alike, 1.5: the outer one by more",
        ),
    ),
    ties=("understeer", "steer_ratio"),
    diagnosed=Diagnosed(details="understeer"),
    reveals="slow circles with much steering",
    shown_by=ShownBy(357, (STEER, TURN), (SHARP_CURVES,)),
)
def parallel_steering(x: Bus, p: Any, m: Any) -> None:
    speed = max(x.vx, x.slow)
    across = (x.vy + x.cg_front * x.yaw_rate) / speed  # tangent of the direction in which the middle of the axle moves
    apart = 0.5 * x.track * x.yaw_rate / speed  # of the speeds ahead of its wheels
    less = 1.0 / (1.0 + across * across)
    x.yaw_moment -= 0.5 * p.share * apart * across * less * x.tangent_front * x.track * sin(x.steer)
    given = p.share * across * less * less * apart * apart
    x.slip_front -= given
    x.fy_front -= given * x.tangent_front
