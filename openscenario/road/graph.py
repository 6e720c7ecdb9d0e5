"""LaneGraph: drivable lanes of lane sections as nodes, ways between them as edges with a cost in metres."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from openscenario.road.links import LaneEnd
from openscenario.road.profile import Floats, Ints
from openscenario.road.tables import (
    LANE_DIRECTION,
    LANE_DRIVABLE,
    LANE_ID,
    LANE_PREDECESSOR,
    LANE_SECTION,
    LANE_SUCCESSOR,
    ROAD_SECTION,
    ROAD_SECTION_END,
    SECTION_ROAD,
    Tables,
)

CHANGE_COST = 30.0  # m of detour that one lane change is worth


@dataclass(frozen=True)
class LaneGraph:
    """nodes (n, 3): road number, section row, lane id; edges (m, 2): node numbers; costs (m,) [m].

    An edge along the road costs the length of the node it leaves; a lane change CHANGE_COST. `rows` (n,) are lane rows
    of the tables, `node_of` (lanes,) the node of a lane row or -1, `changes` (m,) marks lane changes.
    """

    nodes: Ints
    edges: Ints
    costs: Floats
    rows: Ints
    node_of: Ints
    changes: NDArray[np.bool_]

    def matrix(self) -> csr_matrix:
        """Costs as a sparse matrix, for scipy.sparse.csgraph."""
        size = len(self.nodes)
        return csr_matrix((self.costs, (self.edges[:, 0], self.edges[:, 1])), shape=(size, size))


def make_graph(
    tables: Tables, links: Mapping[LaneEnd, tuple[LaneEnd, ...]], branches: Mapping[int, Sequence[int]]
) -> LaneGraph:
    """Graph of all drivable lanes; `branches`: further lane rows to go on to from a lane row, as in `branches.py`."""
    spans, sections, lanes = tables[4], tables[5], tables[6]
    rows = np.flatnonzero(lanes[:, LANE_DRIVABLE] == 1)
    node_of = np.full(len(lanes), -1, dtype=np.int64)
    node_of[rows] = np.arange(len(rows))
    edges: list[tuple[int, int]] = []
    costs: list[float] = []
    changes: list[bool] = []
    for node, row in enumerate(rows.tolist()):
        section = int(lanes[row, LANE_SECTION])
        length = max(float(spans[section, 1] - spans[section, 0]), 0.0)
        for target in (*next_rows(tables, links, row), *branches.get(row, ())):
            if node_of[target] >= 0:
                edges.append((node, int(node_of[target])))
                costs.append(length)
                changes.append(False)
        for beside in (row - 1, row + 1):  # rows of a section follow each other from left to right
            if 0 <= beside < len(lanes) and lanes[beside, LANE_SECTION] == section and lanes[beside, LANE_ID] == 0:
                beside += beside - row  # the centre lane has no width: the lane beyond it is the neighbour
            if not 0 <= beside < len(lanes) or lanes[beside, LANE_SECTION] != section or node_of[beside] < 0:
                continue
            if lanes[beside, LANE_DIRECTION] == lanes[row, LANE_DIRECTION]:
                edges.append((node, int(node_of[beside])))
                costs.append(CHANGE_COST)
                changes.append(True)
    of = lanes[rows, LANE_SECTION]
    return LaneGraph(
        nodes=np.stack([sections[of, SECTION_ROAD], of, lanes[rows, LANE_ID]], axis=1),
        edges=np.array(edges, dtype=np.int64).reshape(-1, 2),
        costs=np.array(costs, dtype=np.float64),
        rows=rows,
        node_of=node_of,
        changes=np.array(changes, dtype=bool),
    )


def next_rows(tables: Tables, links: Mapping[LaneEnd, tuple[LaneEnd, ...]], row: int) -> list[int]:
    """Lane rows that traffic on a lane row goes on to."""
    roads, sections, lanes = tables[3], tables[5], tables[6]
    section = int(lanes[row, LANE_SECTION])
    road = int(sections[section, SECTION_ROAD])
    forward = lanes[row, LANE_DIRECTION] > 0
    border = roads[road, ROAD_SECTION_END] - 1 if forward else roads[road, ROAD_SECTION]
    if section != border:
        target = int(lanes[row, LANE_SUCCESSOR if forward else LANE_PREDECESSOR])
        return [target] if target >= 0 else []
    found = []
    for end in links.get(LaneEnd(road, int(lanes[row, LANE_ID]), bool(forward)), ()):
        other = int(roads[end.road, ROAD_SECTION_END]) - 1 if end.at_end else int(roads[end.road, ROAD_SECTION])
        target = int(sections[other, 0]) - end.lane
        # entering at the start means driving with s there, at the end against it
        if (lanes[target, LANE_DIRECTION] > 0) != end.at_end:
            found.append(target)
    return found
