"""Between effects that the fitted data cannot tell apart, held-out data choose, where much is left over.

Far from the noise a wrong effect may do as well as the right one where it is fitted: a yaw rate that is shown 0.09 s
late for a steering that is 0.12 s late. What comes after it then is wrong as well, and fails on the next drive.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from pytest_dvp.gap.diagnose.held_out import Fold, refit_on_fold
from pytest_dvp.gap.diagnose.linear_algebra import square
from pytest_dvp.gap.diagnose.masked_pairs import actuators
from pytest_dvp.gap.diagnose.search import FAR, PRACTICAL, Search, SearchResult
from pytest_dvp.gap.diagnose.trial import Trial

_EXCHANGES = 4  # of effects by their rivals, at most; chosen


def chosen(search: Search, found: SearchResult, judges: Sequence[Fold]) -> SearchResult:
    """The result with rivals in the place of effects, and what pays beside them: where a model without known remainder
    leaves FAR, the rival fits as well, and held-out data are better by what is worth an effect."""
    final, rivals = found.final, dict(found.rivals)
    if search.target.excused or not judges or final.chi2 < FAR * search.count:
        return found
    best, asked = left_held_out(search, final, judges), set[frozenset[str]]()
    for turn in range(_EXCHANGES):  # actuators once: they take as long as all rivals
        options = [
            (left_held_out(search, other, judges), "", other)
            for other in (actuators(search, final) if turn == 0 else ())
            if other.chi2 < final.chi2 or search.cannot_tell_apart(final, other)
        ]
        for name in final.names:
            few = rivals.get(name, ())
            if few and (key := frozenset({*final.names} ^ {name, *few})) not in asked:
                asked.add(key)
                for other in search.in_place_of(final, name):
                    if other.names[-1] in few and search.is_credible(other, other.names[-1]):
                        options.append((left_held_out(search, other, judges), name, other))
        if not options:
            break
        left, name, other = min(options, key=lambda option: option[0])
        if left > best - PRACTICAL * max(best, 1.0):
            break
        new = [n for n in other.names if n not in final.names]
        gone = [n for n in final.names if n not in other.names]
        search.tick(f"held-out data choose {', '.join(new)}" + (f" in place of {', '.join(gone)}" if gone else ""))
        for one in new:
            rivals[one] = (*gone, *(r for r in rivals.get(name, ()) if r not in other.names))
        final, best = other, left
    if final is found.final:
        return found
    search.target.settle(final.values)
    final = search.pruned(search.grown(search.trial(final.names, final.values, zoom=True), []))
    search.target.settle(final.values)
    return dataclasses.replace(found, final=final, rivals={name: rivals.get(name, ()) for name in final.names})


def left_held_out(search: Search, trial: Trial, judges: Sequence[Fold]) -> float:
    """chi^2/N that a set leaves of the data that judge it."""
    left = sum(square(fold.judge.whitened(refit_on_fold(search, fold, trial).values)) for fold in judges)
    return left / max(sum(fold.judge.count for fold in judges), 1)
