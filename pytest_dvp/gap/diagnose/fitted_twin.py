"""A twin with fitted values, and what it leaves of the drives that it is fitted on and judged by."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping, Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any, NamedTuple

from pytest_dvp.gap.compare.road_slope import told_spread
from pytest_dvp.gap.diagnose.candidates import candidates_of
from pytest_dvp.gap.diagnose.dead_reckoning import measured_steps
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, Values, experiment_set
from pytest_dvp.gap.diagnose.held_out import Fold, folds, refit_on_fold
from pytest_dvp.gap.diagnose.known_remainder import measured_remainder
from pytest_dvp.gap.diagnose.lasting_remainder import as_measured, measured_memory
from pytest_dvp.gap.diagnose.linear_algebra import square
from pytest_dvp.gap.diagnose.search import Search
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.logs.log import Log
from vehicle.model.remainder_shape import RemainderShape

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel


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


def values_of(model: VehicleModel) -> dict[tuple[str, str], float]:
    """What the model's effects are set to, where a fit can begin: (effect, key) -> value, without limits that are
    infinite."""
    return {(a.name, key): value for a in model.effects for key, value in a.values.items() if isfinite(value)}


def with_values(model: VehicleModel, values: Values, added: Sequence[Effect] = ()) -> VehicleModel:
    """The model with these values of the effects that it has, of those that are added to it, of its inputs and of the
    car; all others are left as they are."""
    by_part: dict[str, dict[str, Any]] = {}
    for (part, key), value in values.items():
        by_part.setdefault(part, {})[key] = value
    for effect in (*(applied.effect for applied in model.effects), *added):
        if effect.name in by_part:
            model = model.with_effect(effect, by_part[effect.name])
    inputs = dataclasses.replace(model.inputs, **by_part.get("inputs", {}))
    return dataclasses.replace(model, inputs=inputs).with_car(by_part.get("parameters", {}))


def with_remainder(model: VehicleModel, search: Search, final: Trial, judges: Sequence[Fold]) -> VehicleModel:
    """The model with what it does not explain of the logs fitted on and of those held out: how much, for how long, and
    how well the car's own sensors agree. The larger remainder of the two is told; if none is held out, the largest of
    each log and of all together, which know regimes that none has for long."""
    fitted = [(e, final.values) for e in search.target.experiments]
    apart = [
        (e, refit_on_fold(search, fold, final).values) for fold in judges if fold.fitted is None
        for e in fold.judge.experiments
    ]  # fmt: skip
    slopes = None
    if any(e.slopes for e, _ in (*fitted, *apart)):  # else the values were fitted as if the road was flat
        slopes = as_measured(told_spread(e.hills(values) for e, values in (*fitted, *apart)))
        for e, _ in (*fitted, *apart):
            e.on_hills(slopes)
    groups = [fitted, apart] if apart else [*([one] for one in fitted), fitted]
    remainder = measured_remainder([[e.left(values) for e, values in group] for group in groups])
    parts = ((e.log.t, e.residuals(values).values, e.segments.starts) for e, values in (*fitted, *apart))
    shape = RemainderShape(slopes=slopes)
    if remainder:
        wanders = measured_steps([[e.reckoned(values) for e, values in group] for group in groups])
        shape = dataclasses.replace(shape, memory=measured_memory(parts, remainder), wanders=wanders)
    return dataclasses.replace(model, remainder=remainder, remainder_shape=shape)


def remeasured(twin: VehicleModel, drives: Drives) -> VehicleModel:
    """The twin with the remainder that it has now on its drives."""
    bare = dataclasses.replace(twin, remainder={}, remainder_shape=RemainderShape(slopes=twin.remainder_shape.slopes))
    plain = Search(experiment_set(drives.logs, bare, extra=drives.effects), ())
    plain.target.settle({})
    return with_remainder(bare, plain, plain.trial((), {}), folds(drives.logs, drives.held_out, bare, drives.effects))


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
    of_twin = values_of(twin)
    begin = {c.name: of_twin[c.name] for candidate in tried for c in candidate.coordinates}
    found = search.trial(list(search.tried), begin)
    target.settle(found.values)
    found = search.trial(found.names, found.values)
    before, after = (square(judge.whitened(values)) for values in (begin, found.values))
    return Refitted(search, found, before, after)
