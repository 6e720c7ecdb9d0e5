"""The parts of long logs that a diagnosis looks at: an hour tells little more than its most eventful minutes.

Whole stretches are kept as they were recorded, for rows left out would blur dead times and noise.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.log_part import cut_log

LONGEST = 30_000  # rows in all that are looked at: 600 s at 50 Hz, about half a minute of CPU
_PARTS = 3  # of a single log, which judge each other
_CELL = 5.0  # s, a part begins at a multiple of it
_APART = 0.2  # s, over which a command changes


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Part:
    """Rows of the log `name` from start to stop [s]; a whole log is from -inf to inf."""

    name: str
    start: float
    stop: float
    log: Log

    @property
    def whole(self) -> bool:
        """True for a log that was not cut."""
        return self.start == -np.inf

    def called(self, name: str) -> str:
        """The log argument that means this part of the file `name`."""
        return name if self.whole else f"{name}@{self.start:g}:{self.stop:g}"


def exciting_parts(logs: Mapping[str, Log], commands: Sequence[str], most: int | None = None) -> list[Part]:
    """The logs, or, of more than `most` rows in all (default: LONGEST), the stretches that together drive the car most
    variedly.

    commands: columns that drive the model. A stretch is taken for the energy (variance times rows) that it adds to
    the commands, their changes, the speed and the yaw rate, each by its square root, so that what is there already
    counts less. In the order of the logs and of time; deterministic.
    """
    most = LONGEST if most is None else most
    if sum(len(log.t) for log in logs.values()) <= most:
        return [Part(name, -np.inf, np.inf, log) for name, log in logs.items()]
    books = {name: _Book(log, commands, most // _PARTS) for name, log in logs.items()}
    scale = np.sum([book.sums[-1] for book in books.values()], axis=0)
    scale[scale <= 0.0] = 1.0
    have, rows = np.zeros(len(scale)), 0
    chosen: list[Part] = []
    while True:
        options = [option for name, book in books.items() for option in book.options(name, most - rows)]
        if not options:
            break
        name, k, energy = max(options, key=lambda o: float(np.sum(np.sqrt((have + o[2]) / scale))))
        part = books[name].take(name, k)
        have, rows = have + energy, rows + len(part.log.t)
        chosen.append(part)
    order = {name: place for place, name in enumerate(logs)}
    return sorted(chosen, key=lambda part: (order[part.name], part.start))


class _Book:
    """Energies of one log in cells of 5 s, and which of them are taken."""

    def __init__(self, log: Log, commands: Sequence[str], rows: int) -> None:
        self.log = log
        first = np.floor(log.t[0] / _CELL) * _CELL
        count = int((log.t[-1] - first) // _CELL) + 1
        self.edges = first + _CELL * np.arange(count + 1)
        cut = np.searchsorted(log.t, self.edges)
        self.rows = np.diff(cut)
        self.sums = np.concatenate([np.zeros((1, _width(commands))), np.cumsum(_energies(log, commands, cut), axis=0)])
        usual = max(float(np.median(self.rows)), 1.0)
        self.cells = min(max(int(rows / usual), 1), count)
        self.free = np.ones(count, dtype=bool)

    def options(self, name: str, most: int) -> list[tuple[str, int, FloatArray]]:
        """Stretches that are free and have at most `most` rows: first cell and energy."""
        w = self.cells
        taken = np.concatenate([[0], np.cumsum(~self.free)])
        total = np.concatenate([[0], np.cumsum(self.rows)])
        rows = total[w:] - total[:-w]
        fits = (taken[w:] == taken[:-w]) & (rows <= most) & (rows > 2)
        return [(name, int(k), self.sums[k + w] - self.sums[k]) for k in np.flatnonzero(fits)]

    def take(self, name: str, k: int) -> Part:
        stop = k + self.cells
        self.free[k:stop] = False
        if self.cells == len(self.free):
            return Part(name, -np.inf, np.inf, self.log)
        start, end = float(self.edges[k]), float(self.edges[stop])
        return Part(name, start, end, cut_log(self.log, start, end, name))


def _width(commands: Sequence[str]) -> int:
    return 2 * len(commands) + 3


def _energies(log: Log, commands: Sequence[str], cut: np.ndarray[tuple[int], np.dtype[np.intp]]) -> FloatArray:
    """Sums over each cell (cells, features) of squares about the mean: what changes within 5 s; and of the speed."""
    table = []
    apart = max(round(_APART / float(np.median(np.diff(log.t)))), 1)
    for name in commands:
        y = _filled(log, name)
        change = np.zeros(len(y))
        change[apart:] = y[apart:] - y[:-apart]
        table += [_spread(y, cut), _sums(change**2, cut)]
    v = _filled(log, "v")
    table += [_spread(v, cut), _sums(v**2, cut), _spread(_filled(log, "yaw_rate"), cut)]
    return np.column_stack(table)


def _filled(log: Log, name: str) -> FloatArray:
    values = log.columns.get(name)
    if values is None or not np.isfinite(values).any():
        return np.zeros(len(log.t))
    known = np.isfinite(values)
    return np.interp(log.t, log.t[known], values[known])


def _sums(y: FloatArray, cut: np.ndarray[tuple[int], np.dtype[np.intp]]) -> FloatArray:
    total = np.concatenate([[0.0], np.cumsum(y)])
    return np.asarray(total[cut[1:]] - total[cut[:-1]])


def _spread(y: FloatArray, cut: np.ndarray[tuple[int], np.dtype[np.intp]]) -> FloatArray:
    y = y - y.mean()
    rows = np.maximum(np.diff(cut), 1)
    return np.maximum(_sums(y**2, cut) - _sums(y, cut) ** 2 / rows, 0.0)
