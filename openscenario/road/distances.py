"""Distances: the way along reference lines between places on different roads."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from openscenario.road.links import LaneEnd
from openscenario.road.profile import Floats
from openscenario.road.tables import Tables

_JOINT = 1e-9  # m, length of a joint between roads: 0 would be no edge to scipy
_SLIGHT = 1e-6  # m


class RoadDistances:
    """Shortest ways between road ends; node 2 r is the start of road r, 2 r + 1 its end. Found when asked for."""

    def __init__(self, tables: Tables, links: Mapping[LaneEnd, Iterable[LaneEnd]]) -> None:
        self._lengths = [float(length) for length in tables[2]]
        edges: dict[tuple[int, int], float] = {}
        for end, others in links.items():
            for other in others:
                edges[2 * end.road + end.at_end, 2 * other.road + other.at_end] = _JOINT
        for road, length in enumerate(self._lengths):
            edges[2 * road, 2 * road + 1] = edges[2 * road + 1, 2 * road] = length
        size = 2 * len(self._lengths)
        pairs = np.array(list(edges), dtype=np.int64).reshape(-1, 2)
        self._matrix = csr_matrix((list(edges.values()), (pairs[:, 0], pairs[:, 1])), shape=(size, size))
        self._rows: dict[int, Floats] = {}

    def _from(self, node: int) -> Floats:
        """Distances from one road end to all others, not back through its own road."""
        if node not in self._rows:
            own = node ^ 1
            matrix = self._matrix.copy()
            matrix[node, own] = matrix[own, node] = math.inf
            self._rows[node] = dijkstra(matrix, indices=[node])[0]
        return self._rows[node]

    def between(self, road: int, s: float, goal: int, goal_s: float) -> tuple[float, bool]:
        """Way [m] from (road, s) to (goal, goal_s), > 0 if it sets out with increasing s; NaN if there is none.

        And whether, come that way, the goal's road runs against this one.
        """
        best, against = goal_s - s if road == goal else math.nan, False
        for exit_end, way_out, sign in ((0, s, -1.0), (1, self._lengths[road] - s, 1.0)):
            row = self._from(2 * road + exit_end)
            for entry_end, way_in in ((0, goal_s), (1, self._lengths[goal] - goal_s)):
                if road == goal and entry_end == exit_end:
                    continue
                reached = float(row[2 * goal + entry_end])
                if reached > float(row[2 * goal + 1 - entry_end]) + self._lengths[goal] - _SLIGHT:
                    continue  # through the goal's own road: it was passed on the way there
                way = way_out + reached + way_in
                if math.isfinite(way) and not way >= abs(best):
                    best, against = sign * way, exit_end == entry_end
        return best, against
