"""What a car may be asked for on the ground there is; standard library only, as the help of every command needs it."""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple


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
