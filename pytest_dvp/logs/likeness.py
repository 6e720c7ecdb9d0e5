"""Likeness of two signals of one time base: MNCC, and the lag and gain without which it must not stand."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.undefined import Undefined

MAX_LAG = 5.0  # s
FLAT = 1e-10  # of its greatest value, by which a signal varies at least; chosen: an overtaking 5.8e6 m north of the
# equator varies by 6e-7 of its UTM coordinate
OVERLAP = 0.5  # share of two signals that a lag must leave in common; chosen
ROUNDING = 1e-9  # of a correlation: what differs by less is equal; chosen, 1e-13 is lost to the transforms
CHANCE = 3.0  # standard deviations 1/sqrt(n) of Fisher's z = atanh(r), by which one turn must be more alike; chosen
LEAST_CHANCE = 0.1  # of z at least, as noise of sensors is correlated; chosen: a turn that leaves 20 % more is as good
VALLEY = 0.5  # of a turn's correlation, below which it falls beside that turn; chosen: of a sine it falls to -1


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Likeness:
    """Result of `likeness`: mncc in [-1, 1], lag [s] (> 0: the measurement comes later), gain measured/model, bias
    measured - model at that lag.

    lags, correlation: the normalised cross-correlation (m,) over the lag [s], of which mncc is the maximum; overlap:
    the same of what both have in common at a lag, NaN where that is too little. The lag is where overlap is greatest,
    and of turns of a signal that repeats the nearest to 0 that is no worse than chance makes it.
    """

    mncc: float
    lag: float
    gain: float
    lags: FloatArray
    correlation: FloatArray
    overlap: FloatArray
    bias: float = 0.0


def likeness(model: FloatArray, measured: FloatArray, step: float, max_lag: float = MAX_LAG) -> Likeness:
    """Compare two signals (n,) sampled every `step` [s].

    MNCC: maximum over the lag of the cross-correlation of the mean-removed signals, divided by both their norms.
    Source: Arango et al., Sensors 2026, 26, 1338. That maximum is drawn to a lag of 0, as a shift takes part of the
    signals out of it; so the lag is that at which what both have in common correlates best, and the gain is the slope
    of measured against model in the overlap at that lag. Raises Undefined for a constant signal.
    """
    if len(model) != len(measured) or len(model) < 2:
        raise Undefined("too few common samples")
    x, y = model - model.mean(), measured - measured.mean()
    norm = math.sqrt(_dot(x, x)) * math.sqrt(_dot(y, y))
    floor = FLAT**2 * len(x) * max(float(np.abs(model).max()), 1e-300) * max(float(np.abs(measured).max()), 1e-300)
    if norm <= floor:
        raise Undefined("the signal is constant")
    n = len(x)
    reach = min(n - 1, round(max_lag / step))
    products = _correlate(x, y, reach)
    correlation = np.clip(products / norm, -1.0, 1.0)
    lags = np.arange(-reach, reach + 1)
    overlap = _overlapping(x, y, products, reach)
    if not np.isfinite(overlap[reach]):  # sums that cancel lose what hardly varies; without a shift all is in common
        overlap[reach] = correlation[reach]
    k = _best(lags, overlap, n)
    gain, off = slope_at(model, measured, k)
    return Likeness(float(correlation.max()), k * step, gain, lags.astype(np.float64) * step, correlation, overlap, off)


def slope_at(model: FloatArray, measured: FloatArray, k: int) -> tuple[float, float]:
    """Slope of measured (n,) against model (n,) where they overlap if measured is `k` samples late, in the unit of
    measured over that of model, NaN for a constant model; and the difference of their means there, measured - model.
    """
    n = len(model)
    a, b = model[max(0, -k) : n - max(0, k)], measured[max(0, k) : n - max(0, -k)]
    off = float(b.mean() - a.mean())
    a, b = a - a.mean(), b - b.mean()
    power = _dot(a, a)
    return _dot(a, b) / power if power > 0.0 else float("nan"), off


def unlike_at(model: FloatArray, measured: FloatArray, k: int) -> float:
    """Share [-] of what varies in measured (n,) that a straight line of model (n,) leaves, 0..1, where they overlap if
    measured is `k` samples late; both in the same unit; 1 where either is constant."""
    n = len(model)
    a, b = model[max(0, -k) : n - max(0, k)], measured[max(0, k) : n - max(0, -k)]
    a, b = a - a.mean(), b - b.mean()
    power = _dot(a, a) * _dot(b, b)
    return 1.0 - _dot(a, b) ** 2 / power if power > 0.0 else 1.0


def peak(lags: FloatArray, correlation: FloatArray) -> float:
    """Place of the maximum between the samples, by the parabola through the three highest.

    Lags (n,) and the correlation (n,) at each, NaN where there is none; the result has the unit of the lags. Of equal
    ones the nearest to 0 counts; at either end it is the end itself.
    """
    highest = np.flatnonzero(correlation >= np.nanmax(correlation) - ROUNDING)
    k = int(highest[np.argmin(np.abs(lags[highest]))])
    around = correlation[max(k - 1, 0) : k + 2]
    if len(around) < 3 or not np.isfinite(around).all():
        return float(lags[k])
    left, top, right = around
    bend = left - 2.0 * top + right
    shift = 0.5 * (left - right) / bend if bend < -ROUNDING else 0.0
    return float(lags[k] + shift * (lags[k + 1] - lags[k]))


def _best(lags: NDArray[np.int64], overlap: FloatArray, rows: int) -> int:
    """The lag (of lags (m,), in samples) of the greatest overlap (m,), or of an equal turn that is nearer to 0.

    A signal that repeats is alike after each of its turns, and noise would choose one. So a turn is as good that is
    less alike by no more than chance makes in so many rows (Fisher's z), if the correlation falls between the two: else
    it is a ripple of the same turn.
    """
    tied = np.flatnonzero(overlap >= np.nanmax(overlap) - ROUNDING)
    best = int(tied[np.argmin(np.abs(lags[tied]))])
    known = np.where(np.isfinite(overlap), overlap, -1.0)
    alike = np.arctanh(np.clip(known, -1.0 + ROUNDING, 1.0 - ROUNDING))
    padded = np.concatenate([[-1.0], known, [-1.0]])
    tops = (known >= padded[:-2]) & (known >= padded[2:])
    equal = np.flatnonzero(tops & (alike >= alike[best] - max(CHANCE / math.sqrt(rows), LEAST_CHANCE)))
    for top in sorted(equal.tolist(), key=lambda k: abs(int(lags[k]))):
        if top == best or known[min(top, best) : max(top, best)].min() < VALLEY * known[top]:
            return int(lags[top])
    return int(lags[best])


def _overlapping(x: FloatArray, y: FloatArray, products: FloatArray, reach: int) -> FloatArray:
    """Pearson's correlation (2 reach + 1,) of x (n,) and y (n,) where they overlap at the lags -reach ... reach.

    NaN at lags at which the overlap does not hold OVERLAP of the time and of what varies in both: a short piece of two
    signals can be alike by chance. products (2 reach + 1,): of `_correlate`.
    """
    n = len(x)
    lags = np.arange(-reach, reach + 1)
    first, second = np.maximum(0, -lags), np.maximum(0, lags)  # where the overlap begins in x and in y
    count = (n - np.abs(lags)).astype(np.float64)
    spreads = []
    sums = []
    for values, start in ((x, first), (y, second)):
        stop = start + n - np.abs(lags)
        total, square = (np.concatenate([[0.0], np.cumsum(part)]) for part in (values, values * values))
        sums.append(total[stop] - total[start])
        spreads.append(square[stop] - square[start] - sums[-1] ** 2 / count)
    whole = (_dot(x, x), _dot(y, y))
    usable = (count >= OVERLAP * n) & (spreads[0] >= OVERLAP * whole[0]) & (spreads[1] >= OVERLAP * whole[1])
    usable[reach] = True
    with np.errstate(divide="ignore", invalid="ignore"):
        alike = (products - sums[0] * sums[1] / count) / np.sqrt(spreads[0] * spreads[1])
    return np.where(usable & np.isfinite(alike), alike, np.nan)


def _dot(a: FloatArray, b: FloatArray) -> float:
    # Not BLAS: its sum depends on the number of threads, and for vectors the threads cost more than they bring.
    return float(np.einsum("i,i->", a, b))


def _correlate(x: FloatArray, y: FloatArray, reach: int) -> FloatArray:
    """Sum over i of x[i] y[i + k] for the lags k = -reach ... reach: array (2 reach + 1,).

    Overlap-save: x in blocks, each against the piece of y it can meet, the products summed as spectra. Unlike one
    transform over all of both it computes no lag that nobody asked for.
    """
    from scipy.fft import irfft, next_fast_len, rfft

    block = min(len(x), max(256, 6 * reach))
    count = -(-len(x) // block)
    window = block + 2 * reach
    pieces = np.zeros(count * block)
    pieces[: len(x)] = x
    around = np.zeros(count * block + 2 * reach)
    around[reach : reach + len(y)] = y
    met = np.lib.stride_tricks.sliding_window_view(around, window)[::block]
    size = next_fast_len(window, real=True)
    spectrum = np.einsum("ij,ij->j", rfft(pieces.reshape(count, block), size).conj(), rfft(met, size))
    return np.asarray(irfft(spectrum, size)[: 2 * reach + 1], dtype=np.float64)
