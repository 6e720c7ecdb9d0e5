"""Which rows of a detection table a sensor stands behind, and which a tracker has only moved on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.logs.log_contents import DetectionTable

MOVED_ON = 0.005  # m from where the velocity leads: rounding to centimetres; a measurement scatters more; chosen


def fresh(table: DetectionTable) -> NDArray[np.bool_]:
    """Rows (n,) that a measurement has corrected since the row before of the same track.

    A tracker that has seen nothing moves a track on at the velocity it had, or repeats it, so an unchanged velocity and
    a box that is where this velocity leads, or still at its place, say that nothing was seen. The velocity alone does
    not: one that is rounded, or set to 0 for what is slow, often stays the same. Without numbers of tracks, or for a
    track whose velocity never changes, every row counts as measured.
    """
    if table.track is None or not np.isfinite(table.track).any():
        return np.ones(len(table.t), dtype=np.bool_)
    order = np.lexsort((table.t, table.track))
    track, vx, vy = table.track[order], table.vx[order], table.vy[order]
    same = np.zeros(len(order), dtype=np.bool_)
    same[1:] = (track[1:] == track[:-1]) & (vx[1:] == vx[:-1]) & (vy[1:] == vy[:-1])
    dt, dx, dy = (np.diff(values[order], prepend=0.0) for values in (table.t, table.x, table.y))
    moved_on = np.hypot(dx - vx * dt, dy - vy * dt) <= MOVED_ON
    bridged = same & (moved_on | ((dx == 0.0) & (dy == 0.0)))
    first = np.concatenate([[True], track[1:] != track[:-1]])
    of = np.cumsum(first) - 1
    never = np.bincount(of, weights=same) >= np.bincount(of) - 1  # all but the first are as the one before
    measured = np.empty(len(order), dtype=np.bool_)
    measured[order] = ~bridged | never[of]
    return measured


def measured_only(table: DetectionTable) -> DetectionTable:
    """The table without the rows that a tracker has only moved on; the table itself if there are none."""
    kept = fresh(table)
    return table if kept.all() else table.rows(kept)
