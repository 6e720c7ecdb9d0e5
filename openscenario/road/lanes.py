"""Lanes: which section and lane row holds at (road, lane, s), and where a lane's centre and borders lie."""

from __future__ import annotations

from machine_code import compiled
from openscenario.road.profile import profile
from openscenario.road.tables import (
    LANE_BORDER,
    LANE_DRIVABLE,
    LANE_WIDTH,
    LANE_WIDTH_END,
    ROAD_OFFSET,
    ROAD_OFFSET_END,
    ROAD_SECTION,
    ROAD_SECTION_END,
    SECTION_CENTRE,
    SECTION_LEFT,
    SECTION_RIGHT,
    Tables,
)


@compiled
def section_at(tables: Tables, road: int, s: float) -> int:
    """Row of the lane section that holds at s [m]; the first or last one outside the road."""
    roads, spans = tables[3], tables[4]
    low = roads[road, ROAD_SECTION]
    high = roads[road, ROAD_SECTION_END]
    while high - low > 1:
        middle = (low + high) // 2
        if spans[middle, 0] <= s:
            low = middle
        else:
            high = middle
    return int(low)


@compiled
def lane_row(tables: Tables, section: int, lane: int) -> int:
    """Row of a lane in a section, -1 if the section has no such lane."""
    sections = tables[5]
    if lane > sections[section, SECTION_LEFT] or -lane > sections[section, SECTION_RIGHT]:
        return -1
    return int(sections[section, SECTION_CENTRE] - lane)


@compiled
def outer_border(
    tables: Tables, row: int, side: int, s: float, inner: tuple[float, float, float]
) -> tuple[float, float, float]:
    """t [m] of the border of a lane away from the centre, with two derivatives by s, from that of its inner border.

    side: +1 left of the reference line, -1 right of it.
    """
    cubics, lanes = tables[1], tables[6]
    value = profile(cubics, lanes[row, LANE_WIDTH], lanes[row, LANE_WIDTH_END], s)
    if lanes[row, LANE_BORDER]:
        return value
    return inner[0] + side * value[0], inner[1] + side * value[1], inner[2] + side * value[2]


@compiled
def centre_offset(tables: Tables, road: int, s: float) -> tuple[float, float, float]:
    """t [m] of the centre lane (lane offset) with two derivatives."""
    cubics, roads = tables[1], tables[3]
    return profile(cubics, roads[road, ROAD_OFFSET], roads[road, ROAD_OFFSET_END], s)


@compiled
def lane_centre(tables: Tables, road: int, section: int, lane: int, s: float) -> tuple[float, float, float, float]:
    """t [m] of a lane's middle at s with two derivatives, and the lane's width [m]; NaN where there is no such lane."""
    if lane_row(tables, section, lane) < 0:
        return float("nan"), float("nan"), float("nan"), float("nan")
    inner = centre_offset(tables, road, s)
    if lane == 0:
        return inner[0], inner[1], inner[2], 0.0
    side = 1 if lane > 0 else -1
    centre = tables[5][section, SECTION_CENTRE]
    outer = inner
    for step in range(1, abs(lane) + 1):
        inner = outer
        outer = outer_border(tables, centre - side * step, side, s, inner)
    width = side * (outer[0] - inner[0])
    return 0.5 * (inner[0] + outer[0]), 0.5 * (inner[1] + outer[1]), 0.5 * (inner[2] + outer[2]), width


@compiled
def nearest_lane(
    tables: Tables, road: int, s: float, t: float, drivable: bool, only: int
) -> tuple[int, float, float, float]:
    """Lane nearest to (s, t): its id, t and width of its middle [m], distance [m] of t outside it (0 inside).

    Lane 0 with an infinite distance stands for none. drivable: consider drivable lanes only; only: those of one side
    (-1 right, 1 left, 0 both). Lanes of no width count only if nothing else is there.
    """
    sections, lanes = tables[5], tables[6]
    section = section_at(tables, road, s)
    start = centre_offset(tables, road, s)
    best_lane, best_middle, best_width, best = 0, start[0], 0.0, float("inf")
    centre = sections[section, SECTION_CENTRE]
    for side in (-1, 1):
        if only == -side:
            continue
        count = sections[section, SECTION_RIGHT] if side < 0 else sections[section, SECTION_LEFT]
        outer = start
        for step in range(1, count + 1):
            row = centre - side * step
            inner = outer
            outer = outer_border(tables, row, side, s, inner)
            if drivable and not lanes[row, LANE_DRIVABLE]:
                continue
            middle = 0.5 * (inner[0] + outer[0])
            width = side * (outer[0] - inner[0])
            outside = abs(t - middle) - 0.5 * width
            if width < 1e-3:
                outside = max(outside, 0.0) + 1e-3
            elif outside < 1e-9:
                outside = 0.0
            if outside < best:
                best_lane, best_middle, best_width, best = side * step, middle, width, outside
    return best_lane, best_middle, best_width, best
