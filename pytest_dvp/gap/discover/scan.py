"""To first order: how much each term would take away from what is left over, and how much chance would."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, Values
from pytest_dvp.gap.discover.generic_effect import values_of
from pytest_dvp.gap.discover.term import Term
from pytest_dvp.logs.log_contents import FloatArray

AVERAGED = 5  # rows: laws are slower than that, and the table of all terms stays small
ROLLS = 60  # residuals shifted in time, by which chance is judged,
APART = 3.0  # s, by which each is shifted at least
WILDEST = 1e6  # sigma: a term that drives the model mad is none
CHANCE = 0.99  # quantile of the best gain that a shifted residual gives

Tick = Callable[[str], None]


class Scan:
    """Columns of all terms beside a set of values. gains (k,): by how much each term lowers chi^2 to first order; best:
    its coefficient there, in units of `Term.c`; chance: what the best of all would gain by chance."""

    def __init__(self, target: ExperimentSet, values: Values, terms: Sequence[tuple[Term, ...]], tick: Tick) -> None:
        """terms: for each column the whole law with the term to try as its last."""
        before = target.whitened(values)
        rest = _averaged(before)
        columns = np.zeros((len(terms), rest.size), dtype=np.float32)
        for k, law in enumerate(terms):
            if k % 500 == 0:
                tick(f"term {k} of {len(terms)}")
            change = target.whitened({**values, **values_of(law)}) - before
            if np.abs(change).max(initial=0.0) < WILDEST:  # NaN is not
                columns[k] = _averaged(change)
        self.columns = columns
        size = np.einsum("ij,ij->i", columns, columns)
        known = size > 1e-4 * target.count / AVERAGED  # the others show nowhere in this drive
        scale = np.where(known, 1.0 / np.sqrt(np.where(known, size, 1.0)), 0.0)
        slope = columns @ rest.astype(np.float32)
        self.best = np.where(known, -slope / np.where(known, size, 1.0), 0.0).astype(np.float64)
        self.gains = AVERAGED * np.square(slope * scale).astype(np.float64)
        rows = len(rest) // len(CHANNELS)
        table = rest.reshape(rows, len(CHANNELS))
        step = max(1, round(APART / (AVERAGED * target.sample)))
        shifts = np.unique(np.linspace(step, rows - step, ROLLS).astype(int)) if rows > 2 * step else np.zeros(0, int)
        rolled = np.array([np.roll(table, shift, axis=0).ravel() for shift in shifts], dtype=np.float32)
        if len(rolled):
            by_chance = np.square((columns @ rolled.T) * scale[:, None]).max(axis=0)
            self.chance = AVERAGED * float(np.quantile(by_chance, CHANCE))
        else:
            self.chance = float("inf")

    def likeness(self, a: int, b: int) -> float:
        """Correlation of two terms' columns, 0 to 1."""
        x, y = self.columns[a], self.columns[b]
        size = float(np.sqrt((x @ x) * (y @ y)))
        return abs(float(x @ y)) / size if size > 0.0 else 0.0


def _averaged(whitened: FloatArray) -> FloatArray:
    table = whitened.reshape(-1, len(CHANNELS))
    rows = len(table) // AVERAGED
    mean = table[: rows * AVERAGED].reshape(rows, AVERAGED, len(CHANNELS)).mean(axis=1)
    return np.ascontiguousarray(mean.ravel())
