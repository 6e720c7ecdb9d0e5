"""Simpler effects in the place of others: one that another contains, or of which another is a finer form."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

from pytest_dvp.gap.diagnose.first_order_gain import FirstOrderGain
from pytest_dvp.gap.diagnose.fitting import Fitting

if TYPE_CHECKING:
    from pytest_dvp.gap.diagnose.trial import Trial


def simplified(search: Fitting, best: Trial, little: float) -> Trial:
    """The set with the simpler one of two effects of which one contains the other, where that one does as well.
    little: of max(1, chi^2/N), what the other one may do better."""
    for name in best.names:
        simple = search.contained(name)
        if simple in search.tried and simple not in best.names:
            rest = tuple(n for n in best.names if n != name)
            points = search.tried[simple].coarse
            trials = (search.trial((*rest, simple), best.values | point, like=best) for point in points)
            plain = min(trials, key=search.cost)
            if is_simpler(search, simple, plain, best, little):
                best = plain
    return best


def is_simpler(search: Fitting, name: str, best: Trial, other: Trial, little: float) -> bool:
    """True if the other set only has, in place of an effect, one that contains it, and is hardly better."""
    contains = any(search.contained(n) == name for n in set(other.names) - set(best.names))
    return contains and best.chi2 - other.chi2 < little * max(search.count, other.chi2)


def plainer(search: Fitting, best: Trial, name: str) -> Trial:
    """The set with the plainer form of an effect in its place, or without it where it has none: how far a body sways
    may be known where the way in which it does so is not."""
    rest = tuple(n for n in best.names if n != name)
    plain = search.known[name].effect.diagnosed.details
    options = [search.trial(rest, best.values, like=best)]
    if plain in search.tried and plain not in rest:
        look = FirstOrderGain(search.target, options[0])
        left = look.remaining_chi2(search.tried[plain], search.tried[plain].points)
        _, point = min(left, key=lambda option: option[0], default=(inf, {}))
        if point:
            options.append(search.trial((*rest, plain), options[0].values | point, like=options[0]))
    return min(options, key=search.cost)
