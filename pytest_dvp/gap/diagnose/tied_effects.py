"""Effects that are often confused (`ties`), asked in each other's place on all drives together.

A search chooses on the data fitted on and judges on the others. Beside what a twin is known not to explain, that may
end with a mass for brakes that are too weak: the hard stops of one drive and the mild ones of the other each agree with
it half. Fitted on both together, where the remainder lasts, the true one explains more. And what explains nearly as
much as the named one cannot be told from it: no twin is as exact as the difference.

On four sets of strangers' cars, with answers of one name, the true one explained 4 to 10 % more than the name in three
of the answers that were wrong, and in all that were right no tied one more than 3 % more. The bounds below were chosen
on these sets; on no other have they been tried.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from pytest_dvp.gap.diagnose.beyond_remainder import all_data
from pytest_dvp.gap.diagnose.candidates import Candidate, has_price
from pytest_dvp.gap.diagnose.experiment import ExperimentSet
from pytest_dvp.gap.diagnose.first_order_gain import FirstOrderGain
from pytest_dvp.gap.diagnose.held_out import Fold, drives_apart
from pytest_dvp.gap.diagnose.linear_algebra import square
from pytest_dvp.gap.diagnose.quiet_effects import is_placed
from pytest_dvp.gap.diagnose.search import Search
from pytest_dvp.gap.diagnose.trial import Trial

MORE = 1.03  # times what the named effect explains: a tied one that explains more takes its place. A drive that is slow
# explained 1.027 of what a hidden limit of the jerk did
ALIKE = 0.985  # of what the named effect explains: a tied one that explains more is its rival; a servo of second order
# explained a hidden lag and a hidden dead time by 1.2 and 0.7 % more than a lag did
# The same, of one with fewer values, and of one that is contained in the named one; chosen: the inertia of gears, which
# has two values, was named where a mass was hidden, which explained 0.971 of that
_SIMPLER = 1.0 / MORE
_BEGINNINGS = 3  # points of an effect's range from which a fit of it starts


class Tied(NamedTuple):
    """The set that explains all drives together best, and what cannot be told from its effect."""

    final: Trial
    rivals: tuple[str, ...]


def best_of_tied(search: Search, final: Trial, judges: Sequence[Fold]) -> Tied:
    """The one effect of a set or one that is tied to it, whichever explains more of all data together, and its rivals.

    Of two that explain nearly the same, the simpler one is told, with the one that contains it as a rival. The set as
    it is, without rivals, if it has not just one effect, or if no other drive is there.
    """
    if len(final.names) != 1 or not drives_apart(judges):
        return Tied(final, ())
    (name,) = final.names
    together = ExperimentSet(tuple(e for data in all_data(search, judges) for e in data.experiments), lasts=True)
    base = search.trial((), final.values, target=together)
    look = FirstOrderGain(together, base)
    known = search.known[name]
    tied = [c for c in search.known.values() if c.is_tied(known) and not is_placed(c)]
    fits = {name: search.trial((name,), final.values, target=together)}
    fits |= {c.name: fit for c in tied if c.name != name and (fit := _fitted(search, look, c, base, together))}
    gains = {one: base.chi2 - fit.chi2 for one, fit in fits.items()}
    sound = [n for n in gains if n == name or search.is_credible(fits[n], n, together)]
    best = max(sound, key=lambda n: gains[n])
    if gains[best] <= MORE * gains[name]:
        best = name
    simpler = search.contained(best)
    if simpler in sound and gains[simpler] >= _SIMPLER * gains[best]:
        best = simpler

    def priced(one: str) -> int:
        return sum(has_price(c, fits[one].values) for c in search.known[one].coordinates)

    def is_alike(other: str) -> bool:
        return gains[other] >= (_SIMPLER if priced(other) < priced(best) else ALIKE) * gains[best]

    rivals = sorted((n for n in sound if n != best and is_alike(n)), key=lambda n: -gains[n])
    more = [n for n in rivals if search.contained(n) == best and n != name]  # more values explain a little more
    rivals = [n for n in rivals if n not in more]
    if best == name:
        return Tied(final, tuple(rivals))
    return Tied(search.trial((best,), fits[best].values), tuple(rivals))


def gained_apart(trial: Trial, judges: Sequence[Fold]) -> float:
    """What the drives held out gain by the effects of a set (chi^2/N)."""
    off = {key: value for key, value in trial.values.items() if key[0] not in trial.names}
    apart = drives_apart(judges)
    gained = sum(square(data.whitened(off)) - square(data.whitened(trial.values)) for data in apart)
    return gained / max(sum(data.count for data in apart), 1)


def _fitted(
    search: Search, look: FirstOrderGain, candidate: Candidate, base: Trial, together: ExperimentSet
) -> Trial | None:
    """The best fit of an effect to all data, from the points that promise most; None if it does nothing there."""
    options = sorted(look.remaining_chi2(candidate, candidate.points), key=lambda option: option[0])[:_BEGINNINGS]
    trials = [search.trial((candidate.name,), base.values | point, target=together) for _, point in options]
    return min(trials, key=lambda trial: trial.chi2, default=None)
