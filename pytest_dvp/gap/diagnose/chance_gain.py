"""What luck can buy: the gain that trying all effects would find on an error that none of them made."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.gap.compare.start_correction import IntArray
from pytest_dvp.gap.diagnose.candidates import Candidate
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, Values
from pytest_dvp.gap.diagnose.linear_algebra import orthonormal, row_products, square
from pytest_dvp.logs.log_contents import FloatArray

DRAWS = 40  # the fewest that have two beyond the quantile; each costs a first-order search
QUANTILE = 0.95  # of the draws: luck alone names an effect in 5 of 100 searches
_SEED = 11  # any; fixed, so that the same logs give the same answer
_CHANGE = 1e-7  # of chi^2/N, below which an effect does nothing here
_NEW = 1e-6  # share of a change that fitted parameters cannot do, below which nothing of it is left


def chance_gain(
    target: ExperimentSet,
    values: Values,
    tried: Sequence[Candidate],
    *,
    jacobian: FloatArray | None = None,
    draws: int = DRAWS,
) -> float:
    """Gain in chi^2/N that the best of the `tried` effects finds on surrogates of the error left with `values`.

    A surrogate has the spectrum of the error in each channel and segment, and random phases: what an effect explains of
    it, it explains by chance. Of each surrogate the best first-order gain over all effects and all points at which a
    search would try them; of `draws` surrogates the 95 % quantile. `jacobian` (p, N), in units of the noise: what
    fitted parameters do, which is taken out first. An effect that gains no more than this has not been found. 0 if the
    error is zero.

    Source: J. Theiler et al., Testing for nonlinearity in time series: the method of surrogate data, Physica D 58
    (1992) 77. First order: a gain that a non-linear fit would stretch further is not seen.
    """
    r = target.whitened(values)
    count = max(target.count, 1)
    kept = np.flatnonzero(r)
    basis = orthonormal(jacobian[:, kept] if jacobian is not None else np.zeros((0, len(kept))))
    surrogates = _surrogates(r, _pieces(target), draws)[:, kept]
    for one in surrogates:
        one -= _within(basis, one)
    best = np.zeros(draws)
    present = {name for name, _ in values}
    for candidate in tried:
        if candidate.name in present:
            continue
        for point in candidate.coarse:
            change = (target.whitened({**values, **point}) - r)[kept]
            whole = square(change)
            if not np.isfinite(whole) or whole / count < _CHANGE:
                break  # the strongest comes first
            change = change - _within(basis, change)
            size = square(change)
            if size > _NEW * whole:
                best = np.maximum(best, row_products(surrogates, change) ** 2 / size)
    return float(np.quantile(best, QUANTILE)) / count


def _within(basis: FloatArray, row: FloatArray) -> FloatArray:
    """The part of a row (N,) that lies in the span of the basis (q, N)."""
    found = np.zeros_like(row)
    for direction, share in zip(basis, row_products(basis, row), strict=True):
        found += share * direction
    return found


def _pieces(target: ExperimentSet) -> list[IntArray]:
    """Places in the residual of each channel of each segment."""
    width, found, offset = len(CHANNELS), [], 0
    for e in target.experiments:
        for first, end in zip(e.edges[:-1], e.edges[1:], strict=True):
            for name in e.channels:
                found.append(np.arange(offset + first + CHANNELS.index(name), offset + end, width, dtype=np.int64))
        offset += int(e.edges[-1])
    return found


def _surrogates(r: FloatArray, pieces: Sequence[IntArray], draws: int) -> FloatArray:
    """(draws, N): each piece of r with its spectrum and its sum of squares, and random phases; zeros stay."""
    rng = np.random.default_rng(_SEED)
    found = np.zeros((draws, len(r)))
    for piece in pieces:
        own = piece[r[piece] != 0.0]
        n = len(own)
        if n < 4:
            continue
        spectrum = np.abs(np.fft.rfft(r[own])) * np.exp(2j * np.pi * rng.random((draws, n // 2 + 1)))
        spectrum[:, 0] = np.abs(spectrum[:, 0]) * rng.choice([-1.0, 1.0], draws)
        if n % 2 == 0:
            spectrum[:, -1] = np.abs(spectrum[:, -1]) * rng.choice([-1.0, 1.0], draws)
        found[:, own] = np.fft.irfft(spectrum, n, axis=1)
    return found
