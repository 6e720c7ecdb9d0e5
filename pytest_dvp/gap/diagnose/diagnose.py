"""Which physical effect a model lacks, or that none is missing, or that these data cannot tell."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pytest_dvp.gap.diagnose.below_remainder import below_remainder
from pytest_dvp.gap.diagnose.beyond_remainder import as_told, is_beyond_remainder
from pytest_dvp.gap.diagnose.candidates import candidates
from pytest_dvp.gap.diagnose.dependence import Dependences
from pytest_dvp.gap.diagnose.diagnosis import Diagnosis, Estimate, NamedEffect, Samples, Step, Verdict
from pytest_dvp.gap.diagnose.equation_error import opinions, votes
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, Values, experiment_set, on_same_roads
from pytest_dvp.gap.diagnose.fitted_twin import Drives, remeasured, with_values
from pytest_dvp.gap.diagnose.held_out import (
    Fold,
    drives_apart,
    folds,
    folds_with_setup,
    step,
)
from pytest_dvp.gap.diagnose.hidden_sizes import hidden_sizes
from pytest_dvp.gap.diagnose.input_scales import implausible_scales, input_map, repeats
from pytest_dvp.gap.diagnose.least_squares import Intervals, intervals, widen_dead_times, widen_imitated
from pytest_dvp.gap.diagnose.moved_scales import moved_scales
from pytest_dvp.gap.diagnose.removal import SearchSpace, lost_held_out, removed_effect, searched
from pytest_dvp.gap.diagnose.residual_signature import signature
from pytest_dvp.gap.diagnose.rival_values import with_rival_values
from pytest_dvp.gap.diagnose.rivals import rivals_of
from pytest_dvp.gap.diagnose.search import (
    Search,
    SearchResult,
    Tick,
)
from pytest_dvp.gap.diagnose.seen_gearbox import with_seen_gearbox
from pytest_dvp.gap.diagnose.sensors_alone import with_sensors_asked
from pytest_dvp.gap.diagnose.standing import Evidence, older, with_standing
from pytest_dvp.gap.diagnose.tied_effects import Tied, best_of_tied, gained_apart
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.gap.diagnose.veto import judged
from pytest_dvp.gap.perception.diagnose_perception import diagnose_perceptions
from pytest_dvp.logs.log import Log

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel


STRAYS = 1.5  # times the known remainder; chosen: twelve drives with nothing new of six cars left 0.3 to 1.1 times, and
# two with a change that no effect was named for 1.8
EXPLAINS = 0.5  # of what data held out leave beyond the known remainder, that a set must take away to be what is new;
# chosen: one that took 5 % of it on a stranger's ambulance was no part of the change


def diagnose(
    logs: Mapping[str, Log],
    model: VehicleModel,
    held_out: Mapping[str, Log] | None = None,
    *,
    effects: Sequence[Effect] = (),
    twins: Mapping[str, Log] | None = None,
    tick: Tick = lambda text: None,
) -> Diagnosis:
    """Try every effect of the catalogue (and `effects`, the user's own) on what the model leaves unexplained.

    logs by name, fitted on; held_out: logs that have the last word on each effect. Without them each log is predicted
    from the others, a single one its last 40 % from what came before. twins: runs of the twin by scenario, with whose
    detections those of the same scenario are compared.

    Raises CompareError or ModelError (one line): an input missing, nothing to judge.
    """
    from vehicle.model.effect_catalogue import catalogue

    known = {**catalogue(), **{e.name: e for e in effects}}
    tick("preparing")
    target = experiment_set(logs, model, extra=effects)
    nuisance, start = input_map(model)
    every = with_seen_gearbox(candidates(model, known.values(), ay="ay" in target.channels, refined=True), target)
    present = {a.name for a in model.effects}
    late = {c.name for c in every if c.effect.diagnosed.refines and c.name not in present}
    refiners = [c for c in every if c.name in late]
    tried = [c for c in every if c.name not in late and not repeats(c.effect, nuisance)]
    judges = folds(logs, held_out, on_same_roads(model, target), effects)
    space = SearchSpace(target, tried, refiners, nuisance, start, tick, judges)
    search, found, removed, instead = searched(space, model)
    tick("held-out data")
    found, vetoed, gains, judges, chose = judged(
        search, found, judges, lambda: folds_with_setup(held_out, on_same_roads(model, target), effects)
    )
    final = found.final
    tied = Tied(final, ())
    if target.excused and final.names:
        tick("what is often confused with it")
        tied = best_of_tied(search, final, judges)
        if tied.final is not final:
            gains = {name: gained_apart(tied.final, judges) for name in tied.final.names}
            found, final = dataclasses.replace(found, final=tied.final), tied.final
    by_sensors: tuple[str, ...] = ()
    if target.excused:
        tick("sensors beside dead reckoning")
        sensed = with_sensors_asked(search, final, judges)
        if sensed.final is not final:
            gains = {name: gained_apart(sensed.final, judges) for name in sensed.final.names}
            found, final, by_sensors = dataclasses.replace(found, final=sensed.final), sensed.final, sensed.final.names
            tied = sensed
        else:
            tied = tied._replace(rivals=tuple(dict.fromkeys((*tied.rivals, *sensed.rivals))))
    if held_out and target.excused and not final.names and not search.misfit(final) and _misfit(judges):
        tick("only the held-out data show an error: all logs together")
        whole = diagnose(_together(logs, held_out), model, effects=effects, twins=twins, tick=tick)
        apart = step(search, final, judges, added="").held_out_chi2_per_n
        astray = whole.verdict == "NOTHING_MISSING" and _strays(target, search.count, final, apart)
        return dataclasses.replace(whole, verdict="UNKNOWN" if astray else whole.verdict, chosen_by_held_out=True)
    if target.excused or search.misfit(final):
        tick("rivals over segments")
        rivals = {} if by_sensors else rivals_of(search, judges, found)  # those were asked beside dead reckoning
        rivals |= {name: tuple(dict.fromkeys((*tied.rivals, *rivals.get(name, ())))) for name in final.names}
        found = dataclasses.replace(found, rivals=rivals)
        target.settle(final.values)
    tick("ladder")
    measured, sure = _measured(search, final, model)
    sure = with_rival_values(search, final, sure, found.rivals)
    trials = _ladder(search, final, measured.values)
    gone = tuple(dict.fromkeys(name for name, _ in removed))
    steps = [
        *_given(search, gone, judges),
        *(step(search, trial, judges, added=(trial.names or gone or ("",))[-1]) for trial in trials),
    ]
    excess = max(steps[0].chi2_per_n - 1.0, 1e-9) * search.count
    named = tuple(
        NamedEffect(
            name=after.names[-1],
            parameters=_estimates(measured, sure, after.names[-1]),
            rivals=tuple(rival for rival in found.rivals.get(after.names[-1], ()) if rival not in final.names),
            gain=float(min(max((before.chi2 - after.chi2) / excess, 0.0), 1.0)),
            action="change" if after.names[-1] in present else "add",
            held_out_gain=gains.get(after.names[-1]),
        )
        for before, after in itertools.pairwise(trials)
    ) + tuple(
        removed_effect(known[name], (steps[k].chi2_per_n - steps[k + 1].chi2_per_n) * search.count / excess,
                 lost_held_out(model, name, final, judges), instead, excused=target.excused)
        for k, name in enumerate(gone)
    )  # fmt: skip
    tick("standing")
    besides = bool(final.names) and _besides(target.excused, steps[0], steps[-1])
    changes = Dependences(target, final, [c.effect for c in every])
    evidence = Evidence(
        held_out=gains,
        opinions=opinions(logs, model, {e.name: {k: x.value for k, x in e.parameters.items()} for e in named}),
        dependence={name: one for name in final.names if (one := changes.of(name)) is not None},
        evident=[
            name
            for name in final.names
            if target.excused and (name in by_sensors or is_beyond_remainder(search, measured, name, judges))
        ],
        told=measured,
        besides=besides,
        scales=implausible_scales({k: e.value for k, e in _estimates(measured, sure, "inputs").items()}, model.inputs),
    )
    named = with_standing(named, search, final, [*logs.values(), *(held_out or {}).values()], evidence, known)
    below = []
    if named and held_out and not target.excused and search.misfit(final):
        drives = Drives(logs, held_out, effects)
        twin = model
        for name in gone:
            twin = twin.without_effect(name)
        twin = with_values(twin, final.values, [known[name] for name in final.names])
        below = below_remainder(remeasured(twin, drives), drives, tick)
        named += tuple(one.as_named() for one in below)
    named += diagnose_perceptions(logs.values(), model, twins)
    if model.drives_nothing and "speed_controller" not in final.names:
        found = dataclasses.replace(found, not_excited=())  # a model that stands says nothing of what a drive shows
    apart = steps[-1].held_out_chi2_per_n if held_out else None
    misfit = besides or search.misfit(final) or _strays(target, search.count, final, apart)
    verdict = _verdict(misfit, named, found, len(tried))
    return Diagnosis(
        verdict=verdict,
        effects=named,
        not_excited=tuple(name for name in found.not_excited if name not in final.names),
        ladder=tuple(steps),
        noise_floor=target.noise(),
        signature=signature(target, final.values) if verdict in ("PARTIAL", "UNKNOWN") else {},
        vetoed=tuple(dict.fromkeys(name for name in vetoed if name not in final.names)),
        input_map=_estimates(measured, sure, "inputs"),
        scale_notes=(*evidence.scales, *moved_scales(_estimates(measured, sure, "inputs"), model)),
        votes=votes(logs, model),
        car={key: value for (name, key), value in final.values.items() if name == "parameters"} if named else {},
        values=final.values | {name: value for one in below for name, value in one.values.items()},
        remainder=model.remainder,
        samples=Samples(target.count, target.independent, *target.slides(), target.slopes),
        chosen_by_held_out=chose,
        may_hide=hidden_sizes(model, [c for c in tried if c.name not in final.names], judges),
    )


def _together(logs: Mapping[str, Log], held_out: Mapping[str, Log]) -> dict[str, Log]:
    """All logs by name, also where one that is held out is called like one that was fitted, in another folder."""
    return {**logs, **{name if name not in logs else f"{name}, held out": log for name, log in held_out.items()}}


def _misfit(judges: Sequence[Fold]) -> bool:
    """True if the model as it is leaves more than its known remainder of data held out: what the data fitted on did not
    show is there all the same."""
    checks = [Search(data, ()) for data in drives_apart(judges)]
    return any(check.misfit(check.trial((), {})) for check in checks)


def _measured(search: Search, final: Trial, model: VehicleModel) -> tuple[Trial, Intervals]:
    """The trial with its values as they are told, and their 95 % intervals.

    Of a twin with a known remainder they are estimated once more, with the remainder as an error that lasts, and the
    intervals hold what the remainder imitates, too.
    """
    target = search.target.lasting() if search.target.excused else search.target
    final = as_told(search, final)
    sure = intervals(final.fit, search.starts, target.exact(final.values))
    sure = widen_dead_times(target, final.fit, final.values, sure)
    return final, widen_imitated(final.fit, sure, model.remainder_shape.imitates) if target.lasts else sure


def _strays(target: ExperimentSet, count: int, final: Trial, held_out: float | None) -> bool:
    """True if nothing is named, and yet a drive leaves clearly more than the known remainder of its twin, which
    otherwise would count as an error that lasts. held_out: chi^2/N that data held out leave, None without any."""
    return target.excused and not final.names and max(final.chi2 / count, held_out or 0.0) > STRAYS


def _besides(excused: bool, before: Step, after: Step) -> bool:
    """True if data held out leave clearly more than the known remainder of a twin, of which the named effects, those of
    the step `after` beyond the step `before`, explain hardly anything: what is new there is something else."""
    if not excused or before.held_out_chi2_per_n is None or after.held_out_chi2_per_n is None:
        return False
    beyond = before.held_out_chi2_per_n - 1.0
    taken = before.held_out_chi2_per_n - after.held_out_chi2_per_n
    return after.held_out_chi2_per_n > STRAYS and taken < EXPLAINS * beyond


def _verdict(misfit: bool, named: Sequence[NamedEffect], found: SearchResult, tried: int) -> Verdict:
    if misfit:
        return "PARTIAL" if named else "UNKNOWN"
    if named:
        return "AMBIGUOUS" if any(e.rivals for e in named) else "NAMED"
    return "NOT_EXCITED" if 2 * len(found.not_excited) > tried else "NOTHING_MISSING"


def _ladder(search: Search, final: Trial, told: Values) -> list[Trial]:
    """The final set built up again, from the effect that would be missed most to the one that would be missed least.

    Missed: what of the error comes back without it, though all the others may adapt. What an effect takes away first
    would depend on those that come after it: alone, a detail of the tyres takes the share of a slow steering. One that
    makes it worse before another one is there comes after that one, and after what is new one that may be older than
    the twin. told: the values as they are told.
    """
    open_at = search.target.experiments[0].model.remainder_shape.unseen

    def is_older(name: str) -> bool:
        values = {key: value for (effect, key), value in told.items() if effect == name}
        return bool(older(values, open_at.get(name, {})))

    left = sorted(final.names, key=lambda name: (is_older(name), -search.without(final, name).chi2))
    steps = [search.trial((), search.start)]
    while left:
        tried: list[Trial] = []
        for name in left:
            tried.append(search.trial((*steps[-1].names, name), final.values, like=final))
            if tried[-1].chi2 <= steps[-1].chi2:
                break
        steps.append(tried[-1] if tried[-1].chi2 <= steps[-1].chi2 else tried[0])
        left.remove(steps[-1].names[-1])
    if len(steps) > 1:
        last = search.trial(steps[-1].names, final.values)
        steps[-1] = last if last.chi2 < steps[-1].chi2 else steps[-1]
    return steps


def _given(search: Search, gone: Sequence[str], judges: Sequence[Fold]) -> list[Step]:
    """The model as given and without one more of its effects that the car lacks, up to the last of them."""
    steps = []
    for k in range(len(gone)):
        off = {key: value for key, value in search.fixed.items() if key[0] in gone[:k]}
        part = Search(search.target, (), nuisance=search.nuisance, start=search.start, fixed=off)
        steps.append(step(part, part.trial((), part.start), judges, added=gone[k - 1] if k else ""))
    return steps


def _estimates(trial: Trial, sure: Mapping[tuple[str, str], tuple[float, float]], name: str) -> dict[str, Estimate]:
    found = {}
    for c in trial.fit.coordinates:
        if c.effect == name:
            low, high = sure[c.name]
            found[c.key.name] = Estimate(trial.fit.values[c.name], low, high, c.key.unit)
    if {"slope", "heading"} <= set(found):
        return _folded(found)
    return found


def _folded(found: Mapping[str, Estimate]) -> dict[str, Estimate]:
    """A slope along a heading is the opposite slope along the opposite one: of the two, the heading within 90 deg."""
    slope, heading = found["slope"], found["heading"]
    half_turns = round(heading.value / np.pi)
    turn, sign = half_turns * np.pi, -1.0 if half_turns % 2 else 1.0
    low, high = sorted((sign * slope.low, sign * slope.high))
    return {
        "slope": Estimate(sign * slope.value, low, high, slope.unit),
        "heading": Estimate(heading.value - turn, heading.low - turn, heading.high - turn, heading.unit),
    }
