"""What the wind of the world does to a car."""

from __future__ import annotations

import math
from typing import Any

from machine_code import compiled


@compiled
def blow(x: Any) -> None:
    """What the world's wind changes of the forces of the air: it acts with the speed through the air, not over ground.

    Along, k u |u| takes the place of k v |v|, but a tail wind takes away no more drag than the model has: it pushes no
    car that is faster. Across, the force goes with the sine of the angle at which the air comes. It acts in the middle
    of the body. Source: M. Mitschke, H. Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed., ch. 2.
    """
    c, s = math.cos(x.yaw), math.sin(x.yaw)
    along = x.vx - (x.wind_x * c + x.wind_y * s)
    across = x.vy - (x.wind_y * c - x.wind_x * s)
    air, still = math.hypot(along, across), math.hypot(x.vx, x.vy)
    ahead = 1.0 if x.vx >= 0.0 else -1.0
    push = -ahead * x.wind_drag * air * along  # > 0: the air comes from behind
    helped = push + x.wind_drag * x.vx * x.vx
    if helped > 0.0:
        helped = min(helped, max(push, 0.0) + x.still_drag * x.vx * x.vx)
    x.drag += ahead * x.mass_ref * helped
    x.push = -x.mass_ref * x.wind_side * (air * across - still * x.vy)
