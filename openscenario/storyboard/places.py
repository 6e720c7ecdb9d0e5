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


def turned_in_plane(h: float, pitch: float, roll: float, yaw: float) -> tuple[float, float, float]:
    """Heading, pitch, roll [rad] of a body that turns by `yaw` about the normal of the inclined plane it stands on.

    Given are heading, pitch and roll of the plane's own axes (z, y, x, ISO 8855). In the plane the body's x axis is
    (cos yaw, sin yaw, 0), its y axis (-sin yaw, cos yaw, 0).
    """
    if pitch == 0.0 and roll == 0.0:
        return h + yaw, 0.0, 0.0
    cy, sy = math.cos(yaw), math.sin(yaw)
    cp, sp, cr, sr = math.cos(pitch), math.sin(pitch), math.cos(roll), math.sin(roll)
    up = sy * sr * cp - cy * sp  # z of the new x axis
    left = cy * sr * cp + sy * sp  # z of the new y axis
    return (
        h + math.atan2(sy * cr, cy * cp + sy * sr * sp),
        -math.asin(min(max(up, -1.0), 1.0)),
        math.atan2(left, cr * cp),
    )


def yaw_in_plane(pitch: float, roll: float, against: float) -> float:
    """The yaw [rad] about the normal of an inclined plane that makes a heading `against` that of the plane."""
    if pitch == 0.0 and roll == 0.0:
        return against
    c, s = math.cos(against), math.sin(against)
    return math.atan2(math.cos(pitch) * s, math.cos(roll) * c - math.sin(roll) * math.sin(pitch) * s)
