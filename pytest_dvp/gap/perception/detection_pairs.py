"""Detections matched to the objects that were there: the pairs that a perception is judged on."""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.optimize import linear_sum_assignment

from pytest_dvp.gap.compare.start_correction import BoolArray, IntArray
from pytest_dvp.gap.perception.false_objects import appearances
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

CLEAR = 0.05  # share of an object behind others up to which it counts as in clear view
_SECTORS = 24  # of bearings
_COVERED = 0.2  # of the share of looks in which the detector sees what is there: below it, it does not look to a sector
_DOUBLE = 1.0  # m from an object's ends: a second box within it is a double of the object, and no false object
_DEEP = 0.15  # of the distance; so far off a camera alone may put an object
_LONGEST_GAP = 1000  # frames filled in at most where nothing was detected
_ONE_LOOK = 0.005  # s: boxes that come within it are of one look, each with a stamp of its own; chosen
_SHORTEST = 0.6  # of the median between looks with a box: if a tenth is shorter, most looks show none; chosen


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

    there: the object was there to be seen; seen: a detection belongs to it, `row` of the log's detections (-1: none);
    hidden: share of it that is behind nearer objects, 0 to 1; dx, dy [m] detection - expected (NaN
    unseen); vx, vy [m/s] of the object; distance [m] and bearing [rad] from the ego; yaw (n,) [rad] of the ego; false:
    false objects that appeared, detections that belong to no object.
    """

    there: BoolArray
    seen: BoolArray
    row: IntArray
    hidden: FloatArray
    dx: FloatArray
    dy: FloatArray
    vx: FloatArray
    vy: FloatArray
    distance: FloatArray
    bearing: FloatArray
    yaw: FloatArray
    false: int

    def in_field_of_view(self) -> BoolArray:
        """A mask (n, k) of the objects in directions in which the detector sees anything at all of what is in clear
        view: at least a fifth of what it sees where it sees something, for it may miss most of what it looks at."""
        sector = np.floor((self.bearing % (2.0 * np.pi)) * _SECTORS / (2.0 * np.pi)).astype(np.int64) % _SECTORS
        reach = float(self.distance[self.seen].max(initial=0.0))
        clear = self.hidden <= CLEAR
        near = self.there & clear & (self.distance <= reach)
        some = np.bincount(sector[near], minlength=_SECTORS)
        found = np.bincount(sector[self.seen & clear], minlength=_SECTORS)
        share = found / np.maximum(some, 1)
        usual = float(found @ share) / max(float(found.sum()), 1.0)  # of the sectors, each as often as it saw something
        return np.asarray(self.there & ((found > 0) & (share >= _COVERED * usual))[sector])


def frames(log: Log) -> Frames | None:
    """The frames of a log from its first to its last detection; None with fewer than two of them.

    Boxes within _ONE_LOOK are of one frame, that of the first.
    """
    table = log.detections
    every = np.unique(table.t)
    begins: list[float] = []
    for stamp in every.tolist():
        if not begins or stamp - begins[-1] > _ONE_LOOK:
            begins.append(stamp)
    stamps = np.array(begins)
    if len(stamps) < 2:
        return None
    period = _period(np.diff(stamps))
    t = [float(stamps[0])]
    for stamp in stamps[1:]:
        lost = min(round((float(stamp) - t[-1]) / period) - 1, _LONGEST_GAP)
        last = t[-1]
        t += [last + (i + 1) * (float(stamp) - last) / (lost + 1) for i in range(lost)]
        t.append(float(stamp))
    at = np.array(t)
    row = np.searchsorted(at, stamps[np.searchsorted(stamps, table.t, side="right") - 1])
    return Frames(at, period, row.astype(np.int64), table.x, table.y, log)


def _period(between: FloatArray) -> float:
    """Time [s] between looks from that between those with a box, (n,): if most looks show nothing, the median is a
    multiple of it. The single time is then the most frequent one; of two sensors that look in turns, it is not."""
    median, short = float(np.median(between)), float(np.quantile(between, 0.1))
    if short >= _SHORTEST * median:
        return median
    single = between[between < 1.5 * short]
    return float(np.median(single)) if 2 * len(single) >= np.count_nonzero(between < 2.5 * short) else median


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
    near = _DOUBLE + 0.5 * np.array([track.length for track in log.objects.values()])
    seen, own = np.zeros((n, k), dtype=np.bool_), np.full((n, k), -1, dtype=np.int64)
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
                seen[i, b], own[i, b] = True, rows[a]
                dx[i, b], dy[i, b] = f.x[rows[a]] - wx[i, b], f.y[rows[a]] - wy[i, b]
        double = (far <= near + _DEEP * distance[i])[:, there[i] | new[i]].any(axis=1)
        double[taken] = True
        stray.append(rows[~double])
    bearing = np.arctan2(py - ey[:, None], px - ex[:, None]) - yaw[:, None]
    alone = np.concatenate(stray)
    false = appearances(f.t[f.row[alone]], f.x[alone], f.y[alone])
    return Pairs(
        there, seen, own, _hidden(f, there, px, py, (ex, ey, yaw)), dx, dy, vx, vy, distance, bearing, yaw, false
    )


def _known(log: Log, name: str) -> FloatArray:
    values = log.columns[name]
    known = np.isfinite(values)
    if not known.any():
        return np.zeros(len(values))
    seen = np.unwrap(values[known]) if name == "yaw" else values[known]
    return np.asarray(np.interp(log.t, log.t[known], seen))


def _hidden(
    f: Frames, there: BoolArray, px: FloatArray, py: FloatArray, ego: tuple[FloatArray, FloatArray, FloatArray]
) -> FloatArray:
    """Share (n, k) of each object that is behind nearer ones; 0 of one that is not there."""
    from vehicle.model.occlusion import hidden_share
    from vehicle.model.perception_effects import Tracks

    frame, thing = np.nonzero(there)
    objects = list(f.log.objects.values())
    yaw = np.column_stack([np.interp(f.t, track.t, np.unwrap(track.yaw)) for track in objects])
    share = np.zeros(there.shape)
    share[frame, thing] = hidden_share(Tracks(
        t=f.t[frame], object=thing.astype(np.int64), x=px[frame, thing], y=py[frame, thing], yaw=yaw[frame, thing],
        vx=np.zeros(len(frame)), vy=np.zeros(len(frame)), ego_x=ego[0][frame], ego_y=ego[1][frame],
        ego_yaw=ego[2][frame], length=np.array([track.length for track in objects])[thing],
        width=np.array([track.width for track in objects])[thing],
    ))  # fmt: skip
    return share
