"""Far from the noise, held-out drives say which effects may come, and which make room for others.

What the fitted drive asks for comes beyond the usual number of effects, if held-out drives do not lose by it. Then what
only the fitted drive asks for makes room for what held-out drives ask for as well.

A coupe's rolling resistance had been fitted as a dead band of its pedal and its slight slope as a hill: both do better
on the drive that is fitted, and worse on every other one. No single rival does as well in the place of one of them, so
the set is grown again without it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

from pytest_dvp.gap.diagnose.accelerometer_place import placed
from pytest_dvp.gap.diagnose.held_out import Fold
from pytest_dvp.gap.diagnose.held_out_choice import left_held_out
from pytest_dvp.gap.diagnose.search import FAR, MOST, PRACTICAL, Search, SearchResult
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.gap.diagnose.usual_car import LARGEST

SUSPECTS = 3  # effects that are tried in a turn, those of least use on held-out data first; chosen: each is a search
TURNS = 4  # at most; chosen
OF_PAYING = 3  # effects that pay, of which held-out data choose the next one beside what nearly every car has
OF_BARE = 2  # suspects, and turns, of a search that began with what nearly every car has: each takes half a minute
LOSES = 0.01  # of what is left of held-out data; chosen: less is how well a fit ends
MORE = 3  # effects in the place of one, however many there are: held-out data judge them; chosen


def grown_for_held_out(search: Search, found: SearchResult, judges: Sequence[Fold]) -> SearchResult:
    """The result with more effects by which held-out data do not lose, and with others in the place of those that these
    data hardly need, where they gain what is worth an effect.

    Only where a model without known remainder leaves FAR, and drives of their own are held out: with parts of the
    fitted drives, each set would have to be fitted to the other parts, which takes minutes.
    """
    if search.target.excused or not judges or found.final.chi2 < FAR * search.count:
        return found
    if any(fold.fitted is not None for fold in judges):
        return found
    rivals = dict(found.rivals)
    final, gone = _larger(search, found.final, judges)
    left = left_held_out(search, final, judges)
    for _ in range(OF_BARE if search.bare else TURNS):
        name, other = _better(search, final, judges, left, gone)
        if not name:
            break
        gone.append(name)
        rivals |= {new: (name,) for new in other.names if new not in final.names}
        search.target.settle(other.values)
        final = search.trial(other.names, other.values, zoom=True, like=other)
        left = left_held_out(search, final, judges)
    if final is found.final:
        return found
    return dataclasses.replace(found, final=final, rivals={name: rivals.get(name, ()) for name in final.names})


def _larger(search: Search, final: Trial, judges: Sequence[Fold]) -> tuple[Trial, list[str]]:
    """The set with more effects, one by one, of which the fitted drive asks for each and held-out data lose by none;
    and those by which they do lose."""
    barred: list[str] = []
    left = left_held_out(search, final, judges)
    while len(final.names) < LARGEST and final.chi2 > FAR * search.count:
        paying = search.paying(final, barred, LARGEST)
        if not paying:
            break
        few = paying[: OF_PAYING if search.bare else 1]
        held, k = min((left_held_out(search, trial, judges), k) for k, trial in enumerate(few))
        best = few[k]
        search.tick(f"held-out data on {best.names[-1]}, effect {len(best.names)}: chi²/N {left:.3g}")
        if held > (1.0 + LOSES) * left:
            barred += [trial.names[-1] for trial in few]
            continue
        search.target.settle(best.values)
        final = placed(search, search.trial(best.names, best.values, like=best), PRACTICAL)
        left = left_held_out(search, final, judges)
    return final, barred


def _better(
    search: Search, final: Trial, judges: Sequence[Fold], left: float, gone: Sequence[str]
) -> tuple[str, Trial]:
    """The effect that goes, and the best set with others in its place; "" and the set as it is, if none leaves held-out
    data less than `left` (chi^2/N) by what is worth an effect. gone: effects that do not come back."""
    worth = PRACTICAL * max(left, 1.0)
    without = sorted((left_held_out(search, search.without(final, name), judges), name) for name in final.names)
    best = left, "", final
    for less, name in [pair for pair in without if pair[0] < left + worth][: OF_BARE if search.bare else SUSPECTS]:
        search.tick(f"held-out data need no {name}: chi²/N {left:.3g}")
        for other in _others(search, final, name, gone):
            held = left_held_out(search, other, judges)
            pays = held < min(left, less) - worth  # what comes must pay there: a veto takes out what only goes
            if pays and held < best[0]:
                best = held, name, other
        search.target.settle(final.values)
    return best[1:]


def _others(search: Search, final: Trial, name: str, gone: Sequence[str]) -> Iterator[Trial]:
    """The set with another effect in the place of this one, and with all that pays without it."""
    less = search.without(final, name)
    yield from (trial for trial in search.in_place_of(final, name) if trial.names[-1] not in gone)
    search.target.settle(less.values)
    most = max(MOST, len(less.names) + MORE)
    yield search.pruned(search.grown(search.trial(less.names, less.values), [], (*gone, name), most))
