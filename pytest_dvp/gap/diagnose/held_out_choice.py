"""Between effects that the fitted data cannot tell apart, held-out data choose, where much is left over.

Far from the noise a wrong effect may do as well as the right one where it is fitted: a yaw rate that is shown 0.09 s
late for a steering that is 0.12 s late. What comes after it then is wrong as well, and fails on the next drive.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence

from pytest_dvp.gap.diagnose.held_out import Fold, refit_on_fold
from pytest_dvp.gap.diagnose.linear_algebra import square
from pytest_dvp.gap.diagnose.search import FAR, PRACTICAL, Search, SearchResult
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.gap.diagnose.whole_actuators import whole_actuators

_EXCHANGES = 4  # at most, of effects by rivals or whole actuators; chosen


def chosen(search: Search, found: SearchResult, judges: Sequence[Fold]) -> SearchResult:
    """The result with rivals in the place of effects, and what pays beside them: where a model without known remainder
    leaves FAR, the rival fits as well, and held-out data are better by what is worth an effect."""
    if search.target.excused or not judges or found.final.chi2 < FAR * search.count:
        return found
    final, rivals = found.final, dict(found.rivals)
    left = left_held_out(search, final, judges)
    for turn in range(_EXCHANGES):
        others = list(_alike(search, final, rivals))
        if turn == 0:  # they take as long as all rivals
            others += [o for o in whole_actuators(search, final) if search.cannot_tell_apart(final, o)]
        ranked = sorted(((left_held_out(search, other, judges), k) for k, other in enumerate(others)))
        if not ranked or ranked[0][0] > left - PRACTICAL * max(left, 1.0):
            break
        left, k = ranked[0]
        _exchange(search, final, others[k], rivals)
        final = others[k]
    if final is found.final:
        return found
    search.target.settle(final.values)
    final = search.pruned(search.grown(search.trial(final.names, final.values, zoom=True), []))
    search.target.settle(final.values)
    return dataclasses.replace(found, final=final, rivals={name: rivals.get(name, ()) for name in final.names})


def _alike(search: Search, final: Trial, rivals: Mapping[str, Sequence[str]]) -> Iterator[Trial]:
    """The set with a rival in the place of one effect, for each that has some."""
    for name in final.names:
        for other in search.in_place_of(final, name, rivals[name]) if rivals.get(name) else ():
            if search.is_credible(other, other.names[-1]):
                yield other


def _exchange(search: Search, final: Trial, other: Trial, rivals: dict[str, tuple[str, ...]]) -> None:
    """Say what is exchanged; what goes, and its rivals, are rivals of what comes."""
    new = [name for name in other.names if name not in final.names]
    gone = [name for name in final.names if name not in other.names]
    search.tick(f"held-out data choose {', '.join(new)}" + (f" in place of {', '.join(gone)}" if gone else ""))
    alike = dict.fromkeys((*gone, *(rival for name in gone for rival in rivals.get(name, ()))))
    for name in new:
        rivals[name] = tuple(rival for rival in alike if rival not in other.names)


def left_held_out(search: Search, trial: Trial, judges: Sequence[Fold]) -> float:
    """chi^2/N that a set leaves of the data that judge it."""
    left = sum(square(fold.judge.whitened(refit_on_fold(search, fold, trial).values)) for fold in judges)
    return left / max(sum(fold.judge.count for fold in judges), 1)
