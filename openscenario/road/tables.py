"""Tables: a road network flattened to plain arrays, which all compiled functions take as one tuple.

geometry  (n, 20) float   rows of shapes.py
cubics    (m, 5)  float   s, a, b, c, d of every profile; t, a, b, c, d of shapes; s, first row, end of cross-sections
lengths   (r,)    float   road lengths [m]
roads     (r, 14) int     row ranges of a road, see ROAD_*
spans     (q, 2)  float   s of start and end of each lane section [m]
sections  (q, 4)  int     row of the centre lane, number of left and right lanes, road
lanes     (k, 12) int     see LANE_*
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from openscenario.road.elements import Cubic, Lane, LaneHeight, Road, Shape, lane_direction
from openscenario.road.profile import Floats, Ints
from openscenario.road.shapes import COLUMNS, geometry_rows

Tables: TypeAlias = tuple[Floats, Floats, Floats, Ints, Floats, Ints, Ints]

(
    ROAD_GEOMETRY,
    ROAD_GEOMETRY_END,
    ROAD_ELEVATION,
    ROAD_ELEVATION_END,
    ROAD_SUPERELEVATION,
    ROAD_SUPERELEVATION_END,
    ROAD_OFFSET,
    ROAD_OFFSET_END,
    ROAD_SECTION,
    ROAD_SECTION_END,
    ROAD_RULE,  # +1 right-hand, -1 left-hand traffic
    ROAD_FLAT,  # 1: no elevation, superelevation, shape or lane height anywhere
    ROAD_SHAPE,  # its cross-sections
    ROAD_SHAPE_END,
) = range(14)
SECTION_CENTRE, SECTION_LEFT, SECTION_RIGHT, SECTION_ROAD = range(4)
(
    LANE_ID,
    LANE_WIDTH,
    LANE_WIDTH_END,
    LANE_BORDER,  # 1: the width rows are borders
    LANE_HEIGHT,
    LANE_HEIGHT_END,
    LANE_DRIVABLE,
    LANE_PREDECESSOR,  # lane row it comes from in the section before, in the same road; -1 none
    LANE_SUCCESSOR,
    LANE_SECTION,
    LANE_LEVEL,
    LANE_DIRECTION,  # +1 traffic runs with increasing s, -1 against it
) = range(12)


NO_CUTS: Mapping[int, Sequence[float]] = MappingProxyType({})
_SHORTEST = 1e-3  # m of a piece of a section


class _Rows:
    """Growing list of cubic rows, from which ranges are cut."""

    def __init__(self) -> None:
        self.rows: list[tuple[float, float, float, float, float]] = []

    def cubics(self, records: Sequence[Cubic], start: float = 0.0) -> tuple[int, int]:
        first = len(self.rows)
        self.rows.extend((start + r.s, r.a, r.b, r.c, r.d) for r in records)
        return first, len(self.rows)

    def shapes(self, records: Sequence[Shape]) -> tuple[int, int]:
        """Rows of all records, and behind them one a cross-section, whose range is returned."""
        sections: list[tuple[float, float, float, float, float]] = []
        for s, group in groupby(records, key=lambda record: record.s):
            first = len(self.rows)
            self.rows.extend((r.t, r.a, r.b, r.c, r.d) for r in group)
            sections.append((s, float(first), float(len(self.rows)), 0.0, 0.0))
        start = len(self.rows)
        self.rows.extend(sections)
        return start, len(self.rows)

    def heights(self, records: Sequence[LaneHeight], start: float) -> tuple[int, int]:
        if not any(r.inner or r.outer for r in records):
            return 0, 0
        first = len(self.rows)
        self.rows.extend((start + r.s, r.inner, r.outer, 0.0, 0.0) for r in records)
        return first, len(self.rows)


def make_tables(roads: Sequence[Road], cuts: Mapping[int, Sequence[float]] = NO_CUTS) -> Tables:
    """Flatten roads, in file order; `cuts`: s [m] at which sections of a road (its number) are cut into pieces."""
    geometry: list[list[float]] = []
    cubics = _Rows()
    road_rows: list[tuple[int, ...]] = []
    spans: list[tuple[float, float]] = []
    sections: list[tuple[int, int, int, int]] = []
    lanes: list[list[int]] = []
    for index, road in enumerate(roads):
        rule = 1 if road.rule == "RHT" else -1
        first_geometry = len(geometry)
        for element in road.geometries:
            geometry.extend(geometry_rows(element))
        elevation = cubics.cubics(road.elevations)
        superelevation = cubics.cubics(road.superelevations)
        offset = cubics.cubics(road.lane_offsets)
        shape = cubics.shapes(road.shapes)
        first_section = len(sections)
        first_lane = len(lanes)
        _add_sections(road, index, rule, cubics, spans, sections, lanes, cuts.get(index, ()))
        flat = not any(
            r[1] or r[2] or r[3] or r[4] for pair in (elevation, superelevation) for r in cubics.rows[slice(*pair)]
        )
        flat = (
            flat
            and shape[0] == shape[1]
            and not any(lane[LANE_HEIGHT_END] > lane[LANE_HEIGHT] for lane in lanes[first_lane:])
        )
        ranges = (first_geometry, len(geometry), *elevation, *superelevation, *offset, first_section, len(sections))
        road_rows.append((*ranges, rule, int(flat), *shape))
    return (
        np.array(geometry, dtype=np.float64).reshape(-1, COLUMNS),
        np.array(cubics.rows, dtype=np.float64).reshape(-1, 5),
        np.array([road.length for road in roads], dtype=np.float64),
        np.array(road_rows, dtype=np.int64).reshape(-1, 14),
        np.array(spans, dtype=np.float64).reshape(-1, 2),
        np.array(sections, dtype=np.int64).reshape(-1, 4),
        np.array(lanes, dtype=np.int64).reshape(-1, 12),
    )


def driving_signs(tables: Tables) -> list[tuple[list[float], list[dict[int, int]]]]:
    """LANE_DIRECTION by lane for each section of each road, beside the s [m] at which the sections begin.

    Plain Python, as one of them is asked for often, and a compiled call with all tables takes ten times as long.
    """
    _, _, _, roads, spans, sections, lanes = tables
    found = []
    for first, end in roads[:, ROAD_SECTION : ROAD_SECTION_END + 1].tolist():
        signs = []
        for centre, left, right, _ in sections[first:end].tolist():
            ids = range(left, -right - 1, -1)
            rows = lanes[centre - left : centre + right + 1, LANE_DIRECTION].tolist()
            signs.append(dict(zip(ids, rows, strict=True)))
        found.append((spans[first:end, 0].tolist(), signs))
    return found


def _add_sections(
    road: Road,
    index: int,
    rule: int,
    cubics: _Rows,
    spans: list[tuple[float, float]],
    sections: list[tuple[int, int, int, int]],
    lanes: list[list[int]],
    cuts: Sequence[float],
) -> None:
    """Append the sections and lanes of one road; links inside the road become lane rows."""
    pieces: list[tuple[int, int]] = []  # first and last row of each section of the file
    for number, section in enumerate(road.sections):
        end = road.sections[number + 1].s if number + 1 < len(road.sections) else road.length
        stations = [section.s, *(s for s in cuts if section.s + _SHORTEST < s < end - _SHORTEST), end]
        pieces.append((len(sections), len(sections) + len(stations) - 2))
        right = len(section.lanes) - 1 - section.left
        spans.append((section.s, stations[1]))
        sections.append((len(lanes) + section.left, section.left, right, index))
        first_lane = len(lanes)
        for lane in section.lanes:
            by_border = not lane.widths and bool(lane.borders)
            width = cubics.cubics(lane.borders if by_border else lane.widths, section.s)
            height = cubics.heights(lane.heights, section.s)
            direction = lane_direction(lane.id, rule, lane.direction == "reversed")
            row = [lane.id, *width, int(by_border), *height, int(lane.drivable), -1, -1, len(sections) - 1]
            lanes.append([*row, int(lane.level), direction])
        for piece in range(1, len(stations) - 1):
            _add_piece(len(section.lanes), first_lane, piece, lanes)
            spans.append((stations[piece], stations[piece + 1]))
            sections.append((first_lane + piece * len(section.lanes) + section.left, section.left, right, index))
    for number in range(len(road.sections) - 1):
        here, there = sections[pieces[number][1]], sections[pieces[number + 1][0]]
        _link(road.sections[number].lanes, here, road.sections[number + 1].lanes, there, lanes)


def _add_piece(count: int, first: int, piece: int, lanes: list[list[int]]) -> None:
    """The next piece of a section of `count` lanes, whose piece 0 has its lanes from row `first` on."""
    for number in range(count):
        row = list(lanes[first + number])
        row[LANE_SECTION] += piece
        row[LANE_PREDECESSOR], row[LANE_SUCCESSOR] = -1, -1
        before = len(lanes) - count
        if row[LANE_ID]:
            row[LANE_PREDECESSOR] = before
            lanes[before][LANE_SUCCESSOR] = len(lanes)
        lanes.append(row)


def _link(
    before: Sequence[Lane],
    here: tuple[int, int, int, int],
    after: Sequence[Lane],
    there: tuple[int, int, int, int],
    lanes: list[list[int]],
) -> None:
    """Connect the lanes of two successive sections; a link written on one side only counts for both.

    Files without any lane link between two sections are common: then lanes of the same id continue.
    """
    silent = not any(lane.successors for lane in before) and not any(lane.predecessors for lane in after)
    for lane in before:
        target = lane.successors[0] if lane.successors else lane.id if silent else 0
        if target and -there[SECTION_RIGHT] <= target <= there[SECTION_LEFT]:
            lanes[here[0] - lane.id][LANE_SUCCESSOR] = there[0] - target
    for lane in after:
        target = lane.predecessors[0] if lane.predecessors else lane.id if silent else 0
        if target and -here[SECTION_RIGHT] <= target <= here[SECTION_LEFT]:
            lanes[there[0] - lane.id][LANE_PREDECESSOR] = here[0] - target
    for row in range(here[0] - here[SECTION_LEFT], here[0] + here[SECTION_RIGHT] + 1):
        after_row = lanes[row][LANE_SUCCESSOR]
        if after_row >= 0 and lanes[after_row][LANE_PREDECESSOR] < 0:
            lanes[after_row][LANE_PREDECESSOR] = row
    for row in range(there[0] - there[SECTION_LEFT], there[0] + there[SECTION_RIGHT] + 1):
        before_row = lanes[row][LANE_PREDECESSOR]
        if before_row >= 0 and lanes[before_row][LANE_SUCCESSOR] < 0:
            lanes[before_row][LANE_SUCCESSOR] = row
