"""What a search leaves to find below what it cannot explain.

A search counts what a model leaves as noise of each sample, and an effect has to take a share of that to be worth its
name. Where much is left, that hides effects which the data show beyond doubt: a steering that lags by 0.04 s takes
nothing off positions that drift for other reasons, and a dead time, a tyre or a servo is found for it in every later
diagnosis that starts from the twin. So the search goes on with what is left as what it is, an error that lasts
(`lasting_remainder`). There an effect counts if the data fitted on and the data held out both ask for it, in the same
size.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from pytest_dvp.gap.diagnose.beyond_remainder import AGREES, APART, EVIDENT
from pytest_dvp.gap.diagnose.candidates import Candidate, candidates, candidates_of, is_worth_naming, sizes
from pytest_dvp.gap.diagnose.diagnosis import Estimate, NamedEffect
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, Values, experiment_set
from pytest_dvp.gap.diagnose.first_order_gain import FirstOrderGain
from pytest_dvp.gap.diagnose.held_out import Fold, folds, refit_on_fold
from pytest_dvp.gap.diagnose.known_remainder import measured_remainder
from pytest_dvp.gap.diagnose.lasting_remainder import measured_memory
from pytest_dvp.gap.diagnose.least_squares import intervals, widen_dead_times
from pytest_dvp.gap.diagnose.linear_algebra import square
from pytest_dvp.gap.diagnose.rivals import RIVAL_SHARE
from pytest_dvp.gap.diagnose.search import Search, Tick
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.logs.log import Log
from vehicle.model.effect_catalogue import catalogue
from vehicle.model.remainder_shape import RemainderShape

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel

SHOWN_BELOW = "these data show it only where what is left counts as an error that lasts"
MOST = 4  # effects found so; chosen: the cars of strangers had three at most
_FITTED = 10  # effects of a round, the best to first order; chosen
_OF_THE_DAY = ("road_bank", "road_grade", "road_profile", "headwind")  # what two drives of a day share is not the car's


class Drives(NamedTuple):
    """The data of a twin by name: those fitted on, those held out, and the user's own effects."""

    logs: Mapping[str, Log]
    held_out: Mapping[str, Log]
    effects: Sequence[Effect] = ()

    def lasting(self, twin: VehicleModel) -> tuple[ExperimentSet, ExperimentSet]:
        """Both, with the twin's remainder as an error that lasts, settled."""
        found = tuple(experiment_set(each, twin, extra=self.effects).lasting() for each in (self.logs, self.held_out))
        for data in found:
            for _ in range(2):  # where the segments begin depends on what came before them
                data.settle({})
        return found[0], found[1]


class Below(NamedTuple):
    """An effect that both data show where the remainder lasts: what it is fitted with, what it gains in all (chi^2),
    and others that gain nearly as much."""

    name: str
    parameters: dict[str, Estimate]
    gain: float
    rivals: tuple[str, ...] = ()

    @property
    def values(self) -> dict[tuple[str, str], float]:
        """(effect, key) -> value."""
        return {(self.name, key): one.value for key, one in self.parameters.items()}

    def as_named(self) -> NamedEffect:
        """As a diagnosis names it: never more than provisional, for it takes next to nothing off the error."""
        doubts = [f"these data cannot tell it from {', '.join(self.rivals)}"] if self.rivals else []
        return NamedEffect(self.name, self.parameters, self.rivals, doubts=(*doubts, SHOWN_BELOW))


def with_remainder(model: VehicleModel, search: Search, final: Trial, judges: Sequence[Fold]) -> VehicleModel:
    """The model with what it does not explain of the logs fitted on and of those held out: how much, and for how
    long."""
    fitted = [(e, final.values) for e in search.target.experiments]
    apart = [
        (e, refit_on_fold(search, fold, final).values) for fold in judges if fold.fitted is None
        for e in fold.judge.experiments
    ]  # fmt: skip
    remainder = measured_remainder([[e.left(values) for e, values in group] for group in (fitted, apart)])
    parts = ((e.log.t, e.residuals(values).values, e.segments.starts) for e, values in (*fitted, *apart))
    memory = measured_memory(parts, remainder) if remainder else {}
    return dataclasses.replace(model, remainder=remainder, remainder_shape=RemainderShape(memory=memory))


def remeasured(twin: VehicleModel, drives: Drives) -> VehicleModel:
    """The twin with the remainder that it has now on its drives."""
    bare = dataclasses.replace(twin, remainder={}, remainder_shape=RemainderShape())
    plain = Search(experiment_set(drives.logs, bare, extra=drives.effects), ())
    plain.target.settle({})
    return with_remainder(bare, plain, plain.trial((), {}), folds(drives.logs, drives.held_out, bare, drives.effects))


def below_remainder(twin: VehicleModel, drives: Drives, tick: Tick = lambda text: None) -> list[Below]:
    """The effects that all drives of a twin show where its remainder lasts, one after the other, each beside those
    before it; [] without a remainder or data held out."""
    found: list[Below] = []
    while twin.remainder and drives.held_out and len(found) < MOST:
        so_far = f"; so far {', '.join(each.name for each in found)}" if found else ""
        tick(f"what is left as an error that lasts: effect {len(found) + 1}{so_far}")
        options = _shown(twin, drives)
        if not options:
            break
        best, others = options[0], options[1:]
        rivals = tuple(other.name for other in others if other.gain > RIVAL_SHARE * best.gain)
        found.append(best._replace(rivals=rivals))
        twin = with_below(twin, drives, best)
    return found


