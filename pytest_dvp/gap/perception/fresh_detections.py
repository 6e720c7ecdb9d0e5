"""Which rows of a detection table a sensor stands behind, and which a tracker has only moved on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.logs.log_contents import DetectionTable


def fresh(table: DetectionTable) -> NDArray[np.bool_]:
    """Rows (n,) that a measurement has corrected since the row before of the same track.

    A tracker that has seen nothing moves a track on at the velocity it had, so an unchanged velocity says that nothing
    was seen. Without numbers of tracks, or for a track whose velocity never changes, every row counts as measured.
    """
    if table.track is None or not np.isfinite(table.track).any():
        return np.ones(len(table.t), dtype=np.bool_)
    order = np.lexsort((table.t, table.track))
    track, vx, vy = table.track[order], table.vx[order], table.vy[order]
    same = np.zeros(len(order), dtype=np.bool_)
    same[1:] = (track[1:] == track[:-1]) & (vx[1:] == vx[:-1]) & (vy[1:] == vy[:-1])
    first = np.concatenate([[True], track[1:] != track[:-1]])
    of = np.cumsum(first) - 1
    never = np.bincount(of, weights=same) >= np.bincount(of) - 1  # all but the first are as the one before
    measured = np.empty(len(order), dtype=np.bool_)
    measured[order] = ~same | never[of]
    return measured


def measured_only(table: DetectionTable) -> DetectionTable:
    """The table without the rows that a tracker has only moved on; the table itself if there are none."""
    kept = fresh(table)
    return table if kept.all() else table.rows(kept)
