"""Values that repeat the one before: a slow sensor in a table of more rows, and a position that was held."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from openscenario.findings import Findings
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.unmeasured import unmeasured

CHANNELS = ("x", "y", "yaw", "v", "yaw_rate", "ax", "ay", "steer")
FEWEST = 20  # stretches of equal values that tell a period; chosen
EVEN = 0.85  # share of them that last as long as usual, within one row or UNEVEN. Chosen
UNEVEN = 0.3  # of how long they usually last: samples of an operating system come so unevenly. Chosen
SAME = 0.99  # of the changes: where more are of one size, a coarse channel climbs evenly; a drive has others. Chosen
FINE = 8.0  # smallest steps in a usual change; a coarse channel climbs by one to three of them. Chosen
SINGLE = 0.05  # share that may last for one row only: what is merely coarse changes from row to row in a bend. Chosen
COMMANDS = {"steer": "steer_cmd", "ax": "accel_cmd"}  # what a car without dynamics or noise shows step by step
OBEYED = 0.95  # share of the rows in which such a channel and its command step or stay together. Chosen
MOVED = 0.5  # m that the car went by its speed while its position stayed, and
STEPS = 5.0  # times the smallest step of the position: then it was held and not coarse. Both chosen


def repeats_of(log: Log) -> dict[str, NDArray[np.bool_]]:
    """The rows (n,) of each measured channel that only repeat an earlier sample; channels without are left out.

    A channel whose values all last for about as many rows, two or more, is a slow one that a table holds: the first row
    of each is its sample. A position that stays while the car goes on by its speed `v` was not measured then, nor was a
    heading that stays with it. Needs FEWEST stretches of a channel, and v for a position.
    """
    found: dict[str, NDArray[np.bool_]] = {}
    for name in CHANNELS:
        if (every := _rows_of(log, name)) > 1.0:
            found[name] = _later(log.columns[name], round(every))
    held = _held_position(log)
    for name in ("x", "y", "yaw"):
        if name in log.columns and held.any():
            still = held & _repeats(log.columns[name])
            if still.any():
                found[name] = found.get(name, np.zeros(len(still), dtype=np.bool_)) | still
    return found


def without_repeats(log: Log) -> Log:
    """The log with such values as not measured (NaN); the log itself if it has none."""
    return unmeasured(log, repeats_of(log))


def check_repeats(log: Log, file: str, findings: Findings) -> None:
    """A warning for the channels of each rate, and one for a position that was held."""
    slow: dict[float, list[str]] = {}
    for name in CHANNELS:
        if (every := _rows_of(log, name)) > 1.0:
            slow.setdefault(float(f"{every:.2g}"), []).append(name)
    rate = 1.0 / max(float(np.median(np.diff(log.t))), 1e-9)
    for every, names in slow.items():
        findings.add(
            "log.held_values", file, None, f"column {', '.join(names)}",
            f"each value stands in {every:g} rows: a sensor of about {rate / every:.3g} Hz in rows of {rate:.3g} Hz",
            hint="`dvp compare`, `dvp diagnose` and `dvp extend` take the first row of each and the others for not "
            "measured",
            severity="warning",
        )  # fmt: skip
    held = _held_position(log)
    if held.any():
        lasts = float(np.median(np.diff(log.t))) * np.count_nonzero(held)
        findings.add(
            "log.held_position", file, None, "column x, y",
            f"the position stays for {lasts:.3g} s in all while the car goes on, first at t = "
            f"{log.t[int(np.argmax(held))]:.6g} s",
            hint="a fix that was lost and held: such rows count as not measured",
            severity="warning",
        )  # fmt: skip


def _repeats(values: FloatArray) -> NDArray[np.bool_]:
    """Whether each value (n,) is that of the row before, to the last bit."""
    found: NDArray[np.bool_] = np.concatenate([[False], values[1:] == values[:-1]])
    return found


def _rows_of(log: Log, name: str) -> float:
    """In how many rows each sample of a channel stands in the mean; 1 also where it only does what its command does."""
    values, command = log.columns.get(name), log.columns.get(COMMANDS.get(name, ""))
    if values is None:
        return 1.0
    if command is not None and float(np.mean(_repeats(values) == _repeats(command))) >= OBEYED:
        return 1.0
    return _rows_a_sample(values)


def _rows_a_sample(values: FloatArray) -> float:
    """In how many rows each sample of a column (n,) stands in the mean, 1 where they change as they come.

    A sensor that was silent, with empty rows, is slow all the same. A reader that leaves the rows between samples empty
    holds nothing.
    """
    starts = np.flatnonzero(~_repeats(values))
    lasts = np.diff(starts)
    lasts = lasts[np.isfinite(values[starts[:-1]])]
    if len(lasts) < FEWEST:
        return 1.0
    usual = float(np.median(lasts))
    lasts = lasts[lasts <= 2.0 * usual + 1.0]  # a car that stands, or a sensor that was lost
    even = float(np.mean(np.abs(lasts - usual) <= max(1.0, UNEVEN * usual)))
    single = float(np.mean(lasts == 1))
    changes = np.abs(np.diff(values[np.isfinite(values)]))
    changes = changes[changes > 0.0]
    held = (even >= EVEN and not _climbs_evenly(changes)) or _is_fine(changes)
    return float(np.mean(lasts)) if usual >= 2.0 and single <= SINGLE and held else 1.0


def _climbs_evenly(changes: FloatArray) -> bool:
    """Whether nearly all changes (n,), > 0, are of one size: those of a coarse channel, no slow one."""
    usual = float(np.median(changes)) if len(changes) else 0.0
    return float(np.mean(np.abs(changes - usual) <= 0.01 * usual)) > SAME if len(changes) else False


def _is_fine(changes: FloatArray) -> bool:
    """Whether changes (n,), > 0, are mostly many of the smallest steps: such a value does not stay because it is
    coarse, however unevenly its samples come."""
    return len(changes) > 0 and float(np.median(changes)) > FINE * float(np.quantile(changes, 0.01))


def _later(values: FloatArray, every: int) -> NDArray[np.bool_]:
    """Rows (n,) behind the first of each sample; a value that stays for longer is measured every so many rows."""
    rows = np.arange(len(values))
    first = np.maximum.accumulate(np.where(_repeats(values), 0, rows))
    since = rows - first
    lasts = np.diff(np.append(np.flatnonzero(since == 0), len(values)))
    long = np.repeat(lasts > 2 * every + 1, lasts)
    found: NDArray[np.bool_] = (since > 0) & ~(long & (since % every == 0))
    return found


def _held_position(log: Log) -> NDArray[np.bool_]:
    """Rows (n,) whose x and y are those of a row before, from which the car has gone on by its speed."""
    nothing = np.zeros(len(log.t), dtype=np.bool_)
    if not {"x", "y", "v"} <= log.columns.keys():
        return nothing
    x, y = log.columns["x"], log.columns["y"]
    still = _repeats(x) & _repeats(y)
    if not still.any() or still.all():
        return nothing
    moves = np.abs(np.concatenate([np.diff(x), np.diff(y)]))
    moves = moves[np.isfinite(moves) & (moves > 0.0)]
    coarse = float(np.quantile(moves, 0.01)) if len(moves) else 0.0
    speed = np.abs(np.nan_to_num(log.columns["v"]))
    way = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(log.t))])
    rows = np.arange(len(x))
    first = np.maximum.accumulate(np.where(still, 0, rows))
    starts = np.flatnonzero(~still)
    ends = np.append(starts[1:], len(x)) - 1
    usual = 2.0 * max(_rows_a_sample(x), _rows_a_sample(y)) + 1.0  # rows, of a slow receiver that is held
    lost = (way[ends] - way[starts] > max(MOVED, STEPS * coarse)) & (ends - starts >= usual)
    found: NDArray[np.bool_] = still & np.repeat(lost, ends - starts + 1) & (rows > first)
    return found
