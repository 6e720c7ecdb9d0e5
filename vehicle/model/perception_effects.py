"""Effects of perception: what a detector makes of the objects that are there.

They act on tracks, never on the car; the kernel ignores them. A function of slot "perception" gets (tracks, p, rng) and
returns other tracks. While the twin drives, `vehicle.sensors.perceived` calls them at each look, so that the LiDAR and
the camera see what is left: an effect of order LOOKS_BACK or less is then given the looks of the last seconds and must
draw nothing; a later one is given the rows of one look.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt

from vehicle.messages import FloatArray

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import AppliedEffect

LOOKS_BACK = 10  # order; effects up to it need what was seen before


def _none() -> FloatArray:
    return np.zeros(0)


def _no_kind() -> npt.NDArray[np.int64]:
    return np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, slots=True)
class Tracks:
    """Objects as seen at stamps, one row each.

    t (n,) [s] not decreasing; object (n,) its number (-1: none that exists); x, y (n,) [m] box centre on the map; yaw
    (n,) [rad]; vx, vy (n,) [m/s] on the map; ego pose at the row's stamp: ego_x, ego_y (n,) [m], ego_yaw (n,) [rad];
    length, width (n,) [m] of the box; kind (n,), an index into `vehicle.messages.OBJECT_KINDS`. The last three are
    zeros if they are left out.
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
    length: FloatArray = field(default_factory=_none)
    width: FloatArray = field(default_factory=_none)
    kind: npt.NDArray[np.int64] = field(default_factory=_no_kind)

    def __post_init__(self) -> None:
        for name in ("length", "width", "kind"):
            if len(getattr(self, name)) != len(self.t):
                object.__setattr__(self, name, np.zeros(len(self.t), dtype=getattr(self, name).dtype))

    def rows(self, chosen: npt.NDArray[Any]) -> Tracks:
        """Only the rows chosen by a mask (n,) or by their numbers (m,)."""
        return Tracks(*(getattr(self, name)[chosen] for name in TRACK_COLUMNS))

    def distance(self) -> FloatArray:
        """From the ego's reference point to the box centre (n,) [m]."""
        return np.asarray(np.hypot(self.x - self.ego_x, self.y - self.ego_y))

    def moved(self, forward: npt.ArrayLike, left: npt.ArrayLike) -> Tracks:
        """Positions shifted in the ego's frame [m]."""
        c, s = np.cos(self.ego_yaw), np.sin(self.ego_yaw)
        forward, left = np.asarray(forward), np.asarray(left)
        return replace(self, x=self.x + forward * c - left * s, y=self.y + forward * s + left * c)


TRACK_COLUMNS: tuple[str, ...] = (
    "t", "object", "x", "y", "yaw", "vx", "vy", "ego_x", "ego_y", "ego_yaw", "length", "width", "kind"
)  # fmt: skip


class EffectValues:
    """Parameters by attribute, as compiled effects see them."""

    def __init__(self, values: Mapping[str, float]) -> None:
        self.__dict__.update(values)


def perception_in(effects: Iterable[AppliedEffect]) -> list[AppliedEffect]:
    """Those of slot "perception" that are on, in the order in which they act."""
    chosen = [a for a in effects if a.effect.slot == "perception" and not a.effect.is_off(a.values)]
    return sorted(chosen, key=lambda a: (a.effect.order, a.name))


def apply_perception_effects(effects: Iterable[AppliedEffect], tracks: Tracks, rng: np.random.Generator) -> Tracks:
    """What a detector with these effects shows of `tracks`; effects of other slots and neutral ones change nothing."""
    for applied in perception_in(effects):
        tracks = perceive(applied, tracks, rng)
    return tracks


def perceive(applied: AppliedEffect, tracks: Tracks, rng: np.random.Generator) -> Tracks:
    """What one effect of slot "perception" makes of `tracks`."""
    function = cast("Any", applied.effect.function)
    shown: Tracks = function(tracks, EffectValues(applied.values), rng)
    return shown
