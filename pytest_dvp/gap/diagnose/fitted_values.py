"""Fitted values as a model file holds them, with their intervals."""

from __future__ import annotations

from typing import TypeAlias

from pytest_dvp.gap.diagnose.diagnosis import Estimate
from pytest_dvp.gap.diagnose.least_squares import intervals, widen_dead_times
from pytest_dvp.gap.diagnose.search import Search
from pytest_dvp.gap.diagnose.trial import Trial

DIGITS = 6  # significant, of a value in a model file

Estimates: TypeAlias = dict[tuple[str, str], Estimate]
"""(effect, key) -> value with interval."""


def estimates(final: Trial, search: Search) -> Estimates:
    """Fitted values as they are written, with their 95 % intervals."""
    sure = intervals(final.fit, search.starts, search.target.exact(final.values))
    sure = widen_dead_times(search.target, final.fit, final.values, sure)
    found: Estimates = {}
    for c in final.fit.coordinates:
        low, high = sure[c.name]
        value = rounded(final.values[c.name])
        found[c.name] = Estimate(value, min(rounded(low), value), max(rounded(high), value), c.key.unit)
    return found


def rounded(value: float) -> float:
    """To DIGITS significant digits."""
    return float(f"{value:.{DIGITS}g}")
