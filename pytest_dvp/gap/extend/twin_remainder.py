"""What a new model does not explain of the drives it was learnt from: how much, for how long, and what is like it."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING

from pytest_dvp.gap.diagnose.candidates import candidates, candidates_of
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, experiment_set
from pytest_dvp.gap.diagnose.fitted_twin import Drives, refitted
from pytest_dvp.gap.diagnose.fitted_values import Estimates, estimates
from pytest_dvp.gap.diagnose.imitation import imitation, larger, of_other_drives, placebos, unseen
from pytest_dvp.gap.diagnose.lasting_remainder import as_measured
from pytest_dvp.gap.diagnose.search import PRACTICAL
from pytest_dvp.gap.diagnose.sensors_alone import sensor_effects
from pytest_dvp.logs.log import Log

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel


def with_shape(
    twin: VehicleModel, logs: Mapping[str, Log], held_out: Mapping[str, Log], effects: Sequence[Effect]
) -> VehicleModel:
    """The twin with what its remainder looks like on the same logs: what comes anew of it, which values of effects it
    imitates, which limits it looks like, and which these drives leave open."""
    from vehicle.model.effect_catalogue import catalogue

    if not twin.remainder:
        return twin
    drives = [logs, held_out] if held_out else [{name: log} for name, log in logs.items()]
    groups = [experiment_set(each, twin, extra=effects) for each in drives]
    known = {**catalogue(), **{e.name: e for e in effects}}
    tried = candidates(twin, known.values(), ay="ay" in groups[0].channels, refined=True)
    sizes, limits = placebos(groups, tried, twin)
    elsewhere = of_other_drives(twin, tried)
    shape = dataclasses.replace(
        twin.remainder_shape,
        anew=_anew(groups),
        imitates=larger(larger(imitation([group.lasting() for group in groups], tried), sizes), elsewhere),
        limits=limits,
        unseen=unseen(groups, tried, twin),
        sensors=imitation([group.reckoned() for group in groups], sensor_effects(tried)),
    )
    return dataclasses.replace(twin, remainder_shape=shape)


def beside_remainder(twin: VehicleModel, names: Collection[str], drives: Drives, *, always: bool = False) -> Estimates:
    """The values of these effects of the twin, fitted once more with its remainder as an error that lasts; empty if
    that takes less than PRACTICAL off the data held out. always: where some of them can be fitted so only.

    A fit that counts the remainder as noise of each sample gives an understeer that makes up for positions that drift;
    every later diagnosis then finds another one.
    """
    if not (twin.remainder and drives.held_out and candidates_of(twin, names)):
        return {}
    found = refitted(twin, names, drives)
    return estimates(found.trial, found.search) if always or found.after <= (1.0 - PRACTICAL) * found.before else {}


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
