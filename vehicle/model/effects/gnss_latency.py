"""Age of position and heading."""

from __future__ import annotations

from math import cos, sin
from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import HISTORY_MEMORY, Key, Memory, effect
from vehicle.model.shown_by import DRIVES_5_S, SPEED, ShownBy
from vehicle.model.step_maths import DELAY_LINE, recall, remember

BEFORE = 1.0  # s, as far back as a pose can be asked for


@effect(
    name="gnss_latency",
    slot="sensor",
    order=30,
    physics="receiver and bus pass the pose on late",
    equation="x_m(t) = x(t - T), y and yaw alike",
    source="P. D. Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed.",
    parameters=(
        Key("T", "s", 0.03, 0.5, neutral=0.0, least=0.02, minimum=0.0, maximum=1.0, meaning="age of the pose"),
    ),
    memory=(*HISTORY_MEMORY, Memory("x", DELAY_LINE), Memory("y", DELAY_LINE), Memory("yaw", DELAY_LINE)),
    delay="T",
    ties=(
        "gnss_lever_arm",
        "drive_delay",
        "steer_delay",
    ),
    reveals="speed steps and turns with a clock-synchronous speed or yaw rate logged",
    shown_by=ShownBy(510, (("x",), SPEED), (DRIVES_5_S, ("speed_range", 2.0, "speeds 2 m/s apart"))),
    diagnosed=Diagnosed(hides_in=(("GNSS_x", 20),)),
)
def gnss_latency(x: Bus, p: Any, m: Any) -> None:
    if m.head == 0.0:  # before the log began the car is taken to have come straight
        at, back = remember(m, x.t - BEFORE), BEFORE * x.vx
        m.x[at], m.y[at], m.yaw[at] = x.meas_x - back * cos(x.yaw), x.meas_y - back * sin(x.yaw), x.meas_yaw
    elif x.moved > 0.0 and p.T > 0.0:  # a replay put the car elsewhere: its past goes along
        turn = x.yaw - x.old_yaw
        c, s = cos(turn), sin(turn)
        for i in range(max(int(m.tail), int(m.head) - DELAY_LINE), int(m.head)):
            j = i % DELAY_LINE
            dx, dy = m.x[j] - x.old_x, m.y[j] - x.old_y
            m.x[j] = x.x + c * dx - s * dy
            m.y[j] = x.y + s * dx + c * dy
            m.yaw[j] += turn
    at = remember(m, x.t)
    m.x[at], m.y[at], m.yaw[at] = x.meas_x, x.meas_y, x.meas_yaw
    if p.T > 0.0:
        a, b, share = recall(m, x.t - p.T)
        x.meas_x = m.x[a] + share * (m.x[b] - m.x[a])
        x.meas_y = m.y[a] + share * (m.y[b] - m.y[a])
        x.meas_yaw = m.yaw[a] + share * (m.yaw[b] - m.yaw[a])
