"""Boundaries: lane borders as polylines, for pictures."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np

from machine_code import compiled
from openscenario.road.lanes import centre_offset, outer_border
from openscenario.road.pose import reference, slopes
from openscenario.road.profile import Floats
from openscenario.road.tables import (
    LANE_DIRECTION,
    LANE_DRIVABLE,
    ROAD_FLAT,
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
            left = int(sections[section, SECTION_LEFT])
            borders = range(left, -int(sections[section, SECTION_RIGHT]) - 1, -1)
            kinds = [_kind(tables, section, border) for border in borders]
            if any(kinds):
                points = border_points(tables, road, section, start, end, count)
                found.extend(
                    Boundary(kind, points[left - border])
                    for border, kind in zip(borders, kinds, strict=True)
                    if kind is not None
                )
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


@compiled
def border_points(tables: Tables, road: int, section: int, start: float, end: float, count: int) -> Floats:
    """x, y [m] of `count` points between two s [m] on all borders of a section, leftmost first, (borders, count, 2)."""
    sections = tables[5]
    left, right = sections[section, SECTION_LEFT], sections[section, SECTION_RIGHT]
    centre = sections[section, SECTION_CENTRE]
    flat = tables[3][road, ROAD_FLAT]
    points = np.empty((left + right + 1, count, 2))
    for number in range(count):
        s = start + (end - start) * number / (count - 1)
        middle = centre_offset(tables, road, s)
        x, y, heading, _, _ = reference(tables, road, s)
        dx, dy = -math.sin(heading), math.cos(heading)
        if not flat:  # where the turned cross-section leads, as in `surface_pose`
            _, z1, _, roll, _ = slopes(tables, road, s)
            lean = -z1 / math.sqrt(1.0 + z1 * z1) * math.sin(roll)
            c = math.cos(roll)
            dx, dy = c * dx + lean * dy, c * dy - lean * dx
        for side in (1, -1):
            value = middle
            for step in range(1 if side < 0 else 0, (left if side > 0 else right) + 1):
                if step > 0:
                    value = outer_border(tables, centre - side * step, side, s, value)
                place = left - side * step
                points[place, number, 0], points[place, number, 1] = x + dx * value[0], y + dy * value[0]
    return points
