"""Effects of perception: what a detector makes of the objects that are there.

They act on tracks, never on the car; the kernel ignores them. A function of slot "perception" gets (tracks, p, rng) and
returns other tracks.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt

from vehicle.messages import FloatArray

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import AppliedEffect


@dataclass(frozen=True, slots=True)
class Tracks:
    """Objects as seen at stamps, one row each.

    t (n,) [s] not decreasing; object (n,) its number (-1: none that exists); x, y (n,) [m] box centre on the map; yaw
    (n,) [rad]; vx, vy (n,) [m/s] on the map; ego pose at the row's stamp: ego_x, ego_y (n,) [m], ego_yaw (n,) [rad].
    """

    t: FloatArray
    object: npt.NDArray[np.int64]
    x: FloatArray
    y: FloatArray
    yaw: FloatArray
    vx: FloatArray
    vy: FloatArray
    ego_x: FloatArray
    ego_y: FloatArray
    ego_yaw: FloatArray

    def rows(self, chosen: npt.NDArray[Any]) -> Tracks:
        """Only the rows chosen by a mask or by their numbers."""
        return Tracks(*(getattr(self, name)[chosen] for name in TRACK_COLUMNS))

    def distance(self) -> FloatArray:
        """From the ego's reference point to the box centre (n,) [m]."""
        return np.asarray(np.hypot(self.x - self.ego_x, self.y - self.ego_y))

    def moved(self, forward: npt.ArrayLike, left: npt.ArrayLike) -> Tracks:
        """Positions shifted in the ego's frame [m]."""
        c, s = np.cos(self.ego_yaw), np.sin(self.ego_yaw)
        forward, left = np.asarray(forward), np.asarray(left)
        return replace(self, x=self.x + forward * c - left * s, y=self.y + forward * s + left * c)


TRACK_COLUMNS: tuple[str, ...] = ("t", "object", "x", "y", "yaw", "vx", "vy", "ego_x", "ego_y", "ego_yaw")


class _Values:
    """Parameters by attribute, as compiled effects see them."""

    def __init__(self, values: Mapping[str, float]) -> None:
        self.__dict__.update(values)


def apply_perception_effects(effects: Iterable[AppliedEffect], tracks: Tracks, rng: np.random.Generator) -> Tracks:
    """What a detector with these effects shows of `tracks`; effects of other slots and neutral ones change nothing."""
    chosen = [a for a in effects if a.effect.slot == "perception" and not a.effect.is_off(a.values)]
    for applied in sorted(chosen, key=lambda a: (a.effect.order, a.name)):
        function = cast("Any", applied.effect.function)
        tracks = function(tracks, _Values(applied.values), rng)
    return tracks
