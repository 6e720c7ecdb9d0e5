"""Noise whose neighbouring samples are alike: how much, seen while the car stands, and residuals freed of it.

A sensor that filters, or a receiver that drifts, repeats its error from sample to sample. Counted as if each sample
were news, such noise looks many times larger than it is (chi^2/N far above 1), and intervals come out too narrow. So a
residual is whitened: of each sample is taken what its neighbours already say.

Source: G. E. P. Box, G. M. Jenkins, Time Series Analysis, ch. 3 (autoregressive processes, Yule-Walker equations).
"""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
from numpy.typing import NDArray

from machine_code import compiled
from pytest_dvp.gap.compare.segments import CHANNELS, filled, standing
from pytest_dvp.logs.log_contents import FloatArray

BoolArray = NDArray[np.bool_]

ORDER = 3  # neighbours that count: enough for a first or second order filter
ALIKE = 0.35  # correlation of neighbours from which noise is coloured; of 100 white samples one log in 4000 shows it
FEWEST = 100  # samples at standstill from which a correlation is told
FEWEST_EFFECTIVE = 4.0  # independent ones among them: a slower drift cannot be told from a line
QUIET = 0.7  # of the noise floor of the whole log: a channel that is quieter at standstill shows another noise there
CREEPS = 0.05  # m in a second that a car moves at least where it creeps; chosen, at 0.3 m/s it counts as standing
CLEAR = 6.0  # standard deviations of the position by which it must move; chosen
_STEER = CHANNELS.index("steer")
_SAME_STEP = 1.5  # times the usual step, above which neighbours are no neighbours


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Whitening:
    """How the residuals of a log are whitened.

    sigma (8,) standard deviation of each channel in its unit, inf where it is not judged; weights (8, ORDER + 1, ORDER)
    of the neighbours before by the number of them that are known; gain (8, ORDER + 1) what is left of the standard
    deviation then; independent (8,) share of the samples that are independent, 1 for white noise
    """

    sigma: FloatArray
    weights: FloatArray
    gain: FloatArray
    independent: FloatArray

    def of(self, values: FloatArray, first: BoolArray) -> FloatArray:
        """Whitened residuals (n * 8,), row by row, 0 where nothing was compared. values (n, 8) in the channels' units,
        NaN: not compared; first (n,): rows without a neighbour before them, such as the first of a segment."""
        return _whitened(values, self.sigma, self.weights, self.gain, first)

    def scaled(self, sigma: FloatArray) -> Whitening:
        """This whitening with other standard deviations (8,), each in the unit of its channel."""
        return dataclasses.replace(self, sigma=sigma)


def whitening(t: FloatArray, measured: FloatArray, sigma: FloatArray) -> Whitening:
    """The noise of a log as it shows while the car stands. t (n,) [s]; measured (n, 8) and its noise floor sigma (8,)
    in the channels' units.

    The noise floor comes from differences of neighbours, which coloured noise makes small; where noise is coloured, the
    standard deviation is the one seen at standstill, if that is larger. A log without a standstill of FEWEST samples
    counts as white, as does a channel that is quieter there than on the road (a wheel's sensor shows 0), and the
    steering, which moves while the car stands as well. Where the car creeps to its stop it does not stand.
    """
    found = Whitening(
        sigma.copy(), np.zeros((len(CHANNELS), ORDER + 1, ORDER)), np.ones((len(CHANNELS), ORDER + 1)),
        np.ones(len(CHANNELS)),
    )  # fmt: skip
    whole = filled(t, measured)
    still = standing(t, np.where(_creeping(t, whole, sigma), 1.0, whole[:, 3]))  # m/s: it drives
    for k in np.flatnonzero(np.isfinite(sigma)).tolist():
        if k == _STEER:
            continue
        pieces = [_level(t[rows], measured[rows, k]) for rows in _runs(t, still & np.isfinite(measured[:, k]))]
        correlation, level = _correlation(pieces)
        if correlation is None or level < QUIET * sigma[k]:
            continue
        weights, gain = _levinson(correlation)
        share = (1.0 - weights[ORDER].sum()) ** 2 / gain[ORDER] ** 2
        samples = sum(len(piece) for piece in pieces)
        if share >= 1.0 or share * samples < FEWEST_EFFECTIVE:
            continue
        lost = 2.0 * len(pieces) / (share * samples)  # a level and a slope were taken out of each piece
        found.sigma[k] = max(sigma[k], level / np.sqrt(max(1.0 - lost, 0.5)))
        found.weights[k], found.gain[k], found.independent[k] = weights, gain, share
    return found


