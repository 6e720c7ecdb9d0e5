"""Branches: where lanes of a connecting road meet a main road between its ends, in a virtual junction.

The main road goes on as if nothing was there: traffic leaves it only along a route, and comes onto it where the
connecting road ends. A connection counts if its connecting road is linked to the main road at a station (`elementS`).
Source: ASAM OpenDRIVE 1.8, 12.7 (virtual junctions).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from openscenario.road.elements import Junction, Road
from openscenario.road.links import LaneEnd, end_lanes
from openscenario.road.tables import (
    LANE_DIRECTION,
    ROAD_SECTION,
    ROAD_SECTION_END,
    SECTION_CENTRE,
    SECTION_LEFT,
    SECTION_RIGHT,
    Tables,
)


class Branch(NamedTuple):
    """A lane of a main road (its number), s [m] there, and the end of a connecting road's lane that meets it."""

    road: int
    lane: int
    s: float
    end: LaneEnd


def make_branches(roads: Sequence[Road], junctions: Iterable[Junction]) -> tuple[Branch, ...]:
    """All branches, in the order of the file."""
    numbers = {road.id: number for number, road in enumerate(roads)}
    found = []
    for junction in junctions:
        for connection in junction.connections if junction.type == "virtual" else ():
            main, connecting = numbers.get(connection.incoming), numbers.get(connection.connecting)
            if main is None or connecting is None:
                continue
            at_end = connection.contact == "end"
            link = roads[connecting].successor if at_end else roads[connecting].predecessor
            if link is None or link.s is None or link.id != connection.incoming:
                continue
            if not 0.0 <= link.s <= roads[main].length:
                continue
            known = [lane.id for lane in end_lanes(roads[connecting], at_end)]
            here = [section for section in roads[main].sections if section.s <= link.s][-1:]
            lanes = [lane.id for section in here for lane in section.lanes]
            for source, target in connection.lane_links:
                if source in lanes and target in known and source and target:
                    found.append(Branch(main, source, link.s, LaneEnd(connecting, target, at_end)))
    return tuple(found)


def stations(branches: Sequence[Branch]) -> dict[int, list[float]]:
    """Where lane sections of a main road (its number) are cut, so that ways can leave it there: ascending s [m]."""
    found: dict[int, set[float]] = {}
    for branch in branches:
        found.setdefault(branch.road, set()).add(branch.s)
    return {road: sorted(places) for road, places in found.items()}


def leaves(tables: Tables, branch: Branch) -> bool:
    """Whether traffic leaves the main road there (else it comes onto it)."""
    return (_direction(tables, _end_row(tables, branch.end)) > 0) != branch.end.at_end


def branch_rows(tables: Tables, branches: Sequence[Branch]) -> dict[int, list[int]]:
    """Lane rows that traffic may go on to between the ends of main roads, by the lane row that it comes from."""
    spans, sections = tables[4], tables[5]
    pieces: dict[int, tuple[dict[float, int], dict[float, int]]] = {}  # of a road, by where they begin and end
    found: dict[int, list[int]] = {}
    for branch in branches:
        if branch.road not in pieces:
            first, last = (int(tables[3][branch.road, each]) for each in (ROAD_SECTION, ROAD_SECTION_END))
            begins, ends = ({round(float(spans[row, side]), 6): row for row in range(first, last)} for side in (0, 1))
            pieces[branch.road] = begins, ends
        beside = _end_row(tables, branch.end)
        out = leaves(tables, branch)
        for side, sign in ((0, -1), (1, 1)):  # the piece that begins there, the piece that ends there
            piece = pieces[branch.road][side].get(round(branch.s, 6))
            if piece is None or not -sections[piece, SECTION_RIGHT] <= branch.lane <= sections[piece, SECTION_LEFT]:
                continue
            row = int(sections[piece, SECTION_CENTRE]) - branch.lane
            if sign * _direction(tables, row) * (1 if out else -1) > 0:
                found.setdefault(row if out else beside, []).append(beside if out else row)
    return found


def _end_row(tables: Tables, end: LaneEnd) -> int:
    roads, sections = tables[3], tables[5]
    section = int(roads[end.road, ROAD_SECTION_END]) - 1 if end.at_end else int(roads[end.road, ROAD_SECTION])
    return int(sections[section, SECTION_CENTRE]) - end.lane


def _direction(tables: Tables, row: int) -> int:
    return int(tables[6][row, LANE_DIRECTION])
