"""Whether two logs hold the same drive, under whatever names."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.logs.log import Log

LEAST = 10  # rows that tell anything
MOST = 0.5  # of the shorter log's rows may be the other's, too: two runs of a simulator may begin alike
_SEED = 5  # any number does; the same each time, so that two calls agree


def shared_rows(one: Log, other: Log) -> int:
    """How many rows of the shorter log are in the other as well, bit for bit in every column that both have but t; 0 if
    that is no more than chance, standstill or a common beginning.

    Rows that a log repeats (a car at rest) tell nothing and do not count. Two measured drives share no row: already the
    last digits of noise differ.
    """
    names = sorted((one.columns.keys() & other.columns.keys()) - {"t"})
    if not names:
        return 0
    a, b = _marks(one, names), _marks(other, names)
    count = len(np.intersect1d(a, b, assume_unique=True))
    least = min(len(a), len(b))
    return count if least >= LEAST and count > MOST * least else 0


def _marks(log: Log, names: list[str]) -> NDArray[np.uint64]:
    """A number for each row that the log has once."""
    factors = np.random.default_rng(_SEED).integers(1, 2**63, len(names), dtype=np.uint64) * np.uint64(2) + np.uint64(1)
    marks = np.zeros(len(log.t), np.uint64)
    for name, factor in zip(names, factors, strict=True):
        values = np.ascontiguousarray(log.columns[name], dtype=np.float64) + 0.0  # -0 is 0
        bits = np.where(np.isnan(values), np.uint64(1), values.view(np.uint64))
        marks = (marks ^ (bits * factor)) * factor
        marks ^= marks >> np.uint64(29)
    found, counts = np.unique(marks, return_counts=True)
    return np.asarray(found[counts == 1])
