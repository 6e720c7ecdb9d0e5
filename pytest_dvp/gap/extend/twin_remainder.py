"""What a new model does not explain of the drives it was learnt from: how much, for how long, and what is like it."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING

from pytest_dvp.gap.diagnose.candidates import candidates, candidates_of
from pytest_dvp.gap.diagnose.diagnosis import Estimate
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, experiment_set
from pytest_dvp.gap.diagnose.held_out import Fold, refit_on_fold
from pytest_dvp.gap.diagnose.imitation import imitation, larger, placebos, unseen
from pytest_dvp.gap.diagnose.known_remainder import measured_remainder
from pytest_dvp.gap.diagnose.lasting_remainder import as_measured, measured_memory
from pytest_dvp.gap.diagnose.linear_algebra import square
from pytest_dvp.gap.diagnose.search import PRACTICAL, Search
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.gap.extend.acceptance import estimates
from pytest_dvp.logs.log import Log
from vehicle.model.remainder_shape import RemainderShape

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel


def with_remainder(model: VehicleModel, search: Search, final: Trial, judges: Sequence[Fold]) -> VehicleModel:
    """The new model with what it does not explain of the logs fitted on and of those held out: how much, and for how
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


def with_shape(
    twin: VehicleModel, logs: Mapping[str, Log], held_out: Mapping[str, Log], effects: Sequence[Effect]
) -> VehicleModel:
    """The twin with what its remainder looks like on the same logs: what comes anew of it, which values of effects it
    imitates, which limits it looks like, and which these drives leave open."""
    from vehicle.model.effect_catalogue import catalogue

    if not twin.remainder:
        return twin
    groups = [experiment_set(each, twin, extra=effects) for each in (logs, held_out) if each]
    known = {**catalogue(), **{e.name: e for e in effects}}
    tried = candidates(twin, known.values(), ay="ay" in groups[0].channels, refined=True)
    sizes, limits = placebos(groups, tried, twin)
    shape = dataclasses.replace(
        twin.remainder_shape, anew=_anew(groups), imitates=larger(imitation(groups, tried), sizes), limits=limits,
        unseen=unseen(groups, tried, twin),
    )  # fmt: skip
    return dataclasses.replace(twin, remainder_shape=shape)


def beside_remainder(
    twin: VehicleModel, names: Collection[str], logs: Mapping[str, Log], held_out: Mapping[str, Log],
    effects: Sequence[Effect],
) -> dict[tuple[str, str], Estimate]:  # fmt: skip
    """The values of these effects of the twin, fitted once more with its remainder as an error that lasts; empty if
    that takes less than PRACTICAL off the data held out.

    A fit that counts the remainder as noise of each sample gives an understeer that makes up for positions that drift;
    every later diagnosis then finds another one.
    """
    tried = candidates_of(twin, names)
    if not (twin.remainder and held_out and tried):
        return {}
    target, judge = (experiment_set(each, twin, extra=effects).lasting() for each in (logs, held_out))
    search = Search(target, tried)
    of_twin = {(a.name, key): value for a in twin.effects for key, value in a.values.items()}
    begin = {c.name: of_twin[c.name] for candidate in tried for c in candidate.coordinates}
    found = search.trial(list(search.tried), begin)
    target.settle(found.values)
    found = search.trial(found.names, found.values)
    before, after = (square(judge.whitened(values)) for values in (begin, found.values))
    return estimates(found, search) if after <= (1.0 - PRACTICAL) * before else {}


def _anew(groups: Sequence[ExperimentSet]) -> dict[str, float]:
    """chi^2/N by channel, the larger one of the groups of logs, of what level and memory of the remainder do not
    foresee; where it is more than 1."""
    found: dict[str, float] = {}
    for group in groups:
        target = group.lasting()
        target.settle({})
        for channel, value in target.by_channel({}).items():
            found[channel] = max(found.get(channel, 1.0), as_measured(value))
    return {channel: value for channel, value in found.items() if value > 1.0}
