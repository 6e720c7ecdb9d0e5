"""Quality of the tracks that the stack publishes: recall, false ones, errors of place, yaw and time, identity, NEES."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics._objects_ahead import SAME_TIME, is_ahead, settled_ahead
from pytest_dvp.metrics._once_a_log import once_a_log
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


@once_a_log
def _matches(log: Log, reach: float, beside: float, within: float, beyond: float) -> _Matches:
    table = log.detections
    tracks = list(log.objects.values())
    ahead = [settled_ahead(log, track, reach, beside) for track in tracks]
    near = is_ahead(log, table.t, table.x, table.y, reach, beside) if len(table.t) else np.zeros(0, dtype=bool)
    if beyond > 0.0:
        for k, track in enumerate(tracks):
            ahead[k] &= ~is_ahead(log, track.t, track.x, track.y, beyond, beside)
        near[near] = ~is_ahead(log, table.t[near], table.x[near], table.y[near], beyond, beside)
    there, pairs = _side_by_side(log)
    close = pairs.apart <= within
    false = near.copy()
    false[pairs.detection[close]] = False
    seen = _assigned(pairs, close, len(there.t))
    rows = np.flatnonzero([ahead[who][k] for who, k in zip(there.who, there.k, strict=True)])
    names = tuple(log.objects)
    return _Matches(
        there.t[rows],
        tuple(names[who] for who in there.who[rows]),
        seen[rows],
        there.state[rows],
        np.flatnonzero(false),
    )


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class _There:
    """Each instant of each road user, (n,), in the order of time: t [s], who (its number), k (row of its track) and
    state: x, y, yaw, vx, vy (n, 5)."""

    t: FloatArray
    who: NDArray[np.int64]
    k: NDArray[np.int64]
    state: FloatArray


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class _Pairs:
    """Each detection beside each road user of its instant, (m,): instant, row in _There, row of the detection, and
    their distance [m]."""

    instant: NDArray[np.int64]
    there: NDArray[np.int64]
    detection: NDArray[np.int64]
    apart: FloatArray


def _side_by_side(log: Log) -> tuple[_There, _Pairs]:
    """The road users of each instant, and each with each detection of the same instant."""
    table = log.detections
    key_of = [np.round(track.t / SAME_TIME).astype(np.int64) for track in log.objects.values()]
    key, who, k = (np.zeros(0, dtype=np.int64) for _ in range(3))
    state = np.zeros((0, 5))
    for number, (track, keys) in enumerate(zip(log.objects.values(), key_of, strict=True)):
        own, last = np.unique(keys[::-1], return_index=True)  # of two rows at one instant the later one
        rows = len(keys) - 1 - last
        columns = [column[rows] for column in (track.x, track.y, track.yaw, track.vx, track.vy)]
        key, k = np.concatenate([key, own]), np.concatenate([k, rows])
        who = np.concatenate([who, np.full(len(rows), number)])
        state = np.concatenate([state, np.column_stack(columns)])
    order = np.lexsort((who, key))
    key, state = key[order], state[order]
    there = _There(key / 1e6, who[order], k[order], state)
    seen = np.round(table.t / SAME_TIME).astype(np.int64)
    start, stop = np.searchsorted(seen, key, "left"), np.searchsorted(seen, key, "right")
    count = stop - start
    row = np.repeat(np.arange(len(key)), count)
    detection = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count) + start[row]
    apart = np.hypot(table.x[detection] - state[row, 0], table.y[detection] - state[row, 1])
    return there, _Pairs(key[row], row, detection, apart)


def _assigned(pairs: _Pairs, close: NDArray[np.bool_], size: int) -> NDArray[np.int64]:
    """The detection of each of `size` rows of _There, -1 for none: one to one, most `close` ones, then the sum of their
    distances least."""
    found = np.full(size, -1, dtype=np.int64)
    rows, detections = pairs.there[close], pairs.detection[close]
    alone = (np.bincount(rows, minlength=1)[rows] == 1) & (np.bincount(detections, minlength=1)[detections] == 1)
    found[rows[alone]] = detections[alone]
    for instant in np.unique(pairs.instant[close][~alone]):  # somebody has a choice there
        here = pairs.instant == instant
        of, of_row = np.unique(pairs.there[here], return_inverse=True)
        among, of_column = np.unique(pairs.detection[here], return_inverse=True)
        cost = np.full((len(of), len(among)), _FAR)
        cost[of_row, of_column] = np.where(close[here], pairs.apart[here], _FAR)
        for i, j in zip(*_least_sum(cost), strict=True):
            found[of[i]] = among[j] if cost[i, j] < _FAR else -1
    return found


def _least_sum(cost: FloatArray) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows and columns of the assignment whose sum is least."""
    from scipy.optimize import linear_sum_assignment

    rows, columns = linear_sum_assignment(cost)
    return rows, columns
