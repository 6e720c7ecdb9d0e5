"""How far beyond clean drives a bound must lie for a stated rate of false alarms."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

TAIL = 0.1  # share of the drives that tell how the tail falls
DEVIATIONS = 6.5  # standard deviations that a bound keeps at least: a normal quantity is beyond once in 2e10
LEAST = 10  # values; of fewer, no tail can be told


def upper_bound(values: Sequence[float], rate: float, margin: float = 0.0) -> float:
    """Bound above `values` that the next clean drive breaks with probability `rate` (0 < rate < TAIL) at most.

    The excess over the 90th percentile is taken to fall exponentially with the mean that it has (a generalised Pareto
    tail of shape 0: peaks over threshold, Coles, An Introduction to Statistical Modeling of Extreme Values, 2001,
    section 4.2; tails of normal and of bounded quantities fall faster). Few excesses tell their mean badly, so the
    bound is at least DEVIATIONS standard deviations above the mean, and `margin`, in the unit of the values, above the
    greatest; of a tail that itself is exponential, 60 values keep ten times the rate. It does not know of a rare other
    course of events that none of the drives took. Raises ValueError for fewer than LEAST values or a rate that is none.
    """
    found = np.sort(np.asarray(values, dtype=np.float64))
    if len(found) < LEAST or not 0.0 < rate < TAIL:
        raise ValueError(f"{len(found)} values and a rate of {rate:g}: at least {LEAST}, and between 0 and {TAIL:g}")
    threshold = float(np.quantile(found, 1.0 - TAIL))
    beyond = found[found > threshold] - threshold
    excess = float(beyond.mean()) if len(beyond) else 0.0
    tail = threshold + excess * math.log(TAIL / rate)
    return max(tail, float(found.mean()) + DEVIATIONS * float(found.std(ddof=1)), float(found[-1]) + margin)


def lower_bound(values: Sequence[float], rate: float, margin: float = 0.0) -> float:
    """As `upper_bound`, below the values."""
    return -upper_bound([-value for value in values], rate, margin)
