"""Zero-phase low pass, compiled: a declared filter that costs no import of scipy.signal (1 s)."""

from __future__ import annotations

import math

import numpy as np

from machine_code import compiled
from pytest_dvp.logs.log_contents import FloatArray

PAD = 6.0
"""Periods of the cut-off; the start of the recursion has faded to exp(-sqrt(2) pi PAD) = 3e-12 by then."""


def low_pass(values: FloatArray, step: float, cutoff: float) -> FloatArray:
    """Butterworth of order 2 with -3 dB at `cutoff` [Hz], run forwards and backwards over samples `step` [s] apart.

    Both runs together: no phase, gain 1 / (1 + (f/cutoff)^4) (bilinear, frequency prewarped). The ends are extended
    by odd reflection, as scipy.signal.filtfilt does with padtype "odd", over PAD periods of the cut-off.

    Raises ValueError unless 0 < cutoff < half the sampling rate.
    """
    if not 0.0 < cutoff < 0.5 / step:
        raise ValueError(f"cut-off {cutoff:g} Hz is not between 0 and {0.5 / step:g} Hz, half the sampling rate")
    k = math.tan(math.pi * cutoff * step)
    scale = 1.0 / (1.0 + math.sqrt(2.0) * k + k * k)
    b0 = k * k * scale
    a1 = 2.0 * (k * k - 1.0) * scale
    a2 = (1.0 - math.sqrt(2.0) * k + k * k) * scale
    pad = min(len(values) - 1, math.ceil(PAD / (cutoff * step)))
    front = 2.0 * values[0] - values[pad:0:-1]
    back = 2.0 * values[-1] - values[-2 : -pad - 2 : -1]
    extended = np.concatenate((front, values, back))
    there = _biquad(extended, b0, a1, a2)
    again = _biquad(there[::-1].copy(), b0, a1, a2)[::-1]
    return np.ascontiguousarray(again[pad : pad + len(values)])


@compiled
def _biquad(x: FloatArray, b0: float, a1: float, a2: float) -> FloatArray:
    """b = b0 * (1, 2, 1), transposed direct form II, started as if x[0] had lasted for ever."""
    y = np.empty_like(x)
    b1 = 2.0 * b0
    s1 = x[0] * (1.0 - b0)
    s2 = x[0] * (b0 - a2)
    for i in range(x.shape[0]):
        out = b0 * x[i] + s1
        s1 = b1 * x[i] - a1 * out + s2
        s2 = b0 * x[i] - a2 * out
        y[i] = out
    return y
