"""Route over a lane graph of 10,000 nodes: the stack's own Dijkstra, scipy's in the same run."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from ads.planning.lane_graph import quickest
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
    pairs = pairs[np.argsort(pairs[:, 0], kind="stable")]
    cost = np.random.default_rng(1).uniform(3.0, 20.0, len(pairs))  # s
    first = np.searchsorted(pairs[:, 0], np.arange(n + 1))
    target, before, far = pairs[:, 1].copy(), np.empty(n, np.int64), np.empty(n)
    matrix = csr_matrix((cost, (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    found = quickest(first, target, cost, 0, n - 1, before, far)
    assert np.isclose(found, dijkstra(matrix, indices=0)[n - 1])
    ours = cpu_seconds(lambda: quickest(first, target, cost, 0, n - 1, before, far))
    peer = cpu_seconds(lambda: dijkstra(matrix, indices=[0], return_predecessors=True))
    note = f"from corner to corner, {len(pairs)} edges"
    return [Row("quickest way, 10,000 lanes", ours * 1e3, "ms", "<= 2", "scipy's dijkstra", peer * 1e3, note)]
