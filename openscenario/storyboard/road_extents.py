"""How far bodies reach along and across a road that may bend beneath them."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING

from openscenario.road.positions import RoadPosition
from openscenario.storyboard.entity import Entity

if TYPE_CHECKING:
    from openscenario.storyboard.ground import Ground

STRAIGHT = 1e-9  # 1/m


def road_extent(ground: Ground, entity: Entity, here: RoadPosition, *, lateral: bool) -> tuple[float, float]:
    """How far a box reaches from its reference point in s, or in t: low, high [m].

    The road is taken for an arc with the curvature that it has at `here`, the place of the reference point: exact on
    lines and arcs. Source: ASAM OpenSCENARIO XML 1.3, 6.4 (distances in road coordinates are differences of s and t).
    """
    network = ground.network
    assert network is not None
    bend = network.curvature(here.road, here.s)
    c, s = math.cos(here.h_road), math.sin(here.h_road)
    corners = []
    for x, y in entity.corners():
        dx, dy = x - entity.x, y - entity.y
        corners.append((c * dx + s * dy, c * dy - s * dx))
    if abs(bend) < STRAIGHT:
        reach = [across if lateral else along for along, across in corners]
        return min(reach), max(reach)
    # as seen from the centre of the arc, in units of its radius; the reference line is at distance 1
    seen = [(1.0 - bend * (here.t + across), bend * along) for along, across in corners]
    if lateral:
        far, near = max(math.hypot(*corner) for corner in seen), _nearest(seen)
        reach = [(1.0 - far) / bend - here.t, (1.0 - near) / bend - here.t]
    else:
        reach = [math.atan2(ahead, side) / bend for side, ahead in seen]
    return min(reach), max(reach)


def _nearest(polygon: list[tuple[float, float]]) -> float:
    """Distance of the origin from the edges of a polygon."""
    best = math.inf
    for (x, y), (u, v) in pairwise([*polygon, polygon[0]]):
        dx, dy = u - x, v - y
        square = dx * dx + dy * dy
        share = min(max(-(x * dx + y * dy) / square, 0.0), 1.0) if square > 0.0 else 0.0
        best = min(best, math.hypot(x + share * dx, y + share * dy))
    return best
