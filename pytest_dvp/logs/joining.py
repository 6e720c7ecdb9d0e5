"""Several files of one drive as one table: the union of their stamps, each value where it was measured."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from openscenario.findings import Findings, listed
from pytest_dvp.logs.column_names import canonical
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.mapping import STAMP
from pytest_dvp.logs.read_log import read_streams
from pytest_dvp.logs.stream import Stream
from pytest_dvp.logs.time_column import bare_time, clock_of, unit_of_steps
from pytest_dvp.logs.units import find_unit


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Joined:
    """t (n,) [s] since `origin` [s], the first stamp of all; columns (n,) by header text `name [unit]`, NaN where a
    file has no row; words: those of columns that hold words, "" where there is none; renamed: columns
    that an earlier file has too, old name to new; rows of each file; left_out: rows without a stamp of their own, by
    file; guessed: unit of the time of files that do not say it, if it is not s; clocks: column taken for the time, of
    files that call none so."""

    t: FloatArray
    origin: float
    columns: dict[str, FloatArray]
    renamed: dict[str, str]
    rows: dict[str, int]
    left_out: dict[str, int]
    guessed: dict[str, str]
    words: dict[str, list[str]]
    clocks: dict[str, str]


def join(files: Sequence[Path]) -> Joined:
    """The files of one drive, joined by their clocks; nothing is interpolated.

    A name that occurs in several files stays with the first of them; in a later one it gets the file's name in front.
    Raises LogError: a file without a time, of several topics, or with a clock that does not overlap the others'.
    """
    streams: list[Stream] = []
    guessed: dict[str, str] = {}
    stand_for: dict[str, str] = {}
    for path in files:
        timed, guess, field = _in_seconds(_stream(path))
        streams.append(timed)
        if guess not in ("", "s"):
            guessed[str(path)] = guess
        if field and canonical(field) != "t":
            stand_for[str(path)] = field
    clocks = [_clock(path, stream) for path, stream in zip(files, streams, strict=True)]
    begin, end = max(float(t[0]) for t in clocks), min(float(t[-1]) for t in clocks)
    if begin > end:
        late = max(range(len(files)), key=lambda k: clocks[k][0])
        raise LogError(
            f"{files[late]}: its time does not overlap that of the others: it begins at {clocks[late][0]:.6f} s, and "
            f"one of the others ends at {end:.6f} s; allowed: files of one drive with one clock",
            "log.no_common_time",
        )  # fmt: skip
    origin = min(float(t[0]) for t in clocks)
    ticks = [np.round((t - origin) / STAMP).astype(np.int64) for t in clocks]
    stamps = np.unique(np.concatenate(ticks))
    found = Joined(np.asarray(stamps * STAMP, dtype=np.float64), origin, {}, {}, {}, {}, guessed, {}, stand_for)
    for path, stream, own in zip(files, streams, ticks, strict=True):
        _, first = np.unique(own, return_index=True)
        found.rows[str(path)] = len(first)
        if len(own) > len(first):
            found.left_out[str(path)] = len(own) - len(first)
        places = np.searchsorted(stamps, own[first])
        taken = {*map(_name, found.columns), *found.words}
        known = _finite_clock(stream)
        fields = stream.fields | {name: texts.codes for name, texts in stream.texts.items()}
        for name, values in fields.items():
            if canonical(name) == "t" or name == stand_for.get(str(path)):
                continue
            new = name if name not in taken else f"{path.stem}.{name}"
            if new in taken:
                raise LogError(f"{path}: column {name}: a file of the same name has one of this name, too", "log.twice")
            if new != name:
                found.renamed[f"{path.name}: {name}"] = new
            column = np.full(len(stamps), np.nan)
            column[places] = values[known][first]
            if name in stream.texts:
                words = stream.texts[name].words
                found.words[new] = ["" if code != code else words[int(code)] for code in column.tolist()]
                continue
            unit = stream.units.get(name)
            found.columns[f"{new} [{unit}]" if unit else new] = column
    return found


def text_of(joined: Joined) -> str:
    """The table as CSV, `t [s]` first; numbers are those of the files to the last bit, an empty field is no value."""
    rows = [",".join(_cell(header) for header in ("t [s]", *joined.columns, *joined.words))]
    columns = [_numbers(joined.t, 6), *(_numbers(column) for column in joined.columns.values())]
    columns += [list(map(_cell, words)) for words in joined.words.values()]
    rows += [",".join(cells) for cells in zip(*columns, strict=True)]
    return "\n".join(rows) + "\n"


def _stream(path: Path) -> Stream:
    streams = read_streams(path, Findings())
    if isinstance(streams, Log) or len(streams) != 1:
        what = "a log of dvp" if isinstance(streams, Log) else f"a file of {len(streams)} topics"
        raise LogError(
            f"{path}: {what}, which has all in one already; allowed: files with one table each", "log.joined"
        )
    return streams[0]


def _in_seconds(stream: Stream) -> tuple[Stream, str, str]:
    """The stream by its clock in seconds; the unit that its time has by the steps from row to row, where the file does
    not say it, and the column of that time: "" where the file says both. Without a column that is called a time, it is
    the one that `dvp map` proposes, which rises evenly: `header.stamp` of a ROS topic."""
    field = bare_time(stream)
    if not field and np.isfinite(stream.receive).any():
        return stream, "", ""
    (timed,), field, _ = clock_of([stream])
    if field not in stream.fields or not _may_be_a_clock(stream, field):
        return stream, "", ""
    return timed, "" if field in stream.units else unit_of_steps(stream.fields[field]), field


def _may_be_a_clock(stream: Stream, field: str) -> bool:
    """Whether a column that rises evenly is called a time, is in a unit of time, or is in none and counts no rows."""
    unit = find_unit(stream.units[field]) if field in stream.units else None
    if unit is not None:
        return unit.si == "s"
    return canonical(field) == "t" or bool(np.any(np.diff(stream.fields[field]) != 1.0))


def _finite_clock(stream: Stream) -> NDArray[np.bool_]:
    return np.asarray(np.isfinite(stream.receive))


def _clock(path: Path, stream: Stream) -> FloatArray:
    t = stream.receive[_finite_clock(stream)]
    if not len(t):
        names = listed(list(stream.fields), 8)
        raise LogError(f"{path}: no time column; found: {names}; allowed: `t [s]`, or `s` and `ns`", "log.time_missing")
    back = np.flatnonzero(np.diff(t) < 0.0)
    if len(back):
        raise LogError(
            f"{path}: row {back[0] + 2}: time jumps back by {t[back[0]] - t[back[0] + 1]:.6g} s; allowed: rising time",
            "log.time_not_monotonic",
        )
    return t


def _name(header: str) -> str:
    return header.rpartition(" [")[0] or header


def _cell(header: str) -> str:
    return '"' + header.replace('"', '""') + '"' if any(mark in header for mark in ',"\n') else header


def _numbers(values: FloatArray, digits: int | None = None) -> list[str]:
    if digits is not None:
        return [f"{value:.{digits}f}" for value in values.tolist()]
    return ["" if value != value else repr(value) for value in values.tolist()]
