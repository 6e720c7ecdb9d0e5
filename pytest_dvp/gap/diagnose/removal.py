"""Effects that the model has and the car lacks: taken out before the search, if nothing added explains as much."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from pytest_dvp.gap.diagnose.candidates import Candidate, has_price
from pytest_dvp.gap.diagnose.changing_set import refined
from pytest_dvp.gap.diagnose.diagnosis import Estimate, NamedEffect
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, Values
from pytest_dvp.gap.diagnose.held_out import Fold, drives_apart
from pytest_dvp.gap.diagnose.least_squares import Coordinate
from pytest_dvp.gap.diagnose.linear_algebra import square
from pytest_dvp.gap.diagnose.quiet_effects import quiet, single
from pytest_dvp.gap.diagnose.search import PRACTICAL, PRICE, Search, SearchResult, Tick
from pytest_dvp.gap.diagnose.standing import ABOVE_REMAINDER, REMAINDER_ONLY
from pytest_dvp.gap.diagnose.trial import Trial

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel

EXCUSED_REMOVAL = 0.2  # of max(1, chi^2/N), that a twin with a known remainder must gain without one of its effects


@dataclasses.dataclass(frozen=True, slots=True)
class SearchSpace:
    """What is searched, by `Search`, whatever effects of the model are taken out before. judges: data that judge what
    is found."""

    target: ExperimentSet
    tried: Sequence[Candidate]
    refiners: Sequence[Candidate]
    nuisance: Sequence[Coordinate]
    start: Values
    tick: Tick
    judges: Sequence[Fold] = ()

    def run(self, fixed: Values) -> tuple[Search, SearchResult]:
        """The search with the values `fixed`, and what it found, with effects that change while driving."""
        search = Search(self.target, self.tried, nuisance=self.nuisance, start=self.start, fixed=fixed,
                        refiners=self.refiners, tick=self.tick)  # fmt: skip
        search.apart = bool(drives_apart(self.judges))
        found = search.run()
        if self.target.excused:
            hidden = single(search, found.final, self.judges) or quiet(search, found.final, self.judges)
            found = dataclasses.replace(found, final=hidden or found.final)
        rivals = dict(found.rivals)
        return search, dataclasses.replace(found, final=refined(search, found.final, rivals), rivals=rivals)


class Searched(NamedTuple):
    """The search, what it found, the neutral values of effects that the model has and the car lacks, and what could be
    added instead of removing them."""

    search: Search
    found: SearchResult
    removed: dict[tuple[str, str], float]
    instead: tuple[str, ...]


def searched(space: SearchSpace, model: VehicleModel) -> Searched:
    """Search with and without the effects that the measurements do better without, and take what explains more.

    What is missing elsewhere can make an effect look as if it were too much. The effects of a twin that learnt its car
    were measured on it: none is taken out where an addition explains all.
    """
    whole: tuple[Search, SearchResult] | None = None
    if space.target.excused:
        whole = space.run({})
        if not whole[0].misfit(whole[1].final):
            return Searched(*whole, {}, ())
    removed = _removed(space.target, model)
    while True:
        search, found = space.run(removed)
        back = {name for name, _ in removed} & set(found.final.names)
        if not back:
            break
        removed = {key: value for key, value in removed.items() if key[0] not in back}  # in the way of what was found
    if not removed or (whole is None and not found.final.names):
        return Searched(search, found, removed, ())
    other, kept = whole or space.run({})
    if price(kept, other.count, 0) <= price(found, search.count, len({name for name, _ in removed})):
        space.target.settle(kept.final.values)
        return Searched(other, kept, {}, ())
    space.target.settle(found.final.values)
    instead = kept.final.names if search.cannot_tell_apart(found.final, kept.final) else ()
    return Searched(search, found, removed, instead)


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
    priced = sum(has_price(c, found.final.values) for c in found.final.fit.coordinates)
    return chi2 + PRICE * chi2 * (priced + removed)


def removed_effect(effect: Effect, gain: float, held_out: float | None, instead: tuple[str, ...], *,
             excused: bool) -> NamedEffect:  # fmt: skip
    """held_out: chi^2/N that the effect costs on data held out; it is confirmed that the car lacks it if it does, and
    if no other effects do as well beside it (`instead`). excused: the twin has a known remainder."""
    off = {k.name: Estimate(k.neutral, k.neutral, k.neutral, k.unit) for k in effect.parameters}
    doubts = [
        *([f"the model does as well with {', '.join(instead)} added to it"] if instead else []),
        *(["data held out do not gain without it"] if held_out is None or held_out <= 0.0 else
          [REMAINDER_ONLY] if excused and held_out < ABOVE_REMAINDER else []),
    ]  # fmt: skip
    return NamedEffect(
        name=effect.name, parameters=off, gain=min(max(gain, 0.0), 1.0), action="remove", held_out_gain=held_out,
        rivals=instead, standing="provisional" if doubts else "confirmed", doubts=tuple(doubts),
    )  # fmt: skip


def lost_held_out(model: VehicleModel, name: str, final: Trial, judges: Sequence[Fold]) -> float | None:
    """chi^2/N that an effect of the model costs on the data held out, beside all that was found."""
    given = next(a for a in model.effects if a.name == name)
    back = final.values | {(name, key): value for key, value in given.values.items()}
    lost = [square(f.judge.whitened(back)) - square(f.judge.whitened(final.values)) for f in judges]
    return sum(lost) / max(sum(f.judge.count for f in judges), 1) if lost else None
