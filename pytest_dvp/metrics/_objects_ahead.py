"""Road users ahead of the ego, and how far from each the nearest detection of its kind is."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray, ObjectTrack
from pytest_dvp.metrics._ego_box import ego_size
from pytest_dvp.metrics.metric import NotNegative, Positive

SAME_TIME = 1e-6  # s
SETTLED = 1.0  # s in the corridor until an object counts; a tracker needs some scans

Reach: TypeAlias = Positive  # m; of the options of all metrics of what is ahead
Beside: TypeAlias = NotNegative  # m
Within: TypeAlias = Positive  # m


def objects_ahead(log: Log, reach: float, beside: float, within: float) -> list[tuple[str, FloatArray, FloatArray]]:
    """(name, times, distance to the nearest detection of its kind, NaN if none is `within`) of what was ahead.

    Times in [s], lengths in [m], arrays of shape (n,).
    """
    table = log.detections
    found = []
    for name, track in log.objects.items():
        rows = np.flatnonzero(settled_ahead(log, track, reach, beside))
        if not len(rows):
            continue
        of_kind = np.array([kind == track.kind for kind in table.kind], dtype=bool)
        t, x, y = table.t[of_kind], table.x[of_kind], table.y[of_kind]
        first = np.searchsorted(t, track.t[rows] - SAME_TIME)
        count = np.searchsorted(t, track.t[rows] + SAME_TIME) - first
        nearest = np.full(len(rows), np.inf)
        for k in range(int(count.max())):
            there = count > k
            at, of = first[there] + k, rows[there]
            nearest[there] = np.minimum(nearest[there], np.hypot(x[at] - track.x[of], y[at] - track.y[of]))
        found.append((name, track.t[rows], np.where(nearest <= within, nearest, np.nan)))
    return found


def settled_ahead(log: Log, track: ObjectTrack, reach: float, beside: float) -> NDArray[np.bool_]:
    """Which rows of a track were ahead of the ego, for SETTLED seconds at least, shape (n,); [m] as `is_ahead`."""
    inside = is_ahead(log, track.t, track.x, track.y, reach, beside)
    entered = np.where(inside & ~np.concatenate([[False], inside[:-1]]), track.t, -np.inf)
    since = np.maximum.accumulate(entered)  # when the present stay began
    return np.asarray(inside & (track.t - since >= SETTLED - SAME_TIME))


def is_ahead(log: Log, t: FloatArray, x: FloatArray, y: FloatArray, reach: float, beside: float) -> NDArray[np.bool_]:
    """Which points x, y (n,) [m] at t [s] were up to `reach` [m] before the bumper and `beside` [m] to a side."""
    front = ego_size(log)[2] + 0.5 * ego_size(log)[0]
    ego = [np.interp(t, log.t, log[column]) for column in ("x", "y", "yaw")]
    dx, dy, cos, sin = x - ego[0], y - ego[1], np.cos(ego[2]), np.sin(ego[2])
    along, across = dx * cos + dy * sin - front, dy * cos - dx * sin
    return np.asarray((along > 0.0) & (along < reach) & (np.abs(across) < beside))
