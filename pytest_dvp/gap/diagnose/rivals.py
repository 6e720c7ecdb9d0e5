"""What these data cannot tell from a named effect, once all of them have been asked."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from math import inf

import numpy as np

from pytest_dvp.gap.diagnose.beyond_remainder import EVIDENT, all_show, as_told, is_evident_apart
from pytest_dvp.gap.diagnose.candidates import says_how
from pytest_dvp.gap.diagnose.first_order_gain import FirstOrderGain
from pytest_dvp.gap.diagnose.held_out import Fold, fold_excites, refit_on_fold
from pytest_dvp.gap.diagnose.search import MIN_BOOTSTRAP_SHARE, Search, SearchResult
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.logs.log_contents import FloatArray

RIVAL_SHARE = 0.5  # of what an effect explains, that another one must explain in its place to be a rival


def rivals_of(search: Search, judges: Sequence[Fold], found: SearchResult) -> dict[str, tuple[str, ...]]:
    """Rivals of each effect: those that the search met, those that do as well over parts of all data, and what changes
    while driving in the place of a constant.

    Beside a known remainder that is asked where the remainder lasts. There, what not all data show as more than the
    remainder is no rival of an effect that they show, unless the two are often confused.
    """
    final, changing = found.final, changing_instead(search, found.final)
    if not search.target.excused:
        return _joined(final.names, found.rivals, rivals_over_segments(search, judges, final), changing)
    told = as_told(search, final)
    shown = {name for name in final.names if is_evident_apart(search, told, name, judges)}

    def is_tied(name: str, other: str) -> bool:
        return search.known[name].is_tied(search.known[other])

    def possible(name: str, other: Trial) -> bool:
        return name not in shown or is_tied(name, other.names[-1]) or all_show(search, other, judges)

    met = {
        name: [other for other in rivals if name not in shown or is_tied(name, other)]
        for name, rivals in found.rivals.items()
    }
    alike = rivals_over_segments(search.lasting(), [fold.lasting() for fold in judges], told, possible)
    return _joined(final.names, met, alike, changing)


def _joined(names: Iterable[str], *rivals: Mapping[str, Sequence[str]]) -> dict[str, tuple[str, ...]]:
    return {name: tuple(dict.fromkeys(other for each in rivals for other in each.get(name, ()))) for name in names}


def rivals_over_segments(
    search: Search,
    judges: Sequence[Fold],
    best: Trial,
    possible: Callable[[str, Trial], bool] = lambda name, other: True,
) -> dict[str, tuple[str, ...]]:
    """Effects by the named one that do as well in its place, where parts of all the data are drawn by chance.
    possible: whether a set may be true that has another effect, its last one, in the place of this one.

    Where a model leaves more than noise, its errors repeat themselves from sample to sample, and a gap between two sets
    that noise could not make is no proof. Whole segments of the data fitted on and of those held out are drawn instead.
    """
    shown = [fold for fold in judges if all(fold_excites(search, fold, best, name) for name in best.names)]

    def segments(trial: Trial) -> FloatArray:
        parts = [trial.segment_chi2]
        for fold in shown:
            parts.append(fold.judge.by_segment(fold.judge.whitened(refit_on_fold(search, fold, trial).values)))
        return np.concatenate(parts)

    found: dict[str, tuple[str, ...]] = {}
    ahead = segments(best)
    for name in best.names:
        most = (1.0 - RIVAL_SHARE) * float((segments(search.without(best, name)) - ahead).sum())
        rivals = []
        for other in search.in_place_of(best, name):
            if not (search.is_rival(best, other, name) and search.is_credible(other, other.names[-1])):
                continue  # before it is fitted anew on each fold, which takes most of the time
            behind = segments(other)
            close = float((behind - ahead).sum()) < most
            alike = close and search.bootstrap_share(behind, ahead) < MIN_BOOTSTRAP_SHARE
            if alike and possible(name, other):
                rivals.append(other.names[-1])
        found[name] = tuple(rivals)
    return found


def changing_instead(search: Search, final: Trial) -> dict[str, tuple[str, ...]]:
    """Effects that change while driving and that a constant one which they refine does not clearly beat, by its name.

    An assist that grows with speed looks like a smaller steering ratio, and a known remainder may make up for the
    difference. So the constant has to stand EVIDENT before the other one with its shape in the middle of its range: at
    an end of it, it may be as good as constant.
    """
    lasting = search.target.lasting()
    now = search.trial(final.names, final.values, target=lasting)
    found: dict[str, tuple[str, ...]] = {}
    for name in final.names:
        rest = tuple(n for n in final.names if n != name)
        for refiner in search.refiners.values():
            if refiner.name in rest or not {name, search.contained(name)} & set(refiner.effect.diagnosed.refines):
                continue
            look = FirstOrderGain(lasting, search.trial(rest, final.values, target=lasting))
            shapes = [c for c in refiner.coordinates if says_how(c.key)]
            points = [p for p in refiner.points if all(0.2 < c.to_unit(p[c.name]) < 0.8 for c in shapes)]
            left = min((left for left, _ in look.remaining_chi2(refiner, points)), default=inf)
            if left < now.chi2 + EVIDENT**2:
                found[name] = (*found.get(name, ()), refiner.name)
    return found
