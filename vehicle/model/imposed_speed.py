"""A car whose speed is imposed or regulated: the forces that this takes, and the speed that its sensors take for it."""

from __future__ import annotations

import math
from typing import Any

from machine_code import compiled
from vehicle.model.bus import GRAVITY

LEAST_SHOWN = 0.1  # of the speed `slow`, below which a sensor's offset would count as a gain; chosen
SMOOTHED = 0.05  # s, filter of the speed that a controller sees, as `accel_controller` has; chosen


@compiled
def push_as_told(x: Any, blend: float) -> None:
    """Traction and brake are those of the motion, whatever drive and brakes are.

    blend: share of the motion with tyres, whose front ones hold the car back in a bend, as they did in the last step
    """
    need = (x.mass + x.rotating_mass) * x.accel_cmd / x.speed_gain - x.drag + x.mass * GRAVITY * math.sin(x.grade)
    need += x.resistance if x.vx >= 0.0 else -x.resistance
    if blend > 0.0:
        need += blend * (x.fy_front * math.sin(x.steer) - x.mass * x.yaw_rate * x.vy)
    if blend < 1.0 and x.bank != 0.0:
        need += (1.0 - blend) * x.mass * GRAVITY * math.sin(x.bank) * x.cg_rear * x.curvature
    x.traction = max(need, 0.0) if x.vx >= 0.0 else 0.0
    x.brake = max(need if x.vx < 0.0 else -need, 0.0)


@compiled
def _gain(x: Any) -> float:
    """Shown over true speed, 0 if a car is too slow to tell."""
    return float(x.meas_v / x.vx) if abs(x.vx) > LEAST_SHOWN * x.slow else 0.0


@compiled
def heed_shown(x: Any, dt: float, begins: bool) -> None:
    """A controller regulates the speed that sensors show: learn from a row, `dt` [s] after the last one, what they make
    of it, from the first one at once.

    Wheels slip by what the controller asks for. Without a filter, it would answer the slip of one row in the next one.
    """
    gain = _gain(x)
    if gain > 0.0:
        x.speed_gain += (gain - x.speed_gain) * (1.0 if begins else dt / (dt + SMOOTHED))


@compiled
def take_as_shown(x: Any, begins: bool, states: Any) -> None:
    """The speed is what the car's sensors show: learn from a row what they make of it, from the first one at once."""
    gain = _gain(x)
    if gain <= 0.0:
        return
    x.speed_gain = gain
    if begins:
        x.vx /= gain
        if states.shape[0] == 0 or math.isnan(states[0, 5]):
            x.yaw_rate /= gain
        x.vy = x.vy_rear + x.cg_rear * x.yaw_rate
