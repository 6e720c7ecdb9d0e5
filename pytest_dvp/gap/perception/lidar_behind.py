"""Whether what is partly behind something else is lost by the camera alone, or by the LiDAR as well.

Either way a stack stops to report it. But where the LiDAR goes on hitting what sticks out, it places the object by that
part, and badly; where both lose it, these bad places are not there. So it shows in how far detections are off on the
whole.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

from pytest_dvp.gap.perception.perceived_values import Perceived

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import VehicleModel

NAME, KEY = "detection_occlusion", "lidar"
BETTER = 0.92  # mean error of places over that of a twin whose LiDAR sees everything, below which a car's LiDAR does
# not; chosen: 0.81 to 0.88 in three drives of a car that loses all, 0.95 and more of one whose camera alone does
MOVES_PLACES = ("latency", "offset", "range", "misses", "noise", "size", "yaw")


def with_lidar(
    found: Perceived, shown: Perceived, twin: Perceived, model: VehicleModel, named: Collection[str]
) -> bool:
    """Puts into `found.values`, what a model needs, whether the LiDAR loses what is behind others; True if it has that
    otherwise. shown: of the car's log; twin: of a run of the model; named: effects in which the two differ.

    While other effects move places, too, these cannot tell: a model keeps what it has, and a new one takes the camera
    alone, with an interval of both.
    """
    if (NAME, "share") not in found.values:
        return False
    has = next((a.values[KEY] for a in model.effects if a.name == NAME), None)
    loses, both = has, (0.0, 1.0)
    if not {f"detection_{part}" for part in MOVES_PLACES} & set(named) and twin.error > 0.0:
        loses = float(_loses(shown.error / twin.error, has))
        both = (loses, loses)
    loses = 0.0 if loses is None else loses
    found.values[NAME, KEY] = (loses, *both)
    return has is not None and loses != has


def _loses(ratio: float, has: float | None) -> bool:
    """ratio: error of the car's places over that of the twin's."""
    if has is not None and has >= 0.5:
        return ratio <= 1.0 / BETTER
    return ratio < BETTER
