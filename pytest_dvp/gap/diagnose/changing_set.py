"""Effects that change while driving, in the place of constant ones: a brake that fades instead of one that is weak.

They can do what many others do, so a search asks for them at its end only.
"""

from __future__ import annotations

from collections.abc import Iterator

from pytest_dvp.gap.diagnose.candidates import Candidate
from pytest_dvp.gap.diagnose.first_order_gain import FirstOrderGain
from pytest_dvp.gap.diagnose.search import FAR, Search
from pytest_dvp.gap.diagnose.trial import Trial

_BEGINNINGS = 2  # points of an effect's range from which a fit of it starts


def refined(search: Search, best: Trial, rivals: dict[str, tuple[str, ...]]) -> Trial:
    """The set with an effect that changes while driving, in the place of a constant one or beside all, if that does
    better. Where it does as well, it joins the `rivals` of those whose place it takes."""
    alone = len(best.names) == 1 and not search.target.excused  # noise that holds a remainder hides what changes
    if not best.names or (alone and search.within_noise(best)):
        return best  # where two are named, they may stand for one that changes, and leave no more than noise
    if search.bare and best.chi2 > FAR * search.count:
        return best  # a hill that explained a drive of an SUV, with much else missing, was on no other drive
    start = best
    for refiner in search.refiners.values():
        for other in _with_refiner(search, start, refiner):
            remainder = search.target.excused and search.cannot_tell_apart(other, start)  # it may make the gap
            if search.cost(other) < search.cost(best) - 1e-3 * search.count and not remainder:
                best = other
            elif search.cannot_tell_apart(start, other):
                for name in set(start.names) - set(other.names):
                    rivals[name] = tuple(dict.fromkeys((*rivals.get(name, ()), refiner.name)))
    if best is start:
        return best
    search.target.settle(best.values)
    return search.credible_set(search.trial(best.names, best.values, zoom=True, like=best))


def _with_refiner(search: Search, start: Trial, refiner: Candidate) -> Iterator[Trial]:
    """Sets that have an effect that changes while driving: beside all others, without those that it refines, and
    without all that are often confused with it; in each what does not pay any more is dropped."""
    refines = refiner.effect.diagnosed.refines
    bases = {name for name in start.names if name in refines or search.contained(name) in refines}
    if not (bases or search.misfit(start)):
        return
    search.tick(f"does it change while driving: {refiner.name}")
    left_out = (set[str](), bases, bases | set(refiner.effect.ties))
    for names in dict.fromkeys(tuple(n for n in start.names if n not in out) for out in left_out):
        without = start if names == start.names else search.trial(names, start.values, like=start)
        options = FirstOrderGain(search.target, without).remaining_chi2(refiner, refiner.points)
        for _, point in sorted(options, key=lambda option: option[0])[:_BEGINNINGS]:
            with_it = search.trial((*names, refiner.name), without.values | point, like=without)
            if search.is_worth_adding(without, with_it) and search.is_credible(with_it, refiner.name):
                less = search.pruned(with_it)
                if refiner.name in less.names:
                    yield less
