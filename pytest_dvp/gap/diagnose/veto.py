"""Data that were not fitted on have the last word on each effect of a set."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeAlias

from pytest_dvp.gap.diagnose.beyond_remainder import (
    as_told,
    is_beyond_remainder,
    is_clear,
    is_evident_apart,
    is_imitated,
)
from pytest_dvp.gap.diagnose.changing_set import refined
from pytest_dvp.gap.diagnose.held_out import ROUNDING, Fold, fold_excites, refit_on_fold
from pytest_dvp.gap.diagnose.held_out_choice import chosen
from pytest_dvp.gap.diagnose.held_out_growth import grown_for_held_out
from pytest_dvp.gap.diagnose.linear_algebra import square
from pytest_dvp.gap.diagnose.quiet_effects import quiet
from pytest_dvp.gap.diagnose.search import FAR, PRACTICAL, Search, SearchResult
from pytest_dvp.gap.diagnose.standing import ABOVE_REMAINDER
from pytest_dvp.gap.diagnose.trial import Trial
from vehicle.model.effect_catalogue import run_setups

MIN_SETUP_GAIN = 0.01  # of max(1, chi^2/N), that a run's own set-up must gain on the rest of it
LITTLE = 2.0 * ABOVE_REMAINDER  # of chi^2/N: what gains no more where it is fitted may be made of the known remainder
SLIGHT = 0.01  # of what an effect gains where it is fitted: a smaller loss elsewhere is no veto
SLIGHT_BESIDE = 0.05  # the same, beside a known remainder that imitates nothing like it; chosen: a steering that sticks
# lost 1.3 % on a drive that does not show it
SLIGHT_SHOWN = 0.2  # the same, if both the data fitted on and held out show it where the remainder lasts; chosen: a
# brake lag lost 7 % in town, where all errors were far below what the remainder may be
SLIGHT_FAR = 0.2  # the same, where a model without known remainder leaves FAR: what else is missing takes part in the
# loss. A limit on the rate of a van's steering gained 0.53 on a hard drive and lost 0.08 on a mild one

Apart: TypeAlias = Callable[[], tuple[Fold, ...]]
"""Judges whose runs have a set-up of their own, made when they are asked for."""


class Judged(NamedTuple):
    """What is left of a search's result, the effects taken out, what each one left gains on the judging data (chi^2/N),
    the judges that were asked in the end, and whether they took part in choosing the effects."""

    found: SearchResult
    vetoed: tuple[str, ...]
    gains: dict[str, float]
    judges: tuple[Fold, ...]
    chose: bool = False


def judged(search: Search, found: SearchResult, judges: tuple[Fold, ...], apart: Apart) -> Judged:
    """The result without effects that lose on data they were not fitted on.

    Of a twin with a known remainder, effects that gain no more than that may change by go, too, unless too much is left
    over without them: something new is there then, and what explains it best is told, even if no other data show it.
    Where nothing is named any more that a remainder could not be, an effect that is quieter than they seemed may be
    there, and is asked for.
    """
    preferred = grown_for_held_out(search, chosen(search, found, judges), judges)
    strict = _veto(search, preferred, judges, apart, fragment=ABOVE_REMAINDER)
    strict = strict._replace(chose=preferred is not found)
    if not (search.target.excused and strict.vetoed):
        return strict
    new = search.misfit(strict.found.final)
    if new:
        strict = _asked_anew(search, _veto(search, found, judges, apart, fragment=PRACTICAL, new=True), apart)
        new = bool(strict.found.final.names)
    rivals = dict(strict.found.rivals)  # without what was vetoed, another effect may be seen to change while driving
    left = strict.found.final
    final = None if new else quiet(search, left, strict.judges)
    final = final or (refined(search, left, rivals) if left.names else left)
    if final.names == strict.found.final.names:
        return strict
    again = _veto(search, dataclasses.replace(strict.found, final=final, rivals=rivals), strict.judges, lambda: (),
                  fragment=PRACTICAL, new=new)  # fmt: skip
    return again._replace(vetoed=(*strict.vetoed, *again.vetoed), chose=strict.chose)


def _asked_anew(search: Search, refuted: Judged, apart: Apart) -> Judged:
    """Where held-out data refute all that was found, and too much is left over: what explains it without that, and
    without what means nothing, asked until nothing else is found."""
    barred = set(refuted.vetoed)
    while search.misfit(refuted.found.final) and not refuted.found.final.names:
        search.tick("without what held-out data refute")
        grown = search.grown(search.trial((), search.start), [], barred=barred)
        final = search.credible_set(search.trial(grown.names, grown.values, zoom=True, like=grown))
        other = SearchResult(final, {}, refuted.found.not_excited)
        again = _veto(search, other, refuted.judges, apart, fragment=PRACTICAL, new=True)
        gone = {*grown.names, *final.names} - {*again.found.final.names} - barred
        refuted = again._replace(vetoed=tuple(dict.fromkeys((*refuted.vetoed, *again.vetoed))))
        if not gone:
            break
        barred |= gone
    return refuted


def _veto(search: Search, found: SearchResult, judges: tuple[Fold, ...], apart: Apart, *,
          fragment: float, new: bool = False) -> Judged:  # fmt: skip
    """Take out effects that lose on data they were not fitted on, the worst first; and what each gains there.

    Where it is a run's set-up that loses, it may be another one there: the judges are then those of `apart`, which
    have their own, as long as that gains. fragment: chi^2/N that an effect has to gain there, if the twin has a known
    remainder, and it gains little where it is fitted or is no larger than that remainder imitates; new: unless too much
    for that remainder is left over without it.
    """
    vetoed: list[str] = []
    given, tried_apart = judges, False
    while True:
        final = found.final
        gains: dict[str, float] = {}
        fitted: dict[str, float] = {}
        needed = []
        for name in final.names:
            less = search.without(final, name)
            fitted[name] = (less.chi2 - final.chi2) / search.count
            needed += [name] if new and search.misfit(less) else []
            total, samples = 0.0, 0
            for fold in judges:
                if fold_excites(search, fold, final, name):
                    before, after = refit_on_fold(search, fold, less, without=name), refit_on_fold(search, fold, final)
                    total += _chi2(fold, before) - _chi2(fold, after)
                    samples += fold.judge.count
            if samples:
                gains[name] = total / samples
        level = max(1.0, final.chi2 / search.count)
        own = any(fold.setup for fold in judges)
        if own and not run_setups() & set(final.names):
            judges, tried_apart = given, True
            continue
        # Not even the run's own value helps with these.
        idle = [n for n in gains if own and n in run_setups() and gains[n] < MIN_SETUP_GAIN * level]
        fragments = [
            n
            for n in final.names
            if search.target.excused
            and (fitted[n] < LITTLE or (n not in needed and is_imitated(search, final, n)))
            and gains.get(n, fitted[n]) < fragment
        ]
        told = as_told(search, final) if fragments else final
        fragments = [n for n in fragments if not is_beyond_remainder(search, told, n, judges)]
        worst = min(idle or fragments or gains, key=lambda n: gains.get(n, fitted[n]), default="")
        kept = not worst
        if worst and not idle and not fragments:
            kept = gains[worst] > -ROUNDING * level
            kept = kept or gains[worst] > -allowed_loss(search, final, worst, level, fitted[worst], judges)
        if kept:
            return Judged(found, tuple(vetoed), gains, judges)
        if worst in run_setups() and not own and not tried_apart and (others := apart()):
            judges = others
            continue
        vetoed.append(worst)
        judges = tuple(dataclasses.replace(f, setup=f.setup and f.setup.less(worst)) for f in judges)
        names = tuple(n for n in final.names if n != worst)
        final = search.trial(names, final.values, zoom=True)
        found = SearchResult(final, {n: found.rivals.get(n, ()) for n in names}, found.not_excited)


def allowed_loss(
    search: Search, final: Trial, name: str, level: float, fitted: float, judges: Sequence[Fold] = ()
) -> float:
    """chi^2/N that an effect may lose on data it was not fitted on, those of the judges. level: what is left where it
    is fitted, at least 1; fitted: what it gains there."""
    slight = SLIGHT
    if not search.target.excused:
        slight = SLIGHT_FAR if level > FAR else SLIGHT
    elif judges and is_evident_apart(search, as_told(search, final), name, judges):
        slight = SLIGHT_SHOWN
    elif is_clear(search, final, name):
        slight = SLIGHT_BESIDE
    return max(ROUNDING * level, slight * fitted)


def _chi2(fold: Fold, trial: Trial) -> float:
    return square(fold.judge.whitened(trial.values))
