"""What a car may be asked for on the ground there is, and where a drive left that."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pytest_dvp.log import FloatArray

if TYPE_CHECKING:
    from vehicle.model.car import Car

SPAN = 5  # rows over which an acceleration is taken: 0.1 s at 50 Hz
_SLACK = 1e-6  # of rounding


@dataclasses.dataclass(frozen=True, slots=True)
class Envelope:
    """Limits of a manoeuvre: max_speed [m/s], max_acceleration, max_deceleration, max_lateral [m/s^2], length and width
    of the free ground [m], max_steer [rad] and steer_rate [rad/s] at the road wheel.

    Raises ValueError: a limit that is not a positive number.
    """

    max_speed: float = 12.5
    max_acceleration: float = 2.0
    max_deceleration: float = 4.0
    max_lateral: float = 4.0
    length: float = 100.0
    width: float = 60.0
    max_steer: float = 0.45
    steer_rate: float = 1.0

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and value > 0.0):
                raise ValueError(f"envelope: {field.name} is {value:g}, expected more than 0")


class Area(NamedTuple):
    """The free ground [m] in the frame of the start: the car stands at 0, 0 and looks along x."""

    x_min: float
    x_max: float
    y_min: float
    y_max: float

    def room(self, x: float, y: float, yaw: float) -> float:
        """Way [m] from a place to the border, straight on; negative outside."""
        c, s = math.cos(yaw), math.sin(yaw)
        inside = min(x - self.x_min, self.x_max - x, y - self.y_min, self.y_max - y)
        if inside < 0.0:
            return inside
        along_x = ((self.x_max if c > 0.0 else self.x_min) - x) / c if abs(c) > 1e-9 else math.inf
        along_y = ((self.y_max if s > 0.0 else self.y_min) - y) / s if abs(s) > 1e-9 else math.inf
        return min(along_x, along_y)

    def inset(self, x: float, y: float) -> Area:
        """The area less a strip of x [m] at both ends and of y at both sides."""
        return Area(self.x_min + x, self.x_max - x, self.y_min + y, self.y_max - y)


def violations(t: FloatArray, motion: FloatArray, steer: FloatArray, envelope: Envelope, area: Area,
               car: Car) -> tuple[str, ...]:  # fmt: skip
    """What a drive exceeded, in words; empty if it kept within the envelope.

    t (n,) [s], evenly spaced; motion (n, 5): x, y [m] of the rear axle, yaw [rad], v [m/s], yaw rate [rad/s], as they
    were, not as sensors show them; steer (n,) asked for [rad].
    """
    x, y, yaw, v, rate = motion.T
    along = (v[SPAN:] - v[:-SPAN]) / (t[SPAN:] - t[:-SPAN])
    told = []
    for what, found, limit, unit in (
        ("speed", np.max(np.abs(v)), envelope.max_speed, "m/s"),
        ("acceleration", np.max(along, initial=0.0), envelope.max_acceleration, "m/s^2"),
        ("deceleration", -np.min(along, initial=0.0), envelope.max_deceleration, "m/s^2"),
        ("lateral acceleration", np.max(np.abs(v * rate)), envelope.max_lateral, "m/s^2"),
        ("steering", np.max(np.abs(steer)), envelope.max_steer, "rad"),
    ):
        if not found <= limit * (1.0 + _SLACK):
            told.append(f"{what} {found:.3g}, at most {limit:g} {unit}")
    ahead, behind, side = car.center_x + 0.5 * car.length, car.center_x - 0.5 * car.length, 0.5 * car.width
    out = 0.0
    for u, w in ((ahead, side), (ahead, -side), (behind, side), (behind, -side)):
        px, py = x + u * np.cos(yaw) - w * np.sin(yaw), y + u * np.sin(yaw) + w * np.cos(yaw)
        out = max(out, float(np.max([area.x_min - px, px - area.x_max, area.y_min - py, py - area.y_max])))
    if out > _SLACK:
        told.append(f"the area of {envelope.length:g} x {envelope.width:g} m, by {out:.2g} m")
    return tuple(told)
