"""Values that stand alone: what a channel says for a moment, though it says the same before and after."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from openscenario.findings import Findings
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.unmeasured import unmeasured

LONGEST = 3  # samples of a spike; what lasts longer may be a motion. Chosen
SPREADS = 15.0  # times the usual deviation of a sample from the line between its neighbours. Chosen: noise has none
BACK = 0.3  # share of the spike by which the values before and after it may differ. Chosen
LIVELY = 3.0  # times the greatest step beside a spike that it needs at least: an oscillation has such steps. Chosen
AROUND = 2  # steps before and after a spike that are looked at. Chosen
APART = 1.0  # s between the samples beside a spike, at most: in more, the car may have done it. Chosen
SEEN = 5.0  # times the usual deviation, by which another channel has to show a turn. Chosen
SHORTEST = 0.1  # m of wheelbase: no car is shorter that turns by steering. Chosen
AGREES = 0.5  # of what the yaw rate makes of ay, within which ay says the same; chosen
FAULTY = 0.01  # share of a channel's samples from which spikes are no exceptions. Chosen


class Bound(NamedTuple):
    """What a car does not do between samples: `least`, in the unit of the signal, and `bend`, that unit over s^2, the
    greatest second derivative. A line between samples h apart misses a motion by up to bend h^2/8."""

    least: float
    bend: float


BOUNDS = {  # chosen, each beyond what any road car does
    "x": Bound(0.5, 15.0),
    "y": Bound(0.5, 15.0),
    "yaw": Bound(0.1, 15.0),
    "v": Bound(1.0, 200.0),
    "yaw_rate": Bound(0.3, 200.0),
    "ax": Bound(20.0, 2000.0),  # a kerb shakes an accelerometer by some 10 m/s^2
    "ay": Bound(20.0, 2000.0),
    "steer": Bound(0.1, 100.0),
}


def spikes_of(log: Log) -> dict[str, NDArray[np.bool_]]:
    """The rows (n,) of each measured channel whose values are spikes; channels that have none are left out.

    A spike lasts up to LONGEST samples, which a file may hold for several rows. It lies on one side of the line between
    the samples beside it, farther than noise and motion lead, and these two agree. Needs 8 samples of a channel, and
    does not see a spike within AROUND samples of another one. A turn that two of steering, yaw rate and ay tell alike
    is none, however short: a small car flicks its wheels.
    """
    found = {}
    for name, bound in BOUNDS.items():
        if name in log.columns and (rows := _rows(log.t, _values(log, name), bound)).any():
            if name in ("yaw_rate", "steer"):
                rows = rows & ~_turns(log, rows)
            if rows.any():
                found[name] = rows
    return found


def without_spikes(log: Log) -> Log:
    """The log with spikes as values that were not measured (NaN); the log itself if it has none."""
    return unmeasured(log, spikes_of(log))


def check_spikes(log: Log, file: str, findings: Findings) -> None:
    """A warning for each channel with spikes, and an error where one sample of a hundred is one."""
    for name, rows in spikes_of(log).items():
        values = _values(log, name)
        sound = np.isfinite(values) & ~rows
        off = np.where(rows, np.abs(values - np.interp(log.t, log.t[sound], values[sound])), 0.0)
        worst, count = int(np.argmax(off)), int(np.count_nonzero(rows))
        many = count > FAULTY * np.count_nonzero(np.isfinite(values))
        what = "1 value stands" if count == 1 else f"{count} values stand"
        findings.add(
            "log.spikes", file, None, f"column {name}",
            f"{what} apart from those before and after, most by {off[worst]:.3g} at t = {log.t[worst]:.6g} s",
            hint="look why the sensor says so, and leave these cells empty" if many else
            "`dvp compare`, `dvp diagnose` and `dvp extend` take such values for not measured",
            severity="error" if many else "warning",
        )  # fmt: skip


def _values(log: Log, name: str) -> FloatArray:
    """A column (n,) in its unit; a heading without its whole turns, by which a driver may wrap it."""
    values = log.columns[name]
    if name != "yaw":
        return values
    known = np.isfinite(values)
    found = values.copy()
    found[known] = np.unwrap(values[known])
    return found


def _turns(log: Log, rows: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Those of the rows (n,) in which the car really turns, as two columns of what turns it and how it turns agree."""
    found = np.zeros(len(rows), dtype=bool)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], rows.astype(np.int8), [0]]))).reshape(-1, 2)
    columns = {name: _known(log, name) for name in ("yaw_rate", "steer", "ay", "v")}
    for first, end in edges:
        rate, steer, side = (_off(columns[name], first, end) for name in ("yaw_rate", "steer", "ay"))
        at = columns["v"]
        v = float(np.interp(log.t[first], at[0], at[1])) if len(at[0]) else np.nan
        steered = rate * steer * v > SHORTEST * rate**2  # the wheels are turned, and far enough for such a turn
        felt = abs(side - v * rate) < AGREES * abs(v * rate) and side != 0.0
        found[first:end] = steered or felt
    return found


