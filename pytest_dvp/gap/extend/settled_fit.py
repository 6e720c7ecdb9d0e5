"""A joint fit repeated until it and the beginnings of its segments agree."""

from __future__ import annotations

from pytest_dvp.gap.diagnose.search import Search
from pytest_dvp.gap.diagnose.trial import Trial

_ROUNDS = 5  # of fitting and of beginning the segments anew
_ENOUGH = 2e-4  # of chi^2/N: a round that gains less is the last


def settled_fit(search: Search, now: Trial) -> Trial:
    """The set fitted as well as it can be: where the segments begin depends on the values, and the values on where they
    begin."""
    for _ in range(_ROUNDS):
        before = now.chi2
        now = search.trial(now.names, now.values, zoom=True)
        search.target.settle(now.values)
        if before - now.chi2 < _ENOUGH * search.count:
            break
    return search.trial(now.names, now.values, zoom=True)