def _creeping(t: FloatArray, whole: FloatArray, sigma: FloatArray) -> BoolArray:
    """Rows (n,) in whose second the car moves by CREEPS and more, as its speed and its position say alike. whole (n, 8)
    without gaps, sigma (8,), in the channels' units; none where the position is not measured so finely."""
    least = max(CREEPS, CLEAR * float(np.hypot(*sigma[:2])))
    if not np.isfinite(whole[:, :4]).all() or not np.isfinite(least):
        return np.zeros(len(t), dtype=np.bool_)
    before, after = (np.interp(t + half, t, np.arange(len(t))).round().astype(int) for half in (-0.5, 0.5))
    way = np.concatenate([[0.0], np.cumsum(0.5 * (whole[1:, 3] + whole[:-1, 3]) * np.diff(t))])
    driven = way[after] - way[before]
    east, north = (whole[after, k] - whole[before, k] for k in (0, 1))
    moved = east * np.cos(whole[:, 2]) + north * np.sin(whole[:, 2])
    return np.asarray((np.abs(moved) >= least) & (np.abs(moved - driven) <= 0.5 * np.abs(moved)))


def first_rows(t: FloatArray, starts: NDArray[np.int64]) -> BoolArray:
    """Rows (n,) without a neighbour before them: those at `starts` and after a gap in the stamps t (n,) [s]."""
    found = np.zeros(len(t), dtype=np.bool_)
    found[starts[starts < len(t)]] = True
    steps = np.diff(t)
    if len(steps):
        found[1:] |= steps > _SAME_STEP * float(np.median(steps))
    return found


def _runs(t: FloatArray, rows: BoolArray) -> list[slice]:
    """Stretches of rows without a gap, long enough for a line and its neighbours."""
    broken = first_rows(t, np.zeros(1, dtype=np.int64))
    edges = np.flatnonzero(np.diff(np.concatenate([[0], rows.astype(np.int8), [0]]))).reshape(-1, 2)
    found = []
    for begin, end in edges:
        cuts = [begin, *(begin + 1 + np.flatnonzero(broken[begin + 1 : end])), end]
        found += [slice(int(a), int(b)) for a, b in itertools.pairwise(cuts) if b - a > 8 * ORDER]
    return found


def _level(t: FloatArray, y: FloatArray) -> FloatArray:
    """What is left of a signal beside a straight line: its drift is no noise of the sensor."""
    s = t - t.mean()
    return np.asarray(y - y.mean() - s * float(s @ y) / float(s @ s))


def _correlation(pieces: list[FloatArray]) -> tuple[FloatArray | None, float]:
    """Correlation (ORDER + 1,) of samples 0, 1, ... steps apart and standard deviation; None where noise is white, or
    too little of it is there."""
    samples = sum(len(piece) for piece in pieces)
    square = sum(float(piece @ piece) for piece in pieces)
    if samples < FEWEST or square <= 0.0:
        return None, 0.0
    products = [sum(float(p[lag:] @ p[: len(p) - lag]) for p in pieces) for lag in range(ORDER + 1)]
    pairs = [sum(len(p) - lag for p in pieces) for lag in range(ORDER + 1)]
    found = np.array([product / n for product, n in zip(products, pairs, strict=True)]) / (square / samples)
    if found[1] < ALIKE:
        return None, 0.0
    return found, float(np.sqrt(square / samples))


def _levinson(correlation: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Weights of the neighbours (ORDER + 1, ORDER) and what is left of the standard deviation (ORDER + 1,), with 0, 1,
    ... neighbours known."""
    weights, left = np.zeros((ORDER + 1, ORDER)), np.ones(ORDER + 1)
    for p in range(1, ORDER + 1):
        before = weights[p - 1, : p - 1]
        partial = (correlation[p] - before @ correlation[p - 1 : 0 : -1]) / left[p - 1]
        partial = float(np.clip(partial, -0.999, 0.999))
        weights[p, : p - 1] = before - partial * before[::-1]
        weights[p, p - 1] = partial
        left[p] = left[p - 1] * (1.0 - partial * partial)
    return weights, np.sqrt(left)


@compiled
def _whitened(
    values: FloatArray, sigma: FloatArray, weights: FloatArray, gain: FloatArray, first: BoolArray
) -> FloatArray:
    n, m = values.shape
    most = weights.shape[2]
    out = np.zeros(n * m)
    for k in range(m):
        if not (np.isfinite(sigma[k]) and sigma[k] > 0.0):
            continue
        known = 0
        for i in range(n):
            if first[i]:
                known = 0
            if not np.isfinite(values[i, k]):
                known = 0
                continue
            value = values[i, k]
            for j in range(known):
                value -= weights[k, known, j] * values[i - 1 - j, k]
            out[i * m + k] = value / (sigma[k] * gain[k, known])
            known = min(known + 1, most)
    return out
