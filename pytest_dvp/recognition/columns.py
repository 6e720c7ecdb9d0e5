"""The columns of a foreign log with what can be known of each before its numbers are looked at."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence

import numpy as np

from pytest_dvp.logs.column_names import parse_header
from pytest_dvp.logs.combined_fields import MARK, combined, yaw_of_quaternion
from pytest_dvp.logs.command_topics import carries_commands
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.mapping import QUATERNION
from pytest_dvp.logs.mapping_proposal import quaternions_of
from pytest_dvp.logs.stream import Stream, is_stamp
from pytest_dvp.logs.units import find_unit
from pytest_dvp.recognition.words import is_command

FEWEST = 30  # samples, below which a column tells nothing
_PAIRS = (
    ("x", "y"), ("longitude", "latitude"), ("lon", "lat"), ("lng", "lat"), ("long", "lat"), ("easting", "northing"),
    ("east", "north"), ("ost", "nord"), ("e", "n"),
)  # fmt: skip


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Column:
    """One field of a file. unit: as the file states it, "" if it does not; "quaternion": the values are its yaw [rad].
    way: how several fields make it, with a + between their names.

    t (n,) [s] and values (n,) in the field's own unit, where it was measured; asked: its topic is one of commands.
    """

    topic: str
    field: str
    unit: str
    t: FloatArray
    values: FloatArray
    way: str = ""
    asked: bool = False

    @property
    def name(self) -> str:
        """The field without a unit in its name."""
        last = self.field.rpartition(".")[2] if self.topic and self.field.count(".") else self.field
        return parse_header(last).name if self.unit else self.field

    @property
    def key(self) -> tuple[str, str]:
        """Topic and field."""
        return self.topic, self.field

    @property
    def is_command(self) -> bool:
        """Whether its name or its topic says that it was wanted, not measured."""
        return self.asked or is_command(self.name)


def columns_of(streams: Sequence[Stream], clock: str) -> list[Column]:
    """All columns that vary, quaternions as one column each; `clock` is that of the mapping, and is no column."""
    found = []
    for stream in streams:
        header = stream.header if clock == "header" else None
        t = stream.receive if header is None else header
        four = quaternions_of(stream)
        parts = {part for _, group in four for part in group}
        for name, group in four:
            x, y, z, w = (stream.fields[part] for part in group)
            found += _column(stream, name, QUATERNION, t, yaw_of_quaternion(x, y, z, w))
        for field, values in stream.fields.items():
            if field not in parts and field != clock and not is_stamp(field):
                unit = stream.units.get(field) or parse_header(field.rpartition(".")[2]).unit or ""
                unit = unit if find_unit(unit) is not None else ""
                found += _column(stream, field, unit, t, values)
    return found


def _column(stream: Stream, field: str, unit: str, t: FloatArray, values: FloatArray) -> list[Column]:
    seen = np.isfinite(values) & np.isfinite(t)
    t, values = t[seen], values[seen]
    rising = np.concatenate([[True], np.diff(np.maximum.accumulate(t)) > 0]) if len(t) else np.zeros(0, bool)
    t, values = t[rising], values[rising]
    if len(t) < FEWEST or float(np.ptp(values)) == 0.0:
        return []
    return [Column(stream.topic, field, unit, t, values, asked=carries_commands(stream.topic, stream.type))]


def pairs_of(columns: Sequence[Column]) -> list[tuple[Column, Column]]:
    """Columns of one topic whose names differ in x and y, east and north, or longitude and latitude only."""
    found = []
    by_key = {column.key: column for column in columns if column.unit != QUATERNION}
    for column in by_key.values():
        for first, second in _PAIRS:
            other = by_key.get((column.topic, _exchanged(column.field, first, second)))
            if other is not None and other is not column:
                found.append((column, other))
                break
    return found


def together(way: str, columns: Sequence[Column]) -> Column | None:
    """One column of several of a topic that were measured together; None if they were not."""
    first = columns[0]
    if any(len(c.t) != len(first.t) or not np.array_equal(c.t, first.t) for c in columns):
        return None
    values = combined(way, first.t, [c.values for c in columns])
    seen = np.isfinite(values)
    unit = first.unit if all(c.unit == first.unit for c in columns) else ""
    if np.count_nonzero(seen) < FEWEST:
        return None
    return Column(first.topic, MARK.join(c.field for c in columns), unit, first.t[seen], values[seen], way, first.asked)


def _exchanged(name: str, first: str, second: str) -> str:
    """The name with its last word `first` replaced; a letter counts at either end of a word (`px`, `xpos`, `posX`)."""
    if len(first) > 1:
        pattern = re.compile(rf"(?<![a-z]){first}(?![a-z])|(?<=[a-z]){first.capitalize()}", re.IGNORECASE)
    else:
        pattern = re.compile(rf"(?<![A-Za-z]){first}(?=$|[^a-z])|{first}(?=$|[\W_\d])|(?<![A-Za-z]){first}(?=pos|_)",
                             re.IGNORECASE)  # fmt: skip
    places = list(pattern.finditer(name))
    if not places:
        return ""
    at = places[-1]
    new = second.upper() if at[0].isupper() else second.capitalize() if at[0][0].isupper() else second
    return name[: at.start()] + new + name[at.end() :]
