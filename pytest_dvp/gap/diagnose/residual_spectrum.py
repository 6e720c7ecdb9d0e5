"""Peaks in the spectrum of an error: over time, and over the distance driven."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from pytest_dvp.logs.log_contents import FloatArray

LEAST_CYCLES = 3.0  # in the longest log: a slower wave is a trend
FASTEST = 10.0  # Hz
SHORTEST = 0.25  # m of a wave
_CELL = 0.05  # m
_PADDED = 2  # times: the grid of frequencies is that much finer than the data resolve


@dataclasses.dataclass(frozen=True, slots=True)
class Peak:
    """kind "time" or "distance"; frequency in `unit` (Hz or 1/m); share: of the error's mean square that a wave of this
    frequency explains, every log with its own phase."""

    kind: str
    frequency: float
    unit: str
    share: float


def peaks(errors: Sequence[FloatArray], t: Sequence[FloatArray], way: Sequence[FloatArray]) -> list[Peak]:
    """The highest peak over time and over distance, the one that explains more first.

    errors (n,) of each log, 0 where not known; t (n,) [s]; way (n,) [m] driven so far, not decreasing.
    """
    step = min(float(np.median(np.diff(each))) for each in t)
    by_time = [np.interp(np.arange(each[0], each[-1], step), each, e) for e, each in zip(errors, t, strict=True)]
    by_way = []
    for e, each in zip(errors, way, strict=True):
        moved = np.append(True, np.diff(each) > 0.0)
        by_way.append(np.interp(np.arange(0.0, each[-1], _CELL), each[moved], e[moved]))
    found = [_peak("time", "Hz", by_time, step, FASTEST), _peak("distance", "1/m", by_way, _CELL, 1.0 / SHORTEST)]
    return sorted((p for p in found if p is not None), key=lambda p: -p.share)


def _peak(kind: str, unit: str, pieces: Sequence[FloatArray], step: float, fastest: float) -> Peak | None:
    longest = max(len(p) for p in pieces)
    if longest < 64:
        return None
    size = 1 << int(np.ceil(np.log2(_PADDED * longest)))
    power = np.zeros(size // 2 + 1)
    total = 0.0
    for piece in pieces:
        if len(piece) < 16:
            continue
        centred = piece - piece.mean()
        power += 2.0 / len(piece) * np.abs(np.fft.rfft(centred, size)) ** 2
        total += float(centred @ centred)
    frequency = np.arange(len(power)) / (size * step)
    usable = (frequency >= LEAST_CYCLES / (longest * step)) & (frequency <= min(fastest, 0.45 / step))
    if total <= 0.0 or not usable.any():
        return None
    k = int(np.flatnonzero(usable)[np.argmax(power[usable])])
    return Peak(kind, _vertex(frequency, power, k), unit, min(float(power[k]) / total, 1.0))


def _vertex(frequency: FloatArray, power: FloatArray, k: int) -> float:
    """Frequency of the vertex of the parabola through the peak and its neighbours."""
    if not 0 < k < len(power) - 1:
        return float(frequency[k])
    left, middle, right = power[k - 1 : k + 2]
    bend = left - 2.0 * middle + right
    shift = 0.5 * (left - right) / bend if bend < 0.0 else 0.0
    return float(frequency[k] + shift * (frequency[1] - frequency[0]))
