"""Route: the cheapest way along lanes from one place to another, and the line it draws."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from openscenario.road.graph import LaneGraph
from openscenario.road.lanes import lane_row, section_at
from openscenario.road.path import line_point, trace
from openscenario.road.profile import Floats
from openscenario.road.tables import (
    LANE_DIRECTION,
    LANE_ID,
    LANE_PREDECESSOR,
    LANE_SUCCESSOR,
    SECTION_CENTRE,
    SECTION_LEFT,
    SECTION_RIGHT,
    SECTION_ROAD,
    Tables,
)

CHANGE_LENGTH = 60.0  # m, the way over which a route's lane change is spread where there is room
_SAME = 1e-6  # m


class RouteError(ValueError):
    """There is no such place on a drivable lane, or no way between two places."""


class RouteLane(NamedTuple):
    """A stretch of a lane in driving order; s_from > s_to where traffic runs against s. [m]"""

    road: str
    lane: int
    s_from: float
    s_to: float


class Place(NamedTuple):
    """A place on a lane: road number, section row, lane id, s [m]."""

    road: int
    section: int
    lane: int
    s: float


def find_place(tables: Tables, graph: LaneGraph, road: int, lane: int, s: float, name: str) -> tuple[Place, int]:
    """The place and its graph node.

    Raises:
        RouteError: s is off the road, or the lane is not drivable there.
    """
    length = float(tables[2][road])
    if not -_SAME <= s <= length + _SAME:
        raise RouteError(f"s = {s:g} m is not on road {name}, which is {length:g} m long")
    section = section_at(tables, road, s)
    left, right = int(tables[5][section, SECTION_LEFT]), int(tables[5][section, SECTION_RIGHT])
    row = int(tables[5][section, SECTION_CENTRE]) - lane
    if not -right <= lane <= left or graph.node_of[row] < 0:
        raise RouteError(f"lane {lane} of road {name} is not drivable at s = {s:g} m")
    return Place(road, section, lane, min(max(s, 0.0), length)), int(graph.node_of[row])


def plan(tables: Tables, graph: LaneGraph, start: tuple[Place, int], goal: tuple[Place, int]) -> list[int]:
    """Graph nodes from start to goal.

    The nodes of the start's section are there twice: as the places ahead of the start, and as where a loop comes back.

    Raises:
        RouteError: no way.
    """
    (here, first), (there, last) = start, goal
    size = len(graph.nodes)
    twins = np.flatnonzero(graph.nodes[:, 1] == here.section)
    twin_of = {int(node): size + number for number, node in enumerate(twins)}
    leaving = np.isin(graph.edges[:, 0], twins)
    copied = graph.edges[leaving].copy()
    changes = graph.changes[leaving]
    copied[:, 0] = [twin_of[int(node)] for node in copied[:, 0]]
    copied[changes, 1] = [twin_of[int(node)] for node in copied[changes, 1]]
    edges = np.concatenate([graph.edges, copied])
    costs = np.concatenate([graph.costs, graph.costs[leaving]]) + 1e-9  # a cost of 0 would be no edge to scipy
    total = size + len(twins)
    matrix = csr_matrix((costs, (edges[:, 0], edges[:, 1])), shape=(total, total))
    sign = int(tables[6][graph.rows[last], LANE_DIRECTION])
    ahead = there.section == here.section and sign * (there.s - here.s) >= -_SAME
    target = twin_of[last] if ahead else last
    source = twin_of[first]
    distances, predecessors = dijkstra(matrix, indices=[source], return_predecessors=True)
    before = predecessors[0]
    if not np.isfinite(distances[0, target]):
        raise RouteError("no way leads from the start to the goal in driving direction")
    nodes = [target]
    while nodes[-1] != source:
        nodes.append(int(before[nodes[-1]]))
    return [int(twins[node - size]) if node >= size else node for node in reversed(nodes)]


def stretches(
    tables: Tables, graph: LaneGraph, nodes: Sequence[int], start: float, goal: float
) -> list[tuple[int, int, float, float]]:
    """(road number, lane, s_from, s_to) along graph nodes; lane changes are spread over their section."""
    spans, sections, lanes = tables[4], tables[5], tables[6]
    result: list[tuple[int, int, float, float]] = []
    index = 0
    while index < len(nodes):
        group = index + 1  # nodes of one section that follow each other by lane changes
        section = int(graph.nodes[nodes[index], 1])
        while group < len(nodes) and graph.nodes[nodes[group], 1] == section and group > index:
            if not _beside(graph, nodes[group - 1], nodes[group]):
                break
            group += 1
        forward = lanes[graph.rows[nodes[index]], LANE_DIRECTION] > 0
        enter, leave = (spans[section, 0], spans[section, 1]) if forward else (spans[section, 1], spans[section, 0])
        enter = start if index == 0 else float(enter)
        leave = goal if group == len(nodes) else float(leave)
        count = group - index
        share = min(abs(leave - enter) / count, CHANGE_LENGTH)
        sign = 1.0 if leave >= enter else -1.0
        at = enter
        for number in range(count):
            to = leave if number == count - 1 else enter + sign * share * (number + 1)
            lane = int(graph.nodes[nodes[index + number], 2])
            road = int(sections[section, SECTION_ROAD])
            if result and result[-1][:2] == (road, lane) and abs(result[-1][3] - at) < _SAME:
                result[-1] = (road, lane, result[-1][2], to)
            else:
                result.append((road, lane, at, to))
            at = to
        index = group
    return result


def _beside(graph: LaneGraph, a: int, b: int) -> bool:
    """Whether two nodes of a section are neighbours, not the beginning of another lap."""
    return a != b and bool(np.any(graph.changes & (graph.edges[:, 0] == a) & (graph.edges[:, 1] == b)))


def draw(tables: Tables, pieces: Sequence[tuple[int, int, float, float]], step: float) -> Floats:
    """Samples (n, 4) of x, y [m], heading in driving direction [rad, continuous], curvature [1/m], `step` [m] apart.

    The last sample is the end of the route, at most `step` after the one before.
    """
    parts = _parts(tables, pieces)
    size = int(sum(abs(part[4] - part[3]) for part in parts) * 1.5 / step) + 16
    while True:
        out = np.empty((size, 4))
        count, carry = 0, 0.0
        for part in parts:
            count, carry = trace(tables, *part, step, carry, out, count)
        if count < size:
            break
        size = count + 16
    if step - carry > 1e-6 * step or count == 0:
        road, from_lane, to_lane, s_from, s_to, first, last = parts[-1]
        sign = 1.0 if s_to >= s_from else -1.0
        out[count] = line_point(tables, road, from_lane, to_lane, s_to, first, last, sign)[:4]
        count += 1
    out = out[:count]
    out = out[np.isfinite(out).all(axis=1)]  # a lane that ends before its piece does has no end there
    out[:, 2] = np.unwrap(out[:, 2])
    return out


def _parts(
    tables: Tables, pieces: Sequence[tuple[int, int, float, float]]
) -> list[tuple[int, int, int, float, float, float, float]]:
    """(road, from lane, to lane, s_from, s_to, s where the lane change begins, s where it ends) in driving order."""
    parts: list[tuple[int, int, int, float, float, float, float]] = []
    for number, (road, lane, s_from, s_to) in enumerate(pieces):
        begin = s_to
        other = lane
        if number + 1 < len(pieces):
            next_road, next_lane, next_from, _ = pieces[number + 1]
            if next_road == road and next_lane != lane and abs(next_from - s_to) < _SAME:
                begin = _change_begin(tables, road, lane, next_lane, s_from, s_to)
                other = next_lane
        if abs(begin - s_from) > _SAME or abs(begin - s_to) <= _SAME:
            parts.append((road, lane, lane, s_from, begin, s_from, begin))
        if abs(begin - s_to) > _SAME:
            parts.append((road, lane, other, begin, s_to, begin, s_to))
    return parts


def _change_begin(tables: Tables, road: int, lane: int, other: int, s_from: float, s_to: float) -> float:
    """s [m] where the change to a neighbouring lane begins; s_to if it is the same lane in the next section."""
    sign = 1.0 if s_to >= s_from else -1.0
    section = section_at(tables, road, s_to - sign * _SAME)
    row = lane_row(tables, section, lane)
    if row < 0 or lane_row(tables, section, other) < 0:
        return s_to
    spans, lanes = tables[4], tables[6]
    border = spans[section, 1] if sign > 0.0 else spans[section, 0]
    continued = int(lanes[row, LANE_SUCCESSOR if sign > 0.0 else LANE_PREDECESSOR])
    if abs(border - s_to) < _SAME and continued >= 0 and lanes[continued, LANE_ID] == other:
        return s_to
    behind = float(spans[section, 0] if sign > 0.0 else spans[section, 1])
    room = min(abs(s_to - s_from), CHANGE_LENGTH, abs(s_to - behind))
    return s_to - sign * room
