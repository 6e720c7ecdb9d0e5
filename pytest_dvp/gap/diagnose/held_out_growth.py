"""Far from the noise, effects that only the fitted drive asks for make room for what held-out drives ask for as well.

A coupe's rolling resistance had been fitted as a dead band of its pedal and its slight slope as a hill: both do better
on the drive that is fitted, and worse on every other one. No single rival does as well in the place of one of them, so
the set is grown again without it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

from pytest_dvp.gap.diagnose.held_out import Fold
from pytest_dvp.gap.diagnose.held_out_choice import left_held_out
from pytest_dvp.gap.diagnose.search import FAR, MOST, PRACTICAL, Search, SearchResult
from pytest_dvp.gap.diagnose.trial import Trial

SUSPECTS = 3  # effects that are tried in a turn, those of least use on held-out data first; chosen: each is a search
TURNS = 4  # at most; chosen
MORE = 3  # effects in the place of one, however many there are: held-out data judge them; chosen


def grown_for_held_out(search: Search, found: SearchResult, judges: Sequence[Fold]) -> SearchResult:
    """The result with sets without effects of no use on held-out data, as long as these gain by it what is worth an
    effect: where a model without known remainder leaves FAR, and drives of their own are held out. Parts of the drives
    that are fitted on would need each set fitted to the others, which takes minutes."""
    if search.target.excused or not judges or found.final.chi2 < FAR * search.count:
        return found
    if any(fold.fitted is not None for fold in judges):
        return found
    final, rivals = found.final, dict(found.rivals)
    barred: list[str] = []
    left = left_held_out(search, final, judges)
    for _ in range(TURNS):
        worth = PRACTICAL * max(left, 1.0)
        options: list[tuple[float, str, Trial]] = []
        for without, name in _suspects(search, final, judges, left + worth):
            search.tick(f"held-out data need no {name}: chi²/N {left:.3g}")
            for other in _others(search, final, name, barred):
                held = left_held_out(search, other, judges)
                if held < min(left, without) - worth:  # what comes must pay there: a veto takes out what only goes
                    options.append((held, name, other))
            search.target.settle(final.values)
        if not options:
            break
        _, gone, other = min(options, key=lambda option: option[0])
        barred.append(gone)
        rivals |= {new: (gone,) for new in other.names if new not in final.names}
        search.target.settle(other.values)
        final = search.trial(other.names, other.values, zoom=True, like=other)
        left = left_held_out(search, final, judges)
    if final is found.final:
        return found
    return dataclasses.replace(found, final=final, rivals={name: rivals.get(name, ()) for name in final.names})


def _suspects(search: Search, final: Trial, judges: Sequence[Fold], bound: float) -> list[tuple[float, str]]:
    """Effects without which held-out data are left with less than `bound` (chi^2/N), with that, the least first."""
    left = [(left_held_out(search, search.without(final, name), judges), name) for name in final.names]
    return sorted(pair for pair in left if pair[0] < bound)[:SUSPECTS]


def _others(search: Search, final: Trial, name: str, barred: Sequence[str]) -> Iterator[Trial]:
    """The set with another effect in the place of this one, and with all that pays without it."""
    less = search.without(final, name)
    yield from (trial for trial in search.in_place_of(final, name) if trial.names[-1] not in barred)
    search.target.settle(less.values)
    most = max(MOST, len(less.names) + MORE)
    yield search.pruned(search.grown(search.trial(less.names, less.values), [], (*barred, name), most))
