"""Quality of the tracks that the stack publishes: recall, false ones, errors of place, yaw and time, identity, NEES."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics._objects_ahead import SAME_TIME, is_ahead, settled_ahead
from pytest_dvp.metrics.metric import Measured, Series, metric

REACH, BESIDE, WITHIN = 20.0, 4.0, 3.0  # m: as detection_error has them
MOVING = 1.0  # m/s; one that is slower tells little of a delay
_FAR = 1e6  # m; stands for no match: no object is so far away


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class _Matches:
    """What was ahead and what was reported there: rows of all, (n,).

    t [s] and name: of each instant of each road user ahead; row: of the detection that is it, -1 if none is.
    false_t [s], false_row: detections ahead that are nobody. truth: x, y, yaw, vx, vy (n, 5).
    """

    t: FloatArray
    names: tuple[str, ...]
    row: NDArray[np.int64]
    truth: FloatArray
    false_row: NDArray[np.int64]


@metric(name="detection_recall", unit="-", bigger_is_worse=False, open_loop=True, ideal=1.0)
def detection_recall(
    log: Log, *, reach: float = REACH, beside: float = BESIDE, within: float = WITHIN, beyond: float = 0.0
) -> Measured:
    """Share of the instants of road users ahead at which a detection was assigned to them: 1 - misses / truth.

    Ahead: from `beyond` to `reach` [m] before the bumper and `beside` [m] to a side, within `reach` for 1 s. At each
    instant detections and road users are assigned one to one, the sum of distances least, none above `within` [m]; kind
    does not count, hidden ones do. Source: CLEAR MOT, Bernardin and Stiefelhagen, EURASIP J. Image and Video Processing
    2008, 246309 (misses). t, object: first miss. Undefined if nobody was ahead.
    """
    m = _matches(log, reach, beside, within, beyond)
    if not len(m.t):
        raise Undefined("no road user was ahead of the ego")
    missed = np.flatnonzero(m.row < 0)
    first = missed[np.argmin(m.t[missed])] if len(missed) else None
    return Measured(
        1.0 - len(missed) / len(m.t),
        None if first is None else float(m.t[first]),
        "" if first is None else m.names[first],
    )


@metric(name="false_tracks", unit="s", bigger_is_worse=True, open_loop=True)
def false_tracks(
    log: Log, *, reach: float = REACH, beside: float = BESIDE, within: float = WITHIN, beyond: float = 0.0
) -> Measured:
    """Time in which detections ahead belong to no road user, summed over them: two at once count twice.

    Ahead and assigned as in `detection_recall`; one within `within` [m] of any road user is no false one, but a double.
    Source: false positives of CLEAR MOT, Bernardin and Stiefelhagen 2008, times the step of the detections. t: the
    first. Undefined if the stack reported no detection at all.
    """
    if not len(log.detections.t):
        raise Undefined("the stack reported no detections")
    rows = _matches(log, reach, beside, within, beyond).false_row
    step = _step(np.unique(log.detections.t), log)
    t = log.detections.t[rows]
    return Measured(len(rows) * step, float(t.min()) if len(t) else None)


@metric(name="track_position_error", unit="m", bigger_is_worse=True, open_loop=True, note="mean over assigned ones")
def track_position_error(
    log: Log, *, reach: float = REACH, beside: float = BESIDE, within: float = WITHIN, beyond: float = 0.0
) -> Measured:
    """Mean distance between the middles of road users ahead and of the detections assigned to them.

    Assigned as in `detection_recall`. Source: multiple object tracking precision (MOTP), Bernardin and Stiefelhagen
    2008. The greatest is in `extra`. Undefined if nobody ahead was detected.
    """
    m, seen = _seen(log, reach, beside, within, beyond)
    error = np.hypot(*_offset(log, m, seen))
    return _worst(m, seen, error, float(error.mean()), {"greatest": float(error.max())})


@metric(name="track_yaw_error", unit="rad", bigger_is_worse=True, open_loop=True, note="root mean square, of axes")
def track_yaw_error(
    log: Log, *, reach: float = REACH, beside: float = BESIDE, within: float = WITHIN, beyond: float = 0.0
) -> Measured:
    """Root mean square of the angle between the axes of boxes ahead and of the detections assigned to them, 0 to pi/2.

    Of vehicles and bicycles only. A box turned by half a turn is the same box; the error with direction is in `extra`.
    Source: average orientation error of nuScenes, Caesar et al., CVPR 2020, of period pi. Undefined if none was
    detected.
    """
    m, seen = _seen(log, reach, beside, within, beyond)
    seen = seen[[log.objects[m.names[k]].kind in ("vehicle", "bicycle") for k in seen]]
    if not len(seen):
        raise Undefined("no vehicle or bicycle ahead of the ego was detected")
    turn = log.detections.yaw[m.row[seen]] - m.truth[seen, 2]
    error = np.abs(np.remainder(turn + 0.5 * np.pi, np.pi) - 0.5 * np.pi)
    directed = np.remainder(turn + np.pi, 2.0 * np.pi) - np.pi
    extra = {"with direction": float(np.sqrt(np.mean(directed**2)))}
    return _worst(m, seen, error, float(np.sqrt(np.mean(error**2))), extra)


@metric(name="track_latency", unit="s", bigger_is_worse=True, open_loop=True, note="of those faster than {moving} m/s")
def track_latency(
    log: Log,
    *,
    reach: float = REACH,
    beside: float = BESIDE,
    within: float = WITHIN,
    beyond: float = 0.0,
    moving: float = MOVING,
) -> Measured:
    """By how much the detections of moving road users lie behind, along their motion: least-squares delay tau.

    tau = -sum(e . v) / sum(v . v) of the position errors e and the true velocities v of those faster than `moving`
    [m/s]: the delay that explains e = -tau v best. Negative: the stack reports them ahead of where they are. A delay
    that a tracker extrapolates away does not show. Source: linear least squares. Undefined if none moved.
    """
    m, seen = _seen(log, reach, beside, within, beyond)
    v = m.truth[seen, 3:5]
    fast = np.hypot(v[:, 0], v[:, 1]) > moving
    if not fast.any():
        raise Undefined(f"no detected road user ahead was faster than {moving:g} m/s")
    seen, v = seen[fast], v[fast]
    behind = -np.sum(np.column_stack(_offset(log, m, seen)) * v, axis=1)
    speed2 = np.sum(v**2, axis=1)
    return _worst(m, seen, behind / speed2, float(behind.sum() / speed2.sum()), {})


@metric(name="identity_switches", unit="-", bigger_is_worse=True, open_loop=True)
def identity_switches(
    log: Log, *, reach: float = REACH, beside: float = BESIDE, within: float = WITHIN, beyond: float = 0.0
) -> Measured:
    """How often the track assigned to a road user ahead is another one than the last that was assigned to it.

    Source: mismatches of CLEAR MOT, Bernardin and Stiefelhagen 2008; assigned as in `detection_recall`, without their
    preference for the last one. t, object: the first switch. Undefined if the stack numbers no tracks.
    """
    numbers = log.detections.track
    if numbers is None or not np.isfinite(numbers).any():
        raise Undefined("the detections carry no number of their track (Detection.track)")
    m, seen = _seen(log, reach, beside, within, beyond)
    last: dict[str, float] = {}
    count, when, who = 0, None, ""
    for k in seen[np.argsort(m.t[seen], kind="stable")]:
        number = float(numbers[m.row[k]])
        if not np.isfinite(number):
            continue
        if last.get(m.names[k], number) != number:
            count += 1
            if when is None:
                when, who = float(m.t[k]), m.names[k]
        last[m.names[k]] = number
    return Measured(float(count), when, who)


@metric(name="nees", unit="-", bigger_is_worse=None, open_loop=True, ideal=2.0, note="mean; 2 is consistent")
def nees(
    log: Log, *, reach: float = REACH, beside: float = BESIDE, within: float = WITHIN, beyond: float = 0.0
) -> Measured:
    """Mean normalised estimation error squared of the positions: e' P^-1 e with the covariance P that the stack states.

    Two degrees of freedom, so 2 where the stack is as sure as it may be; greater: too sure, less: not sure enough.
    Source: Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), section
    5.4.2. Assigned as in `detection_recall`. Undefined if the stack states no covariance.
    """
    table = log.detections
    if table.cov_xx is None or table.cov_xy is None or table.cov_yy is None:
        raise Undefined("the detections carry no covariance (Detection.covariance)")
    m, seen = _seen(log, reach, beside, within, beyond)
    xx, xy, yy = (c[m.row[seen]] for c in (table.cov_xx, table.cov_xy, table.cov_yy))
    stated = (xx > 0.0) & (xx * yy - xy**2 > 0.0)
    if not stated.any():
        raise Undefined("no detection of a road user ahead carries a positive definite covariance")
    seen, xx, xy, yy = seen[stated], xx[stated], xy[stated], yy[stated]
    ex, ey = _offset(log, m, seen)
    error = (yy * ex**2 - 2.0 * xy * ex * ey + xx * ey**2) / (xx * yy - xy**2)
    return _worst(m, seen, error, float(error.mean()), {"greatest": float(error.max()), "samples": float(len(error))})


def _seen(log: Log, reach: float, beside: float, within: float, beyond: float) -> tuple[_Matches, NDArray[np.int64]]:
    """The matches, and the indices of those that were detected. Raises Undefined if there is none."""
    m = _matches(log, reach, beside, within, beyond)
    if not len(m.t):
        raise Undefined("no road user was ahead of the ego")
    seen = np.flatnonzero(m.row >= 0)
    if not len(seen):
        raise Undefined("no road user ahead of the ego was detected")
    return m, seen


def _offset(log: Log, m: _Matches, seen: NDArray[np.int64]) -> tuple[FloatArray, FloatArray]:
    """Detected minus true position [m] in the map frame, each (k,)."""
    rows = m.row[seen]
    return log.detections.x[rows] - m.truth[seen, 0], log.detections.y[rows] - m.truth[seen, 1]


def _worst(m: _Matches, seen: NDArray[np.int64], error: FloatArray, value: float, extra: dict[str, float]) -> Measured:
    k = int(np.argmax(np.abs(error)))
    order = np.argsort(m.t[seen], kind="stable")
    series = Series(m.t[seen][order], error[order])
    return Measured(value, float(m.t[seen[k]]), m.names[seen[k]], series, extra)


def _step(times: FloatArray, log: Log) -> float:
    """Time between two instants of detections [s]: the median; of the road users, where there is but one."""
    if len(times) > 1:
        return float(np.median(np.diff(times)))
    return next((float(np.median(np.diff(o.t))) for o in log.objects.values() if len(o.t) > 1), 0.0)


def _matches(log: Log, reach: float, beside: float, within: float, beyond: float) -> _Matches:
    table = log.detections
    ahead = {name: settled_ahead(log, track, reach, beside) for name, track in log.objects.items()}
    near = is_ahead(log, table.t, table.x, table.y, reach, beside) if len(table.t) else np.zeros(0, dtype=bool)
    if beyond > 0.0:
        for name, track in log.objects.items():
            ahead[name] &= ~is_ahead(log, track.t, track.x, track.y, beyond, beside)
        near[near] = ~is_ahead(log, table.t[near], table.x[near], table.y[near], beyond, beside)
    t: list[float] = []
    names: list[str] = []
    row: list[int] = []
    truth: list[tuple[float, ...]] = []
    false: list[int] = []
    for now, rows, there in _instants(log):
        every = np.array([_state(log, name, k) for name, k in there]).reshape(-1, 5)
        apart = np.hypot(table.x[rows] - every[:, :1], table.y[rows] - every[:, 1:2])
        of = _assigned(apart, within)
        for i, (name, k) in enumerate(there):
            if ahead[name][k]:
                t.append(now)
                names.append(name)
                row.append(int(rows[of[i]]) if i in of else -1)
                truth.append(tuple(every[i]))
        alone = ~(apart <= within).any(axis=0) if len(there) else np.ones(len(rows), dtype=bool)
        false += rows[alone & near[rows]].tolist()
    return _Matches(
        np.array(t),
        tuple(names),
        np.array(row, dtype=np.int64),
        np.array(truth).reshape(-1, 5),
        np.array(false, dtype=np.int64),
    )


def _instants(log: Log) -> Iterator[tuple[float, NDArray[np.int64], list[tuple[str, int]]]]:
    """Time, rows of the detections and (name, row) of the road users of each instant at which there are any."""
    table = log.detections
    keys = {name: np.round(track.t / SAME_TIME).astype(np.int64) for name, track in log.objects.items()}
    seen = np.round(table.t / SAME_TIME).astype(np.int64)
    where = {name: {int(k): i for i, k in enumerate(key)} for name, key in keys.items()}
    every = np.unique(np.concatenate([seen, *keys.values()])) if keys or len(seen) else seen
    start, stop = np.searchsorted(seen, every, "left"), np.searchsorted(seen, every, "right")
    for key, a, b in zip(every.tolist(), start, stop, strict=True):
        there = [(name, rows[key]) for name, rows in where.items() if key in rows]
        yield key / 1e6, np.arange(a, b), there


def _state(log: Log, name: str, k: int) -> tuple[float, ...]:
    track = log.objects[name]
    return track.x[k], track.y[k], track.yaw[k], track.vx[k], track.vy[k]


def _assigned(apart: FloatArray, within: float) -> dict[int, int]:
    """Column of each row that is assigned one: one to one, most within `within`, then the sum of distances least."""
    if not apart.size:
        return {}
    cost = np.where(apart <= within, apart, _FAR)
    if apart.shape[0] == 1:
        k = int(np.argmin(cost[0]))
        return {0: k} if cost[0, k] < _FAR else {}
    from scipy.optimize import linear_sum_assignment

    return {int(i): int(j) for i, j in zip(*linear_sum_assignment(cost), strict=True) if cost[i, j] < _FAR}
