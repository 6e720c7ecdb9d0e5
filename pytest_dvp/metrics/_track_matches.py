"""Which detection is which road user ahead: one to one at each instant, the sum of distances least (CLEAR MOT)."""

from __future__ import annotations

import dataclasses
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics._objects_ahead import SAME_TIME, is_ahead, settled_ahead
from pytest_dvp.metrics._once_a_log import once_a_log
from pytest_dvp.metrics.metric import Measured, NotNegative, Series

REACH, BESIDE, WITHIN = 20.0, 4.0, 3.0  # m: as detection_error has them
_FAR = 1e6  # m; stands for no match: no object is so far away

Beyond: TypeAlias = NotNegative  # m; of the options that all metrics of tracks have


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Matches:
    """What was ahead and what was reported there: rows of all, (n,).

    t [s] and name: of each instant of each road user ahead; row: of the detection that is it, -1 if none is.
    false_t [s], false_row: detections ahead that are nobody. truth: x, y, yaw, vx, vy (n, 5).
    """

    t: FloatArray
    names: tuple[str, ...]
    row: NDArray[np.int64]
    truth: FloatArray
    false_row: NDArray[np.int64]


def seen_of(log: Log, reach: float, beside: float, within: float, beyond: float) -> tuple[Matches, NDArray[np.int64]]:
    """Matches and indices (k,) of those that were detected; lengths in [m]. Raises Undefined if there is none."""
    m = matches(log, reach, beside, within, beyond)
    if not len(m.t):
        raise Undefined("no road user was ahead of the ego")
    seen = np.flatnonzero(m.row >= 0)
    if not len(seen):
        raise Undefined("no road user ahead of the ego was detected")
    return m, seen


def offset_of(log: Log, m: Matches, seen: NDArray[np.int64]) -> tuple[FloatArray, FloatArray]:
    """Detected minus true position [m] in the map frame, each (k,)."""
    rows = m.row[seen]
    return log.detections.x[rows] - m.truth[seen, 0], log.detections.y[rows] - m.truth[seen, 1]


def worst_of(m: Matches, seen: NDArray[np.int64], error: FloatArray, value: float, extra: dict[str, float]) -> Measured:
    """The value of a metric with its course and the worst of its errors (k,), each in the unit of the metric."""
    k = int(np.argmax(np.abs(error)))
    order = np.argsort(m.t[seen], kind="stable")
    series = Series(m.t[seen][order], error[order])
    return Measured(value, float(m.t[seen[k]]), m.names[seen[k]], series, extra)


@once_a_log
def matches(log: Log, reach: float, beside: float, within: float, beyond: float) -> Matches:
    """What was ahead of the ego and which detections are it; lengths in [m], as in `detection_recall`."""
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
    return Matches(
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
    alone = (np.bincount(rows)[rows] == 1) & (np.bincount(detections)[detections] == 1)
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
