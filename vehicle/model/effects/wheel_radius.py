"""Wrong rolling radius in the odometry."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.effect import Key, effect
from vehicle.model.shown_by import DRIVES_5_S, ShownBy


@effect(
    name="wheel_radius",
    slot="sensor",
    physics="the speed is computed with another rolling radius than the tyres have",
    equation="v_measured = k v",
    source="rolling wheel: v = w R",
    parameters=(Key("ratio", "-", 0.9, 1.1, neutral=1.0, least=0.003, minimum=0.1, meaning="shown over true speed"),),
    ties=("gnss_latency",),
    reveals="any straight of 50 m at constant speed, with positions logged",
    shown_by=ShownBy(410, (("v",), ("x",)), (DRIVES_5_S,)),
)
def wheel_radius(x: Bus, p: Any, m: Any) -> None:
    x.meas_v *= p.ratio
