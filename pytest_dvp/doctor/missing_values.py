"""Values that are not there: empty columns and holes in a channel that has its rows."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from openscenario.findings import Findings
from pytest_dvp.logs.engagement import ENGAGED
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.signals import SIGNALS

SHARE = 0.02  # of the time
LONGEST = 0.5  # [s]; three of the channel's own intervals if that is more
_HOLE = 1.5  # own intervals: between two samples of a slower channel there is nothing, and nothing is missing
_JITTER = 0.1  # share of a channel's intervals that are no multiples of its usual one, from which it has none
_BETWEEN = (1.15, 1.85)  # times the usual interval: neither one sample nor two
# A state that holds until the next one, as who drives, lacks nothing in between
_UNWATCHED = ("t", "z", "gear", "on_road", ENGAGED)
_WATCHED = tuple(name for name in SIGNALS if name not in _UNWATCHED and not name.startswith("ads."))


class Hole(NamedTuple):
    """What a channel lacks: share of the time, and start and end [s] of the longest hole."""

    share: float
    start: float
    end: float


def check_missing(log: Log, file: str, findings: Findings) -> None:
    """Warnings, one for all channels with the same holes; time without any row is the time base's finding."""
    empty, holes = [], dict[Hole, list[str]]()
    for name in _WATCHED:
        values = log.columns.get(name)
        if values is None:
            continue
        seen = np.isfinite(values)
        if not seen.any():
            empty.append(name)
        elif (hole := _hole(log.t, seen)) is not None:
            holes.setdefault(hole, []).append(name)
    for name in empty:
        findings.add("log.empty_column", file, None, f"column {name}", "the column holds no value", severity="warning")
    for hole, names in holes.items():
        findings.add(
            "log.missing_values", file, None, f"column {', '.join(names)}",
            f"{100 * hole.share:.1f} % of the time is missing, longest from t = {hole.start:.6g} to {hole.end:.6g} s",
            allowed=f"up to {100 * SHARE:.0f} %, holes up to {LONGEST:g} s",
            hint="nothing is judged there by what is missing: look why the channel was silent, or cut the log",
            severity="warning",
        )  # fmt: skip


def _hole(t: FloatArray, seen: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> Hole | None:
    """None for a channel without holes worth a word; its own rate is what most of its samples say."""
    at = np.flatnonzero(seen)
    span = float(t[-1] - t[0])
    if len(at) < 8 or span <= 0.0:
        return Hole(1.0, float(t[0]), float(t[-1])) if span > 0.0 else None
    usual = _usual(np.diff(t[at]))
    # Before the first and after the last value there may be rows as well.
    rows, edges = np.concatenate([[0], at, [len(t) - 1]]), np.concatenate([[t[0]], t[at], [t[-1]]])
    lasts = np.diff(edges)
    open_ = (np.diff(rows) > 1) & (lasts > _HOLE * usual)
    if not open_.any():
        return None
    share = float(np.sum(lasts[open_] - usual)) / span
    longest = int(np.argmax(np.where(open_, lasts, 0.0)))
    if share <= SHARE and lasts[longest] <= max(LONGEST, 3.0 * usual):
        return None
    return Hole(share, float(edges[longest]), float(edges[longest + 1]))


def _usual(intervals: FloatArray) -> float:
    """The interval [s] of a channel; of one whose samples come unevenly, as behind an operating system, a long one.

    There the median is no step of a grid, and what exceeds it by half is not a sample that was lost.
    """
    usual = float(np.median(intervals))
    odd = (intervals > _BETWEEN[0] * usual) & (intervals < _BETWEEN[1] * usual)
    return float(np.quantile(intervals, 0.95)) if odd.mean() > _JITTER else usual
