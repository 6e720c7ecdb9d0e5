"""Of two effects of which one contains the other, the simpler one, where it does as well."""

from __future__ import annotations

from typing import TYPE_CHECKING

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
