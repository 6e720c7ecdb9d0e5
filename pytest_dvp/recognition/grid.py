"""Columns as means and rates over one window on one even grid, and how alike two of them are."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.doctor.redundant_motion import best_lag, correlation, slope
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.recognition.columns import Column

WINDOW = 0.4  # s: as the doctor's
LONGEST = 1.0  # s that one column comes after another
_STEP = 0.05  # s, and
_MOST = 12_000  # points of the grid: an hour is looked at every 0.3 s
_LEAST = 6.0  # s of a drive


@dataclasses.dataclass(frozen=True, slots=True)
class Match:
    """How alike `a` and `b` are: correlation at the best lag, that lag [s] (> 0: a comes later), ratio a/b (> 0)."""

    alike: float
    lag: float
    ratio: float

    @property
    def sign(self) -> float:
        """-1.0 if a is b turned round."""
        return -1.0 if self.alike < 0.0 else 1.0


NOTHING = Match(0.0, 0.0, math.nan)


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Grid:
    """Times (n,) [s], one each `step` [s], with a window of `window` [s] around each."""

    t: FloatArray
    step: float
    window: float

    def mean(self, column: Column) -> FloatArray:
        """Mean of the column in each window (n,), NaN where it was not measured; in the column's unit."""
        t, values = column.t, column.values
        integral = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(t))])
        low, high = self.t - 0.5 * self.window, self.t + 0.5 * self.window
        found = (np.interp(high, t, integral) - np.interp(low, t, integral)) / self.window
        return self._where_measured(t, found)

    def change(self, t: FloatArray, values: FloatArray, window: float = 0.0) -> FloatArray:
        """Rate of change (n,) of values over each window, in their unit a second; `window` [s] in place of its own."""
        w = window or self.window
        found = (np.interp(self.t + 0.5 * w, t, values) - np.interp(self.t - 0.5 * w, t, values)) / w
        return self._where_measured(t, found)

    def at(self, t: FloatArray, values: FloatArray) -> FloatArray:
        """Values (n,) at the times of the grid, in their unit."""
        return self._where_measured(t, np.interp(self.t, t, values))

    def slope(self, values: FloatArray) -> FloatArray:
        """Rate of change (n,) of values (n,) on the grid over one window, in their unit a second; NaN at both ends."""
        rows = max(1, round(0.5 * self.window / self.step))
        found = np.full(len(values), np.nan)
        found[rows:-rows] = (values[2 * rows :] - values[: -2 * rows]) / (2 * rows * self.step)
        return found

    def _where_measured(self, t: FloatArray, found: FloatArray) -> FloatArray:
        return np.where((self.t >= t[0]) & (self.t <= t[-1]), found, np.nan)

    def match(self, a: FloatArray, b: FloatArray, longest: float = LONGEST) -> Match:
        """How alike two (n,) in any units are, up to `longest` [s] apart; correlation 0 where nothing can be told."""
        lag, alike = best_lag(a, b, self.step, longest)
        rows = round(lag / self.step)
        a, b = (a[rows:], b[: len(b) - rows]) if rows >= 0 else (a[: len(a) + rows], b[-rows:])
        known: NDArray[np.bool_] = np.isfinite(a) & np.isfinite(b)
        if np.count_nonzero(known) < 50 or abs(alike) < 0.3:
            return NOTHING
        k = abs(slope(a[known], b[known]))
        together = abs(correlation(a[known], b[known]))
        return Match(alike, lag, k / math.sqrt(together) if together > 0.3 and k > 0.0 else math.nan)


def grid_of(columns: Sequence[Column]) -> Grid | None:
    """The grid of a log: where most of its columns were measured. None for less than a few seconds."""
    if not columns:
        return None
    begin = float(np.median([column.t[0] for column in columns]))
    end = float(np.median([column.t[-1] for column in columns]))
    pace = float(np.median([np.median(np.diff(column.t)) for column in columns]))
    window = max(WINDOW, 4.0 * pace)
    if not end - begin > max(_LEAST, 8.0 * window):
        return None
    step = max(_STEP, pace, (end - begin) / _MOST)
    return Grid(np.arange(begin + window, end - window, step), step, window)
