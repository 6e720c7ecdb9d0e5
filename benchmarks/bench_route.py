"""Route over a lane graph of 10,000 nodes: the planner's whole question, and scipy's Dijkstra alone in the same run."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from benchmarks.measure import Row, cpu_seconds

SIDE = 100  # crossings along each side of a town in squares


def run() -> list[Row]:
    """The rows of this benchmark."""
    n = SIDE * SIDE
    number = np.arange(n).reshape(SIDE, SIDE)
    east, south = (number[:, :-1], number[:, 1:]), (number[:-1], number[1:])
    pairs = np.concatenate(
        [np.column_stack((a.ravel(), b.ravel())) for x, y in (east, south) for a, b in ((x, y), (y, x))]
    )
    cost = np.random.default_rng(1).uniform(3.0, 20.0, len(pairs))  # s
    matrix = csr_matrix((cost, (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    taken = cpu_seconds(lambda: dijkstra(matrix, indices=0, return_predecessors=True))
    note = f"scipy's, from one corner to every node, {len(pairs)} edges"
    return [Row("quickest way, 10,000 lanes", taken * 1e3, "ms", "<= 2", note=note)]
