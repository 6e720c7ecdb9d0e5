"""A place in the world as a storyboard handles it."""

from __future__ import annotations

import math
from typing import NamedTuple

TWO_PI = 2.0 * math.pi


class RoadPoint(NamedTuple):
    """Road coordinates: lane id as in the file, s along the reference line, offset from the lane's centre [m]."""

    road: str
    lane: int
    s: float
    offset: float


class Place(NamedTuple):
    """World pose [m, rad]; `road` if it was given in road coordinates, `has_heading` if a heading was given."""

    x: float
    y: float
    z: float
    h: float
    pitch: float = 0.0
    roll: float = 0.0
    road: RoadPoint | None = None
    has_heading: bool = True


def wrap(angle: float) -> float:
    """The angle [rad] in (-pi, pi]."""
    if -math.pi < angle <= math.pi:
        return angle
    angle = math.fmod(angle, TWO_PI)
    if angle > math.pi:
        return angle - TWO_PI
    return angle + TWO_PI if angle <= -math.pi else angle
