"""Objective rating of a time signal against a reference: corridor, phase, magnitude, slope and their weighted sum.

Source: ISO/TS 18571:2014, Road vehicles - Objective rating metric for non-ambiguous signals, with its parameters.
"""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np

from machine_code import compiled
from pytest_dvp.logs.log_contents import FloatArray

A_0, B_0, K_Z = 0.05, 0.5, 2  # inner and outer corridor as a share of the largest reference, exponent
EPS_PHASE, K_PHASE = 0.2, 1  # largest shift as a share of the length
EPS_MAGNITUDE, K_MAGNITUDE = 0.5, 1
EPS_SLOPE, K_SLOPE = 2.0, 1
WEIGHTS = (0.4, 0.2, 0.2, 0.2)  # corridor, phase, magnitude, slope
BAND = 0.1  # half width of the dynamic time warping band as a share of the length
LONGEST = 1024  # samples warped at once


@dataclasses.dataclass(frozen=True, slots=True)
class Score:
    """Ratings from 0 (poor) to 1 (the same); total = 0.4 corridor + 0.2 (phase + magnitude + slope)."""

    corridor: float
    phase: float
    magnitude: float
    slope: float
    total: float


def score(measured: FloatArray, model: FloatArray, dt: float) -> Score:
    """Rate a model's signal against the measured one, both (n,) at the step dt [s]; n >= 10, finite.

    A signal longer than 1024 samples is warped in pieces of at most that length, whose magnitude errors are summed
    before they are rated: the band of the standard (10 % of the length) would let a log of an hour be warped by
    minutes. The slope is that of the standard: mean of 9 differences, no other filter; noise lowers it, so filter
    first. Raises ValueError for signals too short or of different length.
    """
    if len(measured) != len(model) or len(measured) < 10:
        raise ValueError(f"need two signals of the same length >= 10, found {len(measured)} and {len(model)}")
    reference, curve = np.ascontiguousarray(measured, np.float64), np.ascontiguousarray(model, np.float64)
    corridor = _corridor(reference, curve)
    shift = _shift(reference, curve)
    phase = max(0.0, 1.0 - abs(shift) / (EPS_PHASE * len(reference))) ** K_PHASE
    a = reference[max(0, -shift) : len(reference) - max(0, shift)]
    b = curve[max(0, shift) : len(curve) - max(0, -shift)]
    magnitude = _rated(*_warped(a, b), EPS_MAGNITUDE, K_MAGNITUDE)
    da, db = _slope(a, dt), _slope(b, dt)
    slope = _rated(float(np.abs(db - da).sum()), float(np.abs(da).sum()), EPS_SLOPE, K_SLOPE)
    parts = (corridor, phase, magnitude, slope)
    return Score(*parts, total=sum(w * p for w, p in zip(WEIGHTS, parts, strict=True)))


def _rated(error: float, norm: float, limit: float, power: int) -> float:
    """1 without error, 0 from `limit` times the norm on; a reference of zero is met exactly or not at all."""
    if norm <= 0.0:
        return 1.0 if error <= 0.0 else 0.0
    return float(max(0.0, (limit - error / norm) / limit) ** power)


def _corridor(reference: FloatArray, curve: FloatArray) -> float:
    largest = float(np.abs(reference).max())
    away = np.abs(reference - curve)
    if largest == 0.0:
        return float(np.mean(away == 0.0))
    rated = np.clip((B_0 * largest - away) / ((B_0 - A_0) * largest), 0.0, 1.0)
    return float(np.mean(rated**K_Z))


def _shift(reference: FloatArray, curve: FloatArray) -> int:
    """Samples by which the curve comes later than the reference (> 0), by the best correlation of what overlaps."""
    from scipy.fft import irfft, next_fast_len, rfft

    n = len(reference)
    reach = int(EPS_PHASE * n)
    shifts = np.arange(-reach, reach + 1)
    # Means off first: the sums below are differences of large numbers otherwise
    reference, curve = reference - reference.mean(), curve - curve.mean()
    size = next_fast_len(2 * n, real=True)
    circular = irfft(rfft(curve, size) * rfft(reference, size).conj(), size)
    products = np.concatenate([circular[size - reach :], circular[: reach + 1]])
    length = n - np.abs(shifts)
    late, early = np.maximum(shifts, 0), np.maximum(-shifts, 0)

    def sums(values: FloatArray, first: FloatArray) -> FloatArray:
        total = np.concatenate([[0.0], np.cumsum(values)])
        return np.asarray(total[first + length] - total[first])

    mean_c, mean_r = sums(curve, late), sums(reference, early)
    var_c = sums(curve**2, late) - mean_c**2 / length
    var_r = sums(reference**2, early) - mean_r**2 / length
    tiny = 1e-12 * max(float((curve**2).sum()), float((reference**2).sum()))
    good = (var_c > tiny) & (var_r > tiny)
    if not good.any():
        return 0
    rho = np.full(len(shifts), -np.inf)
    rho[good] = (products - mean_c * mean_r / length)[good] / np.sqrt(var_c[good] * var_r[good])
    best = float(rho.max())
    ties = shifts[rho >= best - 1e-12]
    return int(ties[np.argmin(np.abs(ties))])  # of equally good shifts the least


def _slope(values: FloatArray, dt: float) -> FloatArray:
    """Derivative [1/s]: central differences, then the mean of 9, of fewer at the ends."""
    raw = np.gradient(values, dt)
    total = np.concatenate([[0.0], np.cumsum(raw)])
    i = np.arange(len(raw))
    half = np.minimum(np.minimum(i, len(raw) - 1 - i), 4)
    return np.asarray((total[i + half + 1] - total[i - half]) / (2 * half + 1))


def _warped(reference: FloatArray, curve: FloatArray) -> tuple[float, float]:
    """Sum of the distances of the warped curves, and of the warped reference."""
    n = len(reference)
    pieces = -(-n // LONGEST)
    edges = [round(i * n / pieces) for i in range(pieces + 1)]
    error = norm = 0.0
    for first, end in itertools.pairwise(edges):
        e, w = _warp(reference[first:end], curve[first:end], max(1, int(BAND * (end - first))))
        error, norm = error + e, norm + w
    return error, norm


@compiled
def _warp(a: FloatArray, b: FloatArray, band: int) -> tuple[float, float]:
    """L1 distance of the two curves along the cheapest warping path (squared local cost, Sakoe-Chiba band), and the
    L1 norm of `a` along it."""
    n = len(a)
    width = 2 * band + 1
    step = np.zeros((n, width), dtype=np.int8)  # 0 from both, 1 from the row above, 2 from the left
    above = np.full(width + 2, np.inf)
    here = np.full(width + 2, np.inf)
    for i in range(n):
        here[:] = np.inf
        for k in range(max(0, band - i), min(width, n - i + band)):
            j = i + k - band
            # Column j of the row above stands one place further right, as the band moves with the row
            best, move = above[k + 1], 0
            if above[k + 2] < best:
                best, move = above[k + 2], 1
            if here[k] < best:
                best, move = here[k], 2
            if i == 0 and j == 0:
                best = 0.0
            here[k + 1] = best + (a[i] - b[j]) ** 2
            step[i, k] = move
        above, here = here, above
    error = norm = 0.0
    i, j = n - 1, n - 1
    while True:
        error += abs(a[i] - b[j])
        norm += abs(a[i])
        if i == 0 and j == 0:
            break
        move = step[i, j - i + band]
        if move != 2:
            i -= 1
        if move != 1:
            j -= 1
    return error, norm
