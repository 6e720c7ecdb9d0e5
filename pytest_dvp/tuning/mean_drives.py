"""How alike two stages are in the mean over repeats: what differs from drive to drive of one car is no gap of the twin.

Two drives of one car differ as their sensors' noise does: an overtaking begins a few ticks earlier or later, a track is
lost and found. A repeat more tells nothing of the twin by that, and a bound on single drives above what the car itself
keeps asks for luck. So the courses of all repeats of a stage are averaged at each instant, and the two mean courses are
compared as two drives would be: MNCC, and beside it lag and gain, to which it is blind. The interval is the jackknife's
over repeats; the same of the car against itself, with other seeds, stands beside it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import TypeAlias

import numpy as np

from pytest_dvp.logs.detected_tracks import REACH, SeenTrack, seen_tracks
from pytest_dvp.logs.likeness import likeness
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.tuning.iteration_plan import Drive
from vehicle.messages import TICK

EGO = (("ego x", "x"), ("ego y", "y"), ("steer", "steer"), ("velocity", "v"))
OBJECTS = (("object x", "ahead"), ("object y", "left"))
STEP = 0.01  # s, of a log
SHARE = 0.5  # of the longest drive that all must share; chosen, as for two drives: one that ended early hides the rest
LEAST = 1.0  # s in common below which a road user says nothing
Course: TypeAlias = tuple[FloatArray, FloatArray]
Courses: TypeAlias = Mapping[str, Course]
"""Of one drive: row of the table, or row and road user -> times [s], values."""


@dataclasses.dataclass(frozen=True, slots=True)
class Alike:
    """MNCC, size of the lag [s], distance of the gain from 1, each the mean over variants with the half width of its
    95 % interval; worst: of the variants; repeats: of each stage, the fewer of both."""

    values: tuple[float, float, float]
    half_widths: tuple[float | None, float | None, float | None]
    worst: tuple[float, float, float]
    repeats: int


def ensemble(one: Sequence[Drive], other: Sequence[Drive]) -> dict[str, Alike]:
    """Likeness of the mean drives of two stages, by row; rows that no variant defines are left out.

    one, other: drives of the same variants; repeats are told by their seeds.
    """
    names = list(dict.fromkeys(drive.variant.title for drive in one))
    first, second = _read(one), _read(other)
    found: dict[str, Alike] = {}
    for row, _ in (*EGO, *OBJECTS):
        parts = [_jackknifed(row, first[name], second[name]) for name in names if name in second]
        known = [part for part in parts if part is not None]
        if not known or len(known) < len(parts):
            continue
        values = np.mean([whole for whole, _ in known], axis=0)
        halves = [half for _, half in known if half is not None]
        widths = np.sqrt(np.sum(np.square(halves), axis=0)) / len(known) if len(halves) == len(known) else None
        every = np.array([whole for whole, _ in known])
        worst = (float(every[:, 0].min()), float(every[:, 1].max()), float(every[:, 2].max()))
        repeats = min(len(stage[name]) for stage in (first, second) for name in names if name in stage)
        a, b, c = values.tolist()
        x, y, z = (None, None, None) if widths is None else widths.tolist()
        found[row] = Alike((a, b, c), (x, y, z), worst, repeats)
    return found


def _read(drives: Sequence[Drive]) -> dict[str, list[Courses]]:
    found: dict[str, list[Courses]] = {}
    for drive in sorted(drives, key=lambda each: each.seed):
        found.setdefault(drive.variant.title, []).append(courses(Log.load(drive.log)))
    return found


def courses(log: Log) -> dict[str, Course]:
    """The ego's columns, and of each road user of the world how the stack saw it: ahead and to the left of the ego.

    A detection has no name; a track is of the road user that was nearest to it on average, its pieces are one course.
    """
    found: dict[str, Course] = {}
    for row, column in EGO:
        values = log.columns.get(column)
        known = np.isfinite(log.t if values is None else values)
        if values is not None and known.any():
            found[row] = (log.t[known], values[known])
    pieces: dict[str, list[SeenTrack]] = {}
    for track in seen_tracks(log):
        away = {name: _away(track, true.t, true.x, true.y) for name, true in log.objects.items()}
        nearest = min(away, key=lambda name: away[name], default="")
        if nearest and away[nearest] <= REACH:
            pieces.setdefault(nearest, []).append(track)
    for name, tracks in sorted(pieces.items()):
        t, order = np.unique(np.concatenate([track.t for track in tracks]), return_index=True)
        for row, side in OBJECTS:
            found[f"{row} {name}"] = (t, np.concatenate([getattr(track, side) for track in tracks])[order])
    return found


def _away(track: SeenTrack, t: FloatArray, x: FloatArray, y: FloatArray) -> float:
    """Mean distance [m] of a track from a road user."""
    return float(np.mean(np.hypot(track.x - np.interp(track.t, t, x), track.y - np.interp(track.t, t, y))))


def _jackknifed(
    row: str, one: Sequence[Courses], other: Sequence[Courses]
) -> tuple[FloatArray, FloatArray | None] | None:
    """(3,) MNCC, lag, gain of all repeats, and half widths from leaving each repeat out; None if undefined."""
    whole = mean_likeness(row, one, other)
    count = min(len(one), len(other))
    if whole is None:
        return None
    if count < 3 or len(one) != len(other):
        return whole, None
    left = [mean_likeness(row, [*one[:k], *one[k + 1 :]], [*other[:k], *other[k + 1 :]]) for k in range(count)]
    known = np.array([each for each in left if each is not None])
    if len(known) < count:
        return whole, None
    from scipy.stats import t

    spread = np.sqrt((count - 1) / count * np.sum(np.square(known - known.mean(axis=0)), axis=0))
    return whole, np.asarray(t.ppf(0.975, count - 1) * spread)


def mean_likeness(row: str, one: Sequence[Courses], other: Sequence[Courses]) -> FloatArray | None:
    """(3,) MNCC, size of the lag [s], distance of the gain from 1, of the mean courses of two sets of drives; of
    objects the mean over road users, weighted by the time in common. None where nothing is defined, or one drive ended
    before half of the longest."""
    users = sorted({key for drive in (*one, *other) for key in drive if key == row or key.startswith(f"{row} ")})
    step = STEP if row in dict(EGO) else TICK
    found, weights = [], []
    for key in users:
        parts = [[drive[key] for drive in drives if key in drive] for drives in (one, other)]
        if any(2 * len(part) <= len(drives) for part, drives in zip(parts, (one, other), strict=True)):
            continue  # most drives of a stage did not see it
        start = max(course[0][0] for part in parts for course in part)
        end = min(course[0][-1] for part in parts for course in part)
        whole = max(course[0][-1] - course[0][0] for part in parts for course in part)
        if end - start < LEAST or (row in dict(EGO) and end - start < SHARE * whole):
            continue
        grid = start + step * np.arange(int((end - start) / step + 1e-6) + 1)
        a, b = (np.mean([np.interp(grid, *course) for course in part], axis=0) for part in parts)
        try:
            alike = likeness(a, b, step)
        except Undefined:
            continue  # a road user that keeps its place beside the ego: nothing varies
        found.append((alike.mncc, abs(alike.lag), abs(alike.gain - 1.0)))
        weights.append(end - start)
    return np.average(found, axis=0, weights=weights) if found else None
