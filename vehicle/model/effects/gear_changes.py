"""What gears do to the drive: gaps while they are changed, and less force in each longer one."""

from __future__ import annotations

from typing import Any

from vehicle.model.bus import Bus
from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.shown_by import ACCELERATES, DRIVE, SPEED, ShownBy

PROGRESSION = 1.1  # by which each step is smaller than the one below; gearboxes of cars have 1.0 to 1.2
LEAST = 1.1  # of a step
DEMAND = 1.0  # m/s^2, in the middle of what drives ask for: there the speed does not hang on how much demand shifts it
BACK = 0.65  # of the speed of a change up at the same demand, below which the gearbox changes back; cars have 0.55 to
# 0.75
ROUNDING = 1e-9  # s of a change that its steps may leave by rounding


@effect(
    name="gear_changes",
    slot="actuator",
    order=12,  # after the lag of the drive: an open clutch cuts the force at once
    physics="a gearbox opens its clutch, or lowers the torque, while it changes gear; a longer gear pulls less",
    equation="a = (1 - cut) a_c i_k^fall for T after each change, else a_c i_k^fall, i_k: ratio of gear k over that of "
    "gear 0, i_0 = 1, i_k+1 = i_k / max(step/1.1^k, 1.1); up from gear k = 0, 1, ... above v_k (1 + demand (a_c - "
    "1 m/s^2)), with a_c >= 0 what the drive is asked for, v_0 = v1 and v_k+1 = v_k max(step/1.1^k, 1.1); down from "
    "gear k below 0.65 v_k-1 (1 + demand (a_c - 1 m/s^2))",
    source="H. Naunheimer et al., Automotive Transmissions, 2nd ed., sec. 6.2 and 9.1 (interruption of traction)",
    parameters=(
        Key("T", "s", 0.2, 1.2, neutral=0.0, least=0.1, minimum=0.0, maximum=3.0, meaning="time of a change"),
        Key("v1", "m/s", 2.0, 8.0, neutral=4.0, least=0.5, minimum=0.5, meaning="first change up, at 1 m/s^2"),
        Key("step", "-", 1.3, 2.2, neutral=1.6, least=0.1, minimum=1.1, meaning="second change over the first"),
        Key("demand", "s^2/m", 0.0, 0.5, neutral=0.0, least=0.03, minimum=0.0, maximum=0.9,
            meaning="how much later with demand"),
        Key("cut", "-", 0.3, 1.0, neutral=1.0, least=0.1, minimum=0.0, maximum=1.0, late=True,
            meaning="share of the drive that is lost"),
        Key("fall", "-", 0.0, 1.0, neutral=0.0, least=0.1, minimum=0.0, maximum=1.5, late=True,
            meaning="power of the ratio with which the force falls; 0 where all gears pull alike"),
    ),
    memory=(Memory("gear"), Memory("left")),
    ties=("drive_lag", "gear_inertia", "power_limit", "drive_gain"),
    reveals="full accelerations from standstill with several pedals, logged at 20 Hz or more",
    shown_by=ShownBy(93, (DRIVE, SPEED), (ACCELERATES,)),
    diagnosed=Diagnosed(
        grid=(("T", (0.5,)), ("v1", (2.8, 4.2, 6.3)), ("step", (1.5, 1.7, 1.9)), ("demand", (0.1, 0.3))),
    ),
)  # fmt: skip
def gear_changes(x: Bus, p: Any, m: Any) -> None:
    asked, v = max(x.accel, 0.0), abs(x.vx)
    later = 1.0 + p.demand * (asked - DEMAND)
    wait, before = 0.0, m.gear  # s of this step, before the change
    below, up, step = 0.0, p.v1, p.step
    if x.settle > 0.0 or x.t <= x.t_start:  # a log or a run begins in its gear
        m.gear = 0.0
        while v >= up * later:
            m.gear, up, step = m.gear + 1.0, up * max(step, LEAST), step / PROGRESSION
        before = m.gear
    else:
        for _ in range(int(m.gear)):
            below, up, step = up, up * max(step, LEAST), step / PROGRESSION
        if v + asked * x.dt >= up * later:
            wait = min(max((up * later - v) / max(asked, 0.1), 0.0), x.dt)
            m.gear, m.left = m.gear + 1.0, p.T
        elif v < BACK * below * later:  # at once when the pedal is pressed: kick-down
            m.gear, m.left = m.gear - 1.0, p.T
    if x.accel > 0.0 and p.fall > 0.0:
        pulls = now = 1.0  # of the gear that the step begins in, and of that in which it ends
        step = p.step
        for gear in range(max(int(m.gear), int(before))):
            if gear < before:
                pulls /= max(step, LEAST) ** p.fall
            if gear < m.gear:
                now /= max(step, LEAST) ** p.fall
            step /= PROGRESSION
        start = x.accel + x.accel_lead
        x.accel *= pulls * wait / x.dt + now * (1.0 - wait / x.dt)
        x.accel_lead = start * (pulls if wait > 0.0 else now) - x.accel
    if m.left > ROUNDING:
        cut = min(m.left, x.dt - wait)
        m.left -= cut
        if x.accel > 0.0:
            start = x.accel + x.accel_lead
            x.accel *= 1.0 - p.cut * cut / x.dt
            x.accel_lead = (start if wait > 0.0 else start * (1.0 - p.cut)) - x.accel
