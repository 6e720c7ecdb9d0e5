"""Effects that the model has and the car lacks: taken out before the search, if nothing added explains as much."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TYPE_CHECKING

from pytest_dvp.gap.diagnose.candidates import Candidate
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, Values
from pytest_dvp.gap.diagnose.least_squares import Coordinate
from pytest_dvp.gap.diagnose.linear_algebra import square
from pytest_dvp.gap.diagnose.search import PRACTICAL, PRICE, Search, SearchResult, Tick

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import VehicleModel

EXCUSED_REMOVAL = 0.2  # of max(1, chi^2/N), that a twin with a known remainder must gain without one of its effects


@dataclasses.dataclass(frozen=True, slots=True)
class SearchSpace:
    """What is searched, by `Search`, whatever effects of the model are taken out before."""

    target: ExperimentSet
    tried: Sequence[Candidate]
    refiners: Sequence[Candidate]
    nuisance: Sequence[Coordinate]
    start: Values
    tick: Tick

    def run(self, fixed: Values) -> tuple[Search, SearchResult]:
        """The search with the values `fixed`, and what it found, with effects that change while driving."""
        search = Search(self.target, self.tried, nuisance=self.nuisance, start=self.start, fixed=fixed,
                        refiners=self.refiners, tick=self.tick)  # fmt: skip
        found = search.run()
        rivals = dict(found.rivals)
        return search, dataclasses.replace(found, final=search.refined(found.final, rivals), rivals=rivals)


def searched(space: SearchSpace, model: VehicleModel) -> tuple[Search, SearchResult, dict[tuple[str, str], float],
                                                                  tuple[str, ...]]:  # fmt: skip
    """The search, what it found, the neutral values of effects that the model has and the car lacks, and what could be
    added instead of removing them.

    What is missing elsewhere can make an effect look as if it were too much. The effects of a twin that learnt its car
    were measured on it: none is taken out where an addition explains all.
    """
    whole: tuple[Search, SearchResult] | None = None
    if space.target.excused:
        whole = space.run({})
        if not whole[0].misfit(whole[1].final):
            return *whole, {}, ()
    removed = _removed(space.target, model)
    while True:
        search, found = space.run(removed)
        back = {name for name, _ in removed} & set(found.final.names)
        if not back:
            break
        removed = {key: value for key, value in removed.items() if key[0] not in back}  # in the way of what was found
    if not removed or (whole is None and not found.final.names):
        return search, found, removed, ()
    other, kept = whole or space.run({})
    if price(kept, other.count, 0) <= price(found, search.count, len({name for name, _ in removed})):
        space.target.settle(kept.final.values)
        return other, kept, {}, ()
    space.target.settle(found.final.values)
    instead = kept.final.names if search.cannot_tell_apart(found.final, kept.final) else ()
    return search, found, removed, instead


def _removed(target: ExperimentSet, model: VehicleModel) -> dict[tuple[str, str], float]:
    """Neutral values of the model's effects that the measurements do better without."""
    off: dict[tuple[str, str], float] = {}
    r = target.whitened({})
    best, count = square(r), max(target.count, 1)
    for applied in model.effects:
        neutral = {(applied.name, k.name): k.neutral for k in applied.effect.parameters}
        r = target.whitened(off | neutral)
        left = square(r)
        worth = EXCUSED_REMOVAL if target.excused else PRACTICAL
        if best - left > worth * max(count, left):
            best = left
            off |= neutral
    return off


def price(found: SearchResult, count: int, removed: int) -> float:
    """What a set leaves beyond the noise, and a price for each value fitted and each effect removed."""
    chi2 = max(found.final.chi2, float(count))
    return chi2 + PRICE * chi2 * (len(found.final.fit.coordinates) + removed)
