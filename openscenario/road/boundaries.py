"""Boundaries: lane borders as polylines, for pictures."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np
from numba import njit

from openscenario.road.lanes import centre_offset, outer_border
from openscenario.road.pose import surface_pose
from openscenario.road.profile import Floats
from openscenario.road.tables import (
    LANE_DIRECTION,
    LANE_DRIVABLE,
    ROAD_SECTION,
    ROAD_SECTION_END,
    SECTION_CENTRE,
    SECTION_LEFT,
    SECTION_RIGHT,
    Tables,
)

MOST_POINTS = 100_000  # of one border in one lane section
Kind = Literal["edge", "lane", "centre"]


class Boundary(NamedTuple):
    """A lane border, points (n, 2) [m]: edge of the carriageway, between lanes, or between driving directions."""

    kind: Kind
    points: Floats


def make_boundaries(tables: Tables, step: float) -> list[Boundary]:
    """Borders of all drivable lanes, sampled every `step` [m] of s or less, road by road, left to right."""
    roads, spans, sections = tables[3], tables[4], tables[5]
    found: list[Boundary] = []
    for road in range(len(roads)):
        for section in range(roads[road, ROAD_SECTION], roads[road, ROAD_SECTION_END]):
            start, end = float(spans[section, 0]), float(spans[section, 1])
            if end - start < 1e-6:
                continue
            count = min(max(2, math.ceil((end - start) / step) + 1), MOST_POINTS)
            for border in range(int(sections[section, SECTION_LEFT]), -int(sections[section, SECTION_RIGHT]) - 1, -1):
                kind = _kind(tables, section, border)
                if kind is not None:
                    found.append(Boundary(kind, border_points(tables, road, section, border, start, end, count)))
    return found


def _kind(tables: Tables, section: int, border: int) -> Kind | None:
    """Kind of the outer border of lane `border` (0: the centre line); None where no vehicle drives beside it."""
    lanes = tables[6]
    centre = int(tables[5][section, SECTION_CENTRE])
    left, right = int(tables[5][section, SECTION_LEFT]), int(tables[5][section, SECTION_RIGHT])
    # lane ids on the left and on the right of the border
    above = border + 1 if border >= 0 else border
    below = border if border > 0 else border - 1
    rows = [centre - lane for lane in (above, below) if lane != 0 and -right <= lane <= left]
    drivable = [row for row in rows if lanes[row, LANE_DRIVABLE]]
    if not drivable:
        return None
    if len(drivable) < 2:
        return "edge"
    return "lane" if lanes[drivable[0], LANE_DIRECTION] == lanes[drivable[1], LANE_DIRECTION] else "centre"


@njit(cache=True, error_model="numpy")
def border_points(tables: Tables, road: int, section: int, border: int, start: float, end: float, count: int) -> Floats:
    """x, y [m] of `count` points on a border between two s [m], shape (count, 2)."""
    points = np.empty((count, 2))
    side = 1 if border > 0 else -1
    for number in range(count):
        s = start + (end - start) * number / (count - 1)
        value = centre_offset(tables, road, s)
        for step in range(1, abs(border) + 1):
            value = outer_border(tables, tables[5][section, SECTION_CENTRE] - side * step, side, s, value)
        pose = surface_pose(tables, road, s, value[0], 0.0, 0.0)
        points[number, 0], points[number, 1] = pose[0], pose[1]
    return points
