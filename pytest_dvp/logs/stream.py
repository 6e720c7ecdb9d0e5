"""Streams: what a file with several topics, each at its own rate, holds before anything is mapped."""

from __future__ import annotations

import dataclasses
import math
from array import array
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from pytest_dvp.logs.account import Account
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.texts import LONGEST, Coder, Texts

_MOST_FIELDS = 400  # a message with more is an image or a point cloud
UNSET = 2.0  # s, by which 0 is no time of the sender's clock; chosen as APART of the clocks of two topics
_WHOLE_STAMPS = ("header.timestampSec", "header.timestamp_sec")  # [s], of Apollo's common.Header


@dataclasses.dataclass
class Stream:
    """A topic (MDF: a group; CSV: the whole file).

    receive  when the recorder got each message [s], since the first message of the file
    fields   values (n,) by dotted name, `pose.position.x`
    units    unit of a field as the file states it; absent where it does not
    si       the writer's schema promises the names and units of the signal table
    texts    fields of words, as modes are
    """

    topic: str
    type: str
    receive: FloatArray
    fields: dict[str, FloatArray]
    units: dict[str, str] = dataclasses.field(default_factory=dict)
    si: bool = False
    texts: dict[str, Texts] = dataclasses.field(default_factory=dict)

    @property
    def rate(self) -> float:
        """Messages a second [Hz]; 0 for fewer than two."""
        span = float(self.receive[-1] - self.receive[0]) if len(self.receive) > 1 else 0.0
        return (len(self.receive) - 1) / span if span > 0 else 0.0

    @property
    def header(self) -> FloatArray | None:
        """The stamps in the messages' headers [s], None if they have none. Shape (n,), one a message; NaN where one was
        not set, as before a simulator's first /clock: it is 0, and a clock that the others are of was not."""
        for prefix in ("header.stamp", "stamp", "timestamp"):
            for low in ("nanosec", "nsec", "nsecs"):
                whole = next((f"{prefix}.{name}" for name in ("sec", "secs") if f"{prefix}.{name}" in self.fields), "")
                if whole and f"{prefix}.{low}" in self.fields:
                    stamps = self.fields[whole] + 1e-9 * self.fields[f"{prefix}.{low}"]
                    return self._set(stamps)
        for name in _WHOLE_STAMPS:
            if name in self.fields:
                return self._set(self.fields[name])
        return None

    def _set(self, stamps: FloatArray) -> FloatArray | None:
        """The stamps (n,) [s], NaN for those that were not set; None if none was."""
        if not np.any(stamps > 0):
            return None
        ahead = stamps - self.receive
        off = np.abs(ahead - np.nanmedian(ahead)) > UNSET
        return np.where((stamps == 0.0) & off, np.nan, stamps) if np.any(off) else stamps


def is_stamp(field: str) -> bool:
    """Whether a field is a time in a message's header, and so no signal."""
    return "stamp." in field or field in _WHOLE_STAMPS


def flatten(
    message: Any, prefix: str = "", into: dict[str, float] | None = None, words: dict[str, str] | None = None
) -> dict[str, float]:  # fmt: skip
    """Numbers of a nested message by dotted name; lists up to 16 long by index. Short words go into `words`."""
    found: dict[str, float] = {} if into is None else into
    if len(found) > _MOST_FIELDS:
        return found
    if isinstance(message, Mapping):
        for name, value in message.items():
            flatten(value, f"{prefix}.{name}" if prefix else str(name), found, words)
    elif isinstance(message, str):
        if words is not None and len(message) <= LONGEST and len(words) < _MOST_FIELDS:
            words[prefix] = message
    elif isinstance(message, bool | int | float):
        found[prefix] = _number(message)
    elif isinstance(message, list | tuple | np.ndarray) and len(message) <= 16:
        for i, value in enumerate(message):
            flatten(value.item() if isinstance(value, np.generic) else value, f"{prefix}[{i}]", found)
    elif isinstance(message, np.generic):
        found[prefix] = float(message.item())
    return found


def _number(value: float) -> float:
    """NaN for a whole number that is too large for a float."""
    try:
        return float(value)
    except OverflowError:
        return math.nan


class Columns:
    """Columns of flattened messages, filled row by row; NaN where a message lacks a field. `account` is charged."""

    def __init__(self, account: Account) -> None:
        self.rows = 0
        self._account = account
        self._columns: dict[str, array[float]] = {}
        self._words: dict[str, Coder | None] = {}  # None: no few words

    def add(self, row: Mapping[str, float], words: Mapping[str, str] = MappingProxyType({})) -> None:
        """Add a message's numbers and words as a row; a field that a row or an earlier row lacks is NaN there.

        Raises LogError if rows or bytes are more than the account allows.
        """
        columns = self._columns
        self.rows += 1
        self._account.rows(self.rows)
        self._account.hold(8 * (len(columns) + len(self._words) + 1))  # and its stamp
        for name, value in row.items():
            column = columns.get(name)
            if column is None:
                self._account.hold(8 * self.rows)
                column = columns[name] = array("d", [np.nan]) * (self.rows - 1)
            column.append(value)
        if len(row) != len(columns):
            for column in columns.values():
                if len(column) < self.rows:
                    column.append(np.nan)
        self._add_words(words)

    def _add_words(self, words: Mapping[str, str]) -> None:
        for name, word in words.items():
            if name not in self._words:
                self._account.hold(8 * self.rows)
                self._words[name] = Coder(self.rows - 1)
            coder = self._words[name]
            if coder is not None:
                coder.add(word)
                if coder.full:
                    self._words[name] = None
        for coder in self._words.values():
            if coder is not None and len(coder) < self.rows:
                coder.add(None)

    def texts(self) -> dict[str, Texts]:
        """The fields of words, each with a row for each message."""
        return {name: coder.texts() for name, coder in self._words.items() if coder is not None}

    def arrays(self) -> dict[str, FloatArray]:
        """The columns by field, each (n,) with a row for each message, in the units of the messages."""
        return {name: np.frombuffer(column, dtype=np.float64) for name, column in self._columns.items()}
