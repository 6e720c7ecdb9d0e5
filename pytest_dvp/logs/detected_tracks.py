"""Road users as a stack saw them: detections joined to tracks, and tracks of two runs matched to each other.

A log's detections carry no identity, and two runs name nothing alike; both are found by assignment. Places are
compared in the map; the courses are those relative to the ego, which is what the perception measures.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.optimize import linear_sum_assignment

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

REACH = 3.0  # m between where a track was expected and a detection that still belongs to it
LOST = 1.0  # s without a detection after which a track ends
LEAST = 1.0  # s; shorter tracks are no road user
SAME = 5.0  # m: two tracks of one road user are no farther apart on average, once their clocks are shifted
NEAR = 1.0  # m: tracks that are no farther apart as they are need no shift; what perception is off by tells none
SHIFTS = np.arange(-4.0, 4.01, 0.25)  # s; two drives meet the same road user a little apart in time
_TICK = 1e-6  # s
_FAR = 1e6  # m; stands for no match: no object is so far away


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class SeenTrack:
    """One road user as detected: t (n,) [s]; x, y (n,) [m] in the map; ahead, left (n,) [m] of the ego as the stack
    believed it to stand."""

    kind: str
    t: FloatArray
    x: FloatArray
    y: FloatArray
    ahead: FloatArray
    left: FloatArray

    @property
    def duration(self) -> float:
        """Time from the first to the last detection [s]."""
        return float(self.t[-1] - self.t[0])


def seen_tracks(log: Log) -> list[SeenTrack]:
    """The tracks of a log's detections, in the order of their beginnings; those shorter than LEAST are left out."""
    table = log.detections
    open_rows: list[list[int]] = []
    closed: list[list[int]] = []
    kinds = np.array(table.kind)
    starts = np.flatnonzero(np.diff(table.t, prepend=-np.inf) > _TICK)
    for begin, end in zip(starts, np.append(starts[1:], len(table.t)), strict=False):
        t = float(table.t[begin])
        closed += [rows for rows in open_rows if t - table.t[rows[-1]] > LOST]
        open_rows = [rows for rows in open_rows if t - table.t[rows[-1]] <= LOST]
        last = np.array([rows[-1] for rows in open_rows], dtype=np.int64)
        taken: set[int] = set()
        if len(last):
            ahead = t - table.t[last]
            x, y = table.x[last] + ahead * table.vx[last], table.y[last] + ahead * table.vy[last]
            apart = np.hypot(table.x[begin:end] - x[:, None], table.y[begin:end] - y[:, None])
            apart = np.where((kinds[begin:end] == kinds[last][:, None]) & (apart <= REACH), apart, _FAR)
            for i, j in zip(*linear_sum_assignment(apart), strict=True):
                if apart[i, j] < _FAR:
                    open_rows[i].append(int(begin + j))
                    taken.add(int(begin + j))
        open_rows += [[row] for row in range(int(begin), int(end)) if row not in taken]
    tracks = [_track(log, np.array(rows)) for rows in (*closed, *open_rows)]
    return sorted((track for track in tracks if track.duration >= LEAST), key=lambda track: float(track.t[0]))


def _track(log: Log, rows: np.ndarray[tuple[int], np.dtype[np.int64]]) -> SeenTrack:
    table = log.detections
    t, x, y = table.t[rows], table.x[rows], table.y[rows]
    # The estimate of a tick stands in the log from that tick on, and with it the stack put its detections on the map.
    at = np.clip(np.searchsorted(log.t, t + _TICK, side="right") - 1, 0, len(log.t) - 1)
    pose = [log.columns[f"ads.{name}" if f"ads.{name}" in log.columns else name][at] for name in ("x", "y", "yaw")]
    dx, dy, c, s = x - pose[0], y - pose[1], np.cos(pose[2]), np.sin(pose[2])
    return SeenTrack(table.kind[int(rows[0])], t, x, y, dx * c + dy * s, dy * c - dx * s)


def matched_tracks(first: Log, second: Log) -> list[tuple[SeenTrack, SeenTrack, float]]:
    """What two runs saw of one and the same road users: `matched` of the tracks of both logs."""
    return matched(seen_tracks(first), seen_tracks(second))


def matched(first: list[SeenTrack], second: list[SeenTrack]) -> list[tuple[SeenTrack, SeenTrack, float]]:
    """Tracks of two runs that are one road user, by the assignment that puts them nearest to each other in the map, and
    by how much [s] the second clock is shifted for that (> 0: the second met it later).

    Two tracks of one kind can be the same if, with one clock shifted, they are within SAME on average over half of the
    shorter one. A road user that stands tells no shift: of equal ones the least counts.
    """
    if not first or not second:
        return []
    table = np.array([[_apart(a, b) for b in second] for a in first])
    pairs = zip(*linear_sum_assignment(table[:, :, 0]), strict=True)
    return [(first[i], second[j], float(table[i, j, 1])) for i, j in pairs if table[i, j, 0] <= SAME]


def _apart(a: SeenTrack, b: SeenTrack) -> tuple[float, float]:
    """Least mean distance [m] over the shifts of the clock, and that shift [s]."""
    if a.kind != b.kind:
        return _FAR, 0.0
    least, best, need = _FAR, 0.0, 0.5 * min(a.duration, b.duration)
    for shift in sorted(SHIFTS, key=abs):
        if least <= NEAR and best == 0.0:
            break
        start, end = max(a.t[0], b.t[0] - shift), min(a.t[-1], b.t[-1] - shift)
        if end - start < need:
            continue
        t = np.linspace(start, end, 50)
        dx = np.interp(t, a.t, a.x) - np.interp(t + shift, b.t, b.x)
        dy = np.interp(t, a.t, a.y) - np.interp(t + shift, b.t, b.y)
        apart = float(np.mean(np.hypot(dx, dy)))
        if apart < least - 0.1 or (apart < least + 0.1 and abs(shift) < abs(best)):
            least, best = min(apart, least), float(shift)
    return least, best
