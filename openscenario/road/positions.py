"""Positions on a road network, as its functions take and return them."""

from __future__ import annotations

from typing import NamedTuple


class Pose(NamedTuple):
    """A pose in the world: x, y, z [m]; heading, pitch, roll [rad], pitch > 0 nose down, roll > 0 left side up."""

    x: float
    y: float
    z: float
    h: float
    pitch: float
    roll: float


class RoadPosition(NamedTuple):
    """A place on a road: s, t, offset from the lane's middle [m]; road heading [rad]; whether a lane holds it."""

    road: str
    lane: int
    s: float
    t: float
    offset: float
    h_road: float
    on_road: bool
