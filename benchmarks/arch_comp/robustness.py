"""Robustness of signal temporal logic over signals that are sampled at equal steps.

How far each sample is from violating, in the measure of the atoms, below 0 for a violation. "And" is the smaller of two
and "or" the larger one. Source: Donzé and Maler, Robust satisfaction of temporal logic over real-valued signals,
FORMATS 2010.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import minimum_filter1d

from pytest_dvp.logs.log_contents import FloatArray


def always(margin: FloatArray, begin: float, end: float, step: float) -> FloatArray:
    """The least of each sample's window from `begin` to `end` [s] ahead of it.

    A window that reaches beyond the last sample ends there; one that begins beyond it holds nothing: infinity.
    """
    first = math.ceil(begin / step - 1e-6)
    last = math.floor(end / step + 1e-6)
    size, count = last - first + 1, len(margin)
    ahead = np.concatenate([margin[first:], np.full(min(first, count) + size, math.inf)])
    # the filter's window begins with the sample itself
    return minimum_filter1d(ahead, size, mode="nearest", origin=-(size // 2))[:count]


def eventually(margin: FloatArray, begin: float, end: float, step: float) -> FloatArray:
    """The greatest of each sample's window from `begin` to `end` [s] ahead of it; of none: minus infinity."""
    return -always(-margin, begin, end, step)


def implies(one: FloatArray, other: FloatArray) -> FloatArray:
    """Where `one` holds, so does `other`."""
    return np.maximum(-one, other)
