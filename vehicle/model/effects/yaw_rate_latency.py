"""Age of the yaw rate."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import HISTORY_MEMORY, Key, Memory, effect
from vehicle.model.shown_by import TURNS, ShownBy
from vehicle.model.step_maths import DELAY_LINE, recall, remember


@effect(
    name="yaw_rate_latency",
    slot="sensor",
    order=30,
    physics="filter and bus pass the yaw rate on late",
    equation="r_measured(t) = r(t - T)",
    source="group delay of a filtered rate gyro",
    parameters=(
        Key("T", "s", 0.02, 0.5, neutral=0.0, least=0.02, minimum=0.0, maximum=1.0, meaning="age of the yaw rate"),
    ),
    memory=(*HISTORY_MEMORY, Memory("r", DELAY_LINE)),
    delay="T",
    ties=(
        "steer_delay",
        "steer_lag",
    ),
    reveals="steering steps of both signs with a clock-synchronous heading or ay logged",
    shown_by=ShownBy(430, (("yaw_rate",), ("yaw", "x", "steer")), (TURNS,)),
    # A yaw rate jumps with a held steering command: between two stamps nothing tells how old it is.
    diagnosed=Diagnosed(delay_error=1.0),
)
def yaw_rate_latency(x: Bus, p: Any, m: Any) -> None:
    at = remember(m, x.t)
    m.r[at] = x.meas_yaw_rate
    if p.T > 0.0:
        a, b, share = recall(m, x.t - p.T)
        x.meas_yaw_rate = m.r[a] + share * (m.r[b] - m.r[a])
