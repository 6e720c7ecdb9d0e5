"""Load sensitivity of the tyres."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import SHARP_CURVES, STEER, TURN, ShownBy
from vehicle.model.step_maths import held_across


@effect(
    name="load_transfer",
    slot="body",
    order=20,
    tyres=True,
    physics="in a turn load moves to the outer wheels, whose tyres gain less than the inner ones lose",
    equation="C = C_0 (1 - c (v r/g + sin(bank))^2)",
    source="H. B. Pacejka, Tire and Vehicle Dynamics, 3rd ed., ch. 1 (effective axle characteristic)",
    parameters=(
        Key(
            "c",
            "-",
            0.0,
            0.5,
            neutral=0.0,
            least=0.02,
            minimum=0.0,
            maximum=0.95,
            meaning="loss of axle stiffness at 1 g",
        ),
    ),
    ties=(
        "tyre_saturation",
        "understeer",
    ),
    reveals="steady circles at growing speed up to the limit",
    shown_by=ShownBy(350, (STEER, TURN), (SHARP_CURVES,)),
)
def load_transfer(x: Bus, p: Any, m: Any) -> None:
    share = held_across(x)
    left = 1.0 - p.c * min(share * share, 1.0)
    x.fy_front *= left
    x.fy_rear *= left
    x.tangent_front *= left
    x.tangent_rear *= left