def with_below(twin: VehicleModel, drives: Drives, found: Below) -> VehicleModel:
    """The twin with the effect, all of it fitted anew where its remainder lasts if data held out gain by that, and the
    remainder that it has then."""
    known = {e.name: e for e in drives.effects}
    values = {key: one.value for key, one in found.parameters.items()}
    grown = twin.with_effect(known.get(found.name, found.name), values)
    anew = refitted(grown, [a.name for a in grown.effects], drives)
    return remeasured(with_values(grown, anew.trial.values) if anew.after < anew.before else grown, drives)


class Refitted(NamedTuple):
    """A joint fit where the remainder lasts, and what the data held out leave with the values before and after it
    (chi^2)."""

    search: Search
    trial: Trial
    before: float
    after: float


def refitted(twin: VehicleModel, names: Collection[str], drives: Drives) -> Refitted:
    """These effects of the twin fitted jointly where its remainder lasts."""
    target, judge = drives.lasting(twin)
    tried = candidates_of(twin, names)
    search = Search(target, tried)
    of_twin = {(a.name, key): value for a in twin.effects for key, value in a.values.items()}
    begin = {c.name: of_twin[c.name] for candidate in tried for c in candidate.coordinates}
    found = search.trial(list(search.tried), begin)
    target.settle(found.values)
    found = search.trial(found.names, found.values)
    before, after = (square(judge.whitened(values)) for values in (begin, found.values))
    return Refitted(search, found, before, after)


def is_shown_below(twin: VehicleModel, drives: Drives, candidate: Candidate, start: Values) -> Below | None:
    """One effect, if it pays on all drives of the twin where its remainder lasts, in whatever size. start: where its
    fit may begin."""
    if not (twin.remainder and drives.held_out):
        return None
    target, judge = drives.lasting(twin)
    search = Search(target, [candidate])
    mine = {c.name: start[c.name] for c in candidate.coordinates if c.name in start}
    look = FirstOrderGain(target, search.trial((), {}))
    points = [*([mine] if len(mine) == len(candidate.coordinates) else []), *candidate.points]
    _, point = min(look.remaining_chi2(candidate, points), key=lambda option: option[0], default=(0.0, {}))
    return _both_show(search, judge, candidate, point, agrees=0.0) if point else None


def with_values(model: VehicleModel, values: Values) -> VehicleModel:
    """The model with these values of the effects that it has."""
    for applied in model.effects:
        new = {key: value for (name, key), value in values.items() if name == applied.name}
        model = model.with_effect(applied.effect, new) if new else model
    return model


def _shown(twin: VehicleModel, drives: Drives) -> list[Below]:
    """What both data show, the largest gain first."""
    target, judge = drives.lasting(twin)
    present = {a.name for a in twin.effects}
    known = {**catalogue(), **{e.name: e for e in drives.effects}}
    tried = [
        c
        for c in candidates(twin, known.values(), ay="ay" in target.channels, refined=True)
        if c.name not in (*present, *_OF_THE_DAY)
    ]
    search = Search(target, tried)
    now = search.trial((), {})
    look = FirstOrderGain(target, now)
    options = [
        (now.chi2 - left, candidate, point)
        for candidate in tried
        for left, point in sorted(look.remaining_chi2(candidate, candidate.coarse), key=lambda o: o[0])[:1]
    ]
    options.sort(key=lambda option: -option[0])
    each = (_both_show(search, judge, c, point) for gain, c, point in options[:_FITTED] if gain > EVIDENT**2)
    return sorted((found for found in each if found), key=lambda found: -found.gain)


def _both_show(
    search: Search, judge: ExperimentSet, candidate: Candidate, point: Values, agrees: float = AGREES
) -> Below | None:
    """The effect fitted from a point on, if it takes EVIDENT standard deviations off the data fitted on, APART off
    those held out, of what it changes there the share `agrees` at least, and is as large as one is worth a name."""
    base = search.target.whitened({})
    trial = search.trial((candidate.name,), point)
    gain = square(base) - trial.chi2
    without, with_it = judge.whitened({}), judge.whitened(trial.values)
    held_out, changed = square(without) - square(with_it), square(without - with_it)
    large = any(is_worth_naming(c.key, trial.values[c.name]) for c in sizes(candidate.coordinates))
    sure = large and search.is_credible(trial, candidate.name, search.target)
    if sure and gain > EVIDENT**2 and held_out > APART**2 and held_out >= agrees * changed:
        return Below(candidate.name, _estimates(search, trial), gain + held_out)
    return None


def _estimates(search: Search, trial: Trial) -> dict[str, Estimate]:
    sure = intervals(trial.fit, search.starts, search.target.exact(trial.values))
    sure = widen_dead_times(search.target, trial.fit, trial.values, sure)
    return {c.key.name: Estimate(trial.values[c.name], *sure[c.name], c.key.unit) for c in trial.fit.coordinates}
