"""Values that nobody meets, and what may stand in their place.

A wind of 18 m/s does on a slow drive what rolling resistance does, and a search that takes what fits best by a hair
takes the wind. Of two that do nearly the same, the one with a value that is met in practice is named.
"""

from __future__ import annotations

from collections.abc import Callable

from pytest_dvp.gap.diagnose.candidates import is_usual, says_how
from pytest_dvp.gap.diagnose.trial import Trial

MAX_UNRECOVERED_SHARE = 0.2
"""Of what is lost without effects whose values nobody meets, or mean nothing: as much may stay lost with others in
their place. On a car in MuJoCo, rolling resistance in the place of a wind of 18 m/s left 5 % of it."""


def usual_set(
    best: Trial, without: Callable[[str], Trial], filled: Callable[[Trial, str], Trial], refit: Callable[[Trial], Trial]
) -> Trial:
    """The set with others in the place of an effect whose value nobody meets, if their own are met and make up for it;
    else the set as it is.

    without: the set without an effect; filled: a set with what else pays, but not that effect; refit: fitted anew.
    """
    for name in best.names:
        if has_usual_values(best, name):
            continue
        less = without(name)
        other = filled(less, name)
        new = set(other.names) - set(less.names)
        left = other.chi2 - best.chi2
        if all(has_usual_values(other, n) for n in new) and left < MAX_UNRECOVERED_SHARE * (less.chi2 - best.chi2):
            return refit(other)
    return best


def has_usual_values(trial: Trial, name: str) -> bool:
    """True if no value of an effect that says how much is outside the range that is met in practice."""
    mine = [c for c in trial.fit.coordinates if c.effect == name and not says_how(c.key)]
    return all(is_usual(c.key, trial.values.get(c.name, c.key.neutral)) for c in mine)