def _known(log: Log, name: str) -> tuple[FloatArray, FloatArray, NDArray[np.int64]]:
    """Stamps, values and rows of the samples of a column; none if the log lacks it."""
    values = log.columns.get(name, np.full(len(log.t), np.nan))
    known = np.flatnonzero(np.isfinite(values))
    return log.t[known], values[known], known


def _off(column: tuple[FloatArray, FloatArray, NDArray[np.int64]], first: int, end: int) -> float:
    """How far the samples from row `first` to `end` (excluded) lie from the mean of the one before and the one after,
    in the unit of the column; 0 where that is no more than SEEN of the usual, and NaN where there are none."""
    _, values, rows = column
    low, high = int(np.searchsorted(rows, first)), int(np.searchsorted(rows, end))
    if not 0 < low < high < len(rows) or len(rows) < 8:
        return np.nan
    usual = 1.4826 * float(np.median(np.abs(values[1:-1] - 0.5 * (values[:-2] + values[2:]))))
    off = float(np.mean(values[low:high]) - 0.5 * (values[low - 1] + values[high]))
    return off if abs(off) > SEEN * usual else 0.0


def _rows(t: FloatArray, values: FloatArray, bound: Bound) -> NDArray[np.bool_]:
    """Whether each row (n,) is of a spike."""
    rows = np.zeros(len(t), dtype=bool)
    known = np.flatnonzero(np.isfinite(values))
    if len(known) < 8:
        return rows
    # A slow channel in a fast file holds each sample for several rows: these are one.
    begins = np.concatenate([[True], np.diff(values[known]) != 0.0])
    starts = np.flatnonzero(begins)
    sample = values[known][starts]
    first, last = known[starts], known[np.append(starts[1:], len(known)) - 1]
    if len(sample) < 8:
        return rows
    usual = 1.4826 * float(np.median(np.abs(sample[1:-1] - 0.5 * (sample[:-2] + sample[2:]))))
    for length in range(1, LONGEST + 1):
        before, after = sample[: -length - 1], sample[length + 1 :]
        begin, end = t[last[: -length - 1]], t[first[length + 1 :]]
        apart = np.maximum(end - begin, 1e-9)
        least = np.maximum(SPREADS * usual, bound.least + bound.bend * apart**2 / 8.0)
        off = np.empty((length, len(before)))
        for place in range(length):
            inside = slice(place + 1, place + 1 + len(before))
            middle = 0.5 * (t[first[inside]] + t[last[inside]])
            off[place] = sample[inside] - (before + (after - before) * (middle - begin) / apart)
        nearest = np.min(np.abs(off), axis=0)
        least = np.maximum(least, LIVELY * _steps_beside(sample, length))
        one_side = np.all(off > 0.0, axis=0) | np.all(off < 0.0, axis=0)
        alone = one_side & (nearest > least) & (np.abs(after - before) < BACK * nearest) & (apart < APART)
        for k in np.flatnonzero(alone):
            rows[first[k + 1] : last[k + length] + 1] = True
    return rows & np.isfinite(values)


def _steps_beside(sample: FloatArray, length: int) -> FloatArray:
    """The greatest of AROUND steps before and after each run of `length` samples that has a sample on either side."""
    steps = np.abs(np.diff(sample))
    padded = np.concatenate([np.zeros(AROUND), steps, np.zeros(AROUND)])
    count = len(sample) - length - 1
    before = [padded[AROUND - 1 - k :][:count] for k in range(AROUND)]  # steps that end at the sample before the run
    after = [padded[AROUND + length + 1 + k :][:count] for k in range(AROUND)]
    greatest: FloatArray = np.maximum.reduce([*before, *after])
    return greatest
