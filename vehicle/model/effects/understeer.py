"""Different slip of front and rear axle."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import CURVES, STEER, TURN, ShownBy


@effect(
    name="understeer",
    slot="body",
    order=10,
    tyres=True,
    physics="the axle with softer tyres for its load slips more, so the car turns less (or more) the faster it is",
    equation="K = m/L (b/C_f - a/C_r): r = v d/(L + K v^2) in steady state",
    source="R. Rajamani, Vehicle Dynamics and Control, 2nd ed., ch. 3 (understeer gradient)",
    parameters=(
        Key(
            "K",
            "rad s^2/m",
            -0.002,
            0.015,
            neutral=0.0,
            least=0.0002,
            minimum=-0.1,
            maximum=0.2,
            meaning="added to what axle stiffnesses give",
        ),
    ),
    ties=(
        "steer_ratio",
        "steer_compliance",
        "tyre_saturation",
        "roll_dynamics",
    ),
    reveals="steady circles at growing speed",
    shown_by=ShownBy(330, (STEER, TURN), (CURVES, ("turning_speed_range", 2.0, "curves at speeds 2 m/s apart"))),
    diagnosed=Diagnosed(hides_in=(("EGO_max_steer_angle", 30),)),
)
def understeer(x: Bus, p: Any, m: Any) -> None:
    load = x.mass / x.wheelbase
    if p.K > 0.0:  # the front axle gets softer, else the rear
        soft = 1.0 / (1.0 + p.K * x.tangent_front / (load * x.cg_rear))
        x.fy_front *= soft
        x.tangent_front *= soft
    elif p.K < 0.0:
        soft = 1.0 / (1.0 - p.K * x.tangent_rear / (load * x.cg_front))
        x.fy_rear *= soft
        x.tangent_rear *= soft
