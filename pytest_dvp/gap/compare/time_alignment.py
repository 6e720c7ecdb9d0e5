"""Time alignment of a measurement and a model: by how much one comes later, and how much of the time both cover."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from pytest_dvp.gap.compare.start_correction import BoolArray
from pytest_dvp.logs.likeness import Likeness, likeness, peak
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.undefined import Undefined

MAX_LAG = 2.0  # s
_SLOW = 5.0  # s: slower changes than this do not tell a lag, but flatten the peak


@dataclasses.dataclass(frozen=True, slots=True)
class Alignment:
    """lag [s] > 0: the measurement comes later than the model; coverage: share of the log's time both are known, which
    it is not in a gap."""

    lag: float
    coverage: float


@dataclasses.dataclass(frozen=True, slots=True)
class Alike:
    """MNCC, lag [s] to a fraction of a sample, gain measured/model; None where a constant signal does
    not define them, lag and gain also where the best lag is beyond the search."""

    mncc: float | None
    lag: float | None
    gain: float | None


def coverage(t: FloatArray, known: BoolArray, longest: float) -> float:
    """Share of the time from the first of the stamps t (n,) [s] to the last that the rows `known` (n,) stand for.

    A row stands for the time to the next; across a gap, which is longer than `longest` [s], for the usual step only.
    """
    spans = np.diff(t)
    counts = np.where(spans > longest, float(np.median(spans)), spans)
    return float(counts[known[:-1]].sum() / spans.sum())


def grid(t: FloatArray) -> FloatArray:
    """Even time base (m,) [s] over the stamps t (n,) [s], at their median step."""
    step = float(np.median(np.diff(t)))
    return np.asarray(t[0] + step * np.arange(int((t[-1] - t[0]) / step + 1e-6) + 1))


def on_grid(even: FloatArray, t: FloatArray, y: FloatArray) -> FloatArray:
    """y (n,) at t (n,) [s], read at the times `even` (m,) [s], in the unit of y.

    Straight lines bridge what was not measured; NaN everywhere if nothing was.
    """
    known = np.isfinite(y)
    return np.asarray(np.interp(even, t[known], y[known])) if known.any() else np.full(len(even), np.nan)


def alike(measured: FloatArray, model: FloatArray, step: float, max_lag: float = MAX_LAG) -> Alike:
    """Likeness of two signals (n,) sampled every `step` [s]; lag and gain are those of their overlap (`likeness`)."""
    try:
        found = likeness(model, measured, step, max_lag)
    except Undefined:
        return Alike(None, None, None)
    usable = np.flatnonzero(np.isfinite(found.overlap))
    if np.any(found.overlap[[usable[0], usable[-1]]] >= np.nanmax(found.overlap)):
        return Alike(found.mncc, None, None)  # still rising at the end of the search: no lag was found
    gain = found.gain if np.isfinite(found.gain) else None
    return Alike(found.mncc, peak(found.lags, found.overlap), gain)


def common_lag(pairs: Sequence[tuple[FloatArray, FloatArray]], step: float, max_lag: float = MAX_LAG) -> float:
    """Lag [s] at which several signals (measured, model), each (n,), are most alike together; 0 if none varies."""
    total: FloatArray | None = None
    lags = np.zeros(0)
    for measured, model in pairs:
        found = _fast_part(measured, model, step, max_lag)
        if found is not None:
            lags = found.lags
            total = found.correlation if total is None else total + found.correlation
    return 0.0 if total is None else peak(lags, total)


def _fast_part(measured: FloatArray, model: FloatArray, step: float, max_lag: float) -> Likeness | None:
    try:
        return likeness(_without_slow(model, step), _without_slow(measured, step), step, max_lag)
    except Undefined:
        return None


def _without_slow(y: FloatArray, step: float) -> FloatArray:
    half = min(max(1, round(0.5 * _SLOW / step)), (len(y) - 1) // 2)
    total = np.concatenate([[0.0], np.cumsum(y)])
    i = np.arange(len(y))
    low, high = np.maximum(i - half, 0), np.minimum(i + half + 1, len(y))
    return np.asarray(y - (total[high] - total[low]) / (high - low))
