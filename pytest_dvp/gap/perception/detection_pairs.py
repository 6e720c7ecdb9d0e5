"""Detections matched to the objects that were there: the pairs that a perception is judged on."""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.optimize import linear_sum_assignment

from pytest_dvp.gap.compare.start_correction import BoolArray, IntArray
from pytest_dvp.gap.perception.false_objects import appearances
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

_SECTORS = 24  # of bearings
_COVERED = 0.2  # share of frames in which objects of a sector are seen: below it the detector does not look there
_LONGEST_GAP = 1000  # frames filled in at most where nothing was detected


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Frames:
    """When a detector looked, and what it could have seen.

    t (n,) [s] of the frames, also of those without a box, and period [s] between them; row (m,) frame of each
    detection; x, y (m,) [m] of detections.
    """

    t: FloatArray
    period: float
    row: IntArray
    x: FloatArray
    y: FloatArray
    log: Log

    @property
    def duration(self) -> float:
        """Time looked at [s]."""
        return len(self.t) * self.period


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Pairs:
    """Objects (k of them) at n frames, as an assumed latency and offset would show them, arrays (n, k).

    there: the object was there to be seen; seen: a detection belongs to it; dx, dy [m] detection - expected (NaN
    unseen); vx, vy [m/s] of the object; distance [m] and bearing [rad] from the ego; yaw (n,) [rad] of the ego; false:
    false objects that appeared, detections that belong to no object.
    """

    there: BoolArray
    seen: BoolArray
    dx: FloatArray
    dy: FloatArray
    vx: FloatArray
    vy: FloatArray
    distance: FloatArray
    bearing: FloatArray
    yaw: FloatArray
    false: int

    def in_field_of_view(self) -> BoolArray:
        """A mask (n, k) of the objects in directions in which the detector sees anything at all."""
        sector = np.floor((self.bearing % (2.0 * np.pi)) * _SECTORS / (2.0 * np.pi)).astype(np.int64) % _SECTORS
        reach = float(self.distance[self.seen].max()) if self.seen.any() else 0.0
        near = self.there & (self.distance <= reach)
        some = np.bincount(sector[near], minlength=_SECTORS)
        found = np.bincount(sector[self.seen], minlength=_SECTORS)
        return np.asarray(self.there & (found >= _COVERED * np.maximum(some, 1))[sector])


def frames(log: Log) -> Frames | None:
    """The frames of a log from its first to its last detection; None with fewer than two of them."""
    table = log.detections
    stamps = np.unique(table.t)
    if len(stamps) < 2:
        return None
    period = float(np.median(np.diff(stamps)))
    t = [float(stamps[0])]
    for stamp in stamps[1:]:
        lost = min(round((float(stamp) - t[-1]) / period) - 1, _LONGEST_GAP)
        last = t[-1]
        t += [last + (i + 1) * (float(stamp) - last) / (lost + 1) for i in range(lost)]
        t.append(float(stamp))
    at = np.array(t)
    row = np.searchsorted(at, table.t)
    return Frames(at, period, row.astype(np.int64), table.x, table.y, log)


def paired(f: Frames, latency: float, offset: tuple[float, float], gate: tuple[float, float]) -> Pairs:
    """Each frame's detections assigned to objects with the least sum of distances, none beyond the gate.

    gate: [m] at the ego, and its growth with distance [-]; distances count in units of it. A box of an object that had
    only just come (its track is younger than the latency) is neither seen nor false.
    """
    log, then = f.log, f.t - latency
    n, k = len(f.t), len(log.objects)
    ex, ey, yaw = (np.interp(then, log.t, _known(log, c)) for c in ("x", "y", "yaw"))
    px, py, vx, vy = (np.zeros((n, k)) for _ in range(4))
    there, new = np.zeros((n, k), dtype=np.bool_), np.zeros((n, k), dtype=np.bool_)
    for j, track in enumerate(log.objects.values()):
        px[:, j], py[:, j] = np.interp(then, track.t, track.x), np.interp(then, track.t, track.y)
        if len(track.t) > 1:
            vx[:, j] = np.interp(then, track.t, np.gradient(track.x, track.t))
            vy[:, j] = np.interp(then, track.t, np.gradient(track.y, track.t))
        there[:, j] = (then >= track.t[0] - 1e-9) & (then <= track.t[-1] + 1e-9)
        new[:, j] = (f.t >= track.t[0] - 1e-9) & (then < track.t[0])
    c, s = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
    distance = np.hypot(px - ex[:, None], py - ey[:, None])
    border = gate[0] + gate[1] * distance
    wx, wy = px + c * offset[0] - s * offset[1], py + s * offset[0] + c * offset[1]
    seen = np.zeros((n, k), dtype=np.bool_)
    dx, dy = np.full((n, k), np.nan), np.full((n, k), np.nan)
    stray: list[IntArray] = [np.zeros(0, dtype=np.int64)]
    order = np.argsort(f.row, kind="stable")
    bounds = np.searchsorted(f.row[order], np.arange(n + 1))
    for i in range(n):
        rows = order[bounds[i] : bounds[i + 1]]
        if not len(rows):
            continue
        far = np.hypot(f.x[rows, None] - wx[i], f.y[rows, None] - wy[i])
        cost = np.where(there[i] | new[i], np.minimum(far / border[i], 1.0), 1.0)
        taken = []
        for a, b in zip(*linear_sum_assignment(cost), strict=True):
            if cost[a, b] >= 1.0:
                continue
            taken.append(a)
            if there[i, b]:
                seen[i, b] = True
                dx[i, b], dy[i, b] = f.x[rows[a]] - wx[i, b], f.y[rows[a]] - wy[i, b]
        stray.append(np.delete(rows, taken))
    bearing = np.arctan2(py - ey[:, None], px - ex[:, None]) - yaw[:, None]
    alone = np.concatenate(stray)
    false = appearances(f.t[f.row[alone]], f.x[alone], f.y[alone])
    return Pairs(there, seen, dx, dy, vx, vy, distance, bearing, yaw, false)


def _known(log: Log, name: str) -> FloatArray:
    values = log.columns[name]
    if name == "yaw":
        values = np.unwrap(np.where(np.isfinite(values), values, 0.0))
    return np.where(np.isfinite(values), values, 0.0)
