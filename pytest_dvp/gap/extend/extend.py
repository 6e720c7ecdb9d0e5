"""Add effects to a vehicle model: fitted jointly, judged on data they were not fitted on, the error falling."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pytest_dvp.gap.diagnose.below_remainder import SHOWN_BELOW, Below, confused_with, shown_below, with_below
from pytest_dvp.gap.diagnose.candidates import Candidate, candidates, candidates_of
from pytest_dvp.gap.diagnose.diagnosis import NamedEffect
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, Values, experiment_set, on_same_roads
from pytest_dvp.gap.diagnose.fitted_twin import Drives, values_of, with_remainder
from pytest_dvp.gap.diagnose.fitted_values import Estimates, estimates
from pytest_dvp.gap.diagnose.held_out import folds, step
from pytest_dvp.gap.diagnose.input_scales import free_scales
from pytest_dvp.gap.diagnose.linear_algebra import square
from pytest_dvp.gap.diagnose.search import CHANNEL_MISFIT, Search
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.gap.extend.acceptance import Acceptance, judge_addition, judge_removal, worse_together
from pytest_dvp.gap.extend.extension import Extension, Rung
from pytest_dvp.gap.extend.fit_notes import assumed, edges
from pytest_dvp.gap.extend.fitted_model import fitted_model
from pytest_dvp.gap.extend.ladder import ladder_of, shares
from pytest_dvp.gap.extend.perception import judge_perception
from pytest_dvp.gap.extend.settled_fit import settled_fit
from pytest_dvp.gap.extend.twin_remainder import beside_remainder, with_shape
from pytest_dvp.gap.words.comparison import NOTHING_LEFT
from pytest_dvp.logs.log import Log
from vehicle.model.errors import ModelError, nearest_name

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import AppliedEffect, VehicleModel

_BEGINNINGS = 3  # points of an effect's range from which a fit of it starts

ONCE_MORE = "~ once more, where what is left lasts"
WHY_ONCE_MORE = (
    "what was fitted is fitted once more with what the model leaves as an error that lasts, for data held out are "
    "better by that; as the rows count each sample alone, the last one may show more error"
)
WHY_THERE = (
    "they, and what they are often confused with, are fitted with what the model leaves as an error that lasts; as the "
    "rows count each sample alone, the last one may show more error"
)

Tick = Callable[[str], None]


def extend(
    logs: Mapping[str, Log],
    model: VehicleModel,
    *,
    add: Sequence[str] = (),
    remove: Sequence[str] = (),
    refit: bool = False,
    held_out: Mapping[str, Log] | None = None,
    effects: Sequence[Effect] = (),
    start: Values | None = None,
    fitted_on: Sequence[str] = (),
    twins: Mapping[str, Log] | None = None,
    tick: Tick = lambda text: None,
) -> Extension:
    """A model with effects added to it or removed from it, fitted jointly to logs, and whether it may be taken.

    logs by name, fitted on; held_out: logs that have the last word, without them as in `diagnose`. add: names of
    effects; one that the model has is fitted again. refit: so are all the others it has; without it only those that an
    effect is often confused with which the data show where what is left lasts. effects: the user's own. start: values
    from which the fit begins, (effect, key) -> value, as a diagnosis found them; one that knows all that is added is
    where the fit of all begins, for one after the other they may end elsewhere. fitted_on: what the model file says of
    the logs. twins: runs of the model by scenario, beside which detections are judged.

    It may not be taken (`refusal`) if an effect explains nothing of the data fitted on, or loses on the data held out,
    or if what was removed is missed there.

    Raises ModelError or CompareError (one line): an unknown effect, one that does not suit the model, an input missing.
    """
    tick("preparing")
    target = experiment_set(logs, model, extra=effects)
    wanted = _wanted(model, add, effects)
    chosen = _chosen(model, [e for e in wanted if e.slot != "perception"], target)
    seen = [e for e in wanted if e.slot == "perception"]
    gone = [_present(model, name) for name in remove]
    lost = [a.name for a in gone if a.effect.slot != "perception"]
    kept = candidates_of(model, {a.name for a in model.effects} - {*add, *remove}) if refit else []
    search = _search(target, model, [*kept, *chosen], lost)
    begin = {**search.start, **values_of(model), **dict(start or {})}
    drives, provenance = Drives(logs, held_out or {}, effects), tuple(fitted_on)
    judges = folds(logs, held_out, on_same_roads(model, target), effects)

    def made(some: Sequence[Candidate]) -> _Made:
        known = bool(some) and all(c.name in (start or {}) for one in some for c in one.coordinates)
        final = _fitted(search, begin, [c.name for c in kept], some, together=known)
        sure = estimates(final, search)
        return _Made(some, final, sure, [judge_addition(search, final, c, judges, model, sure) for c in some])

    def twin_of(one: _Made) -> VehicleModel:
        mine = [c.effect for c in one.chosen]
        return with_remainder(
            fitted_model(model, one.final, one.sure, remove, mine, provenance), search, one.final, judges
        )

    tick("fitting")
    below: list[Below] = []
    whole, grown = made(chosen), model
    if held_out and (refused := whole.refused):
        tick("what is left as an error that lasts")
        less = made([c for c in chosen if c not in refused])
        grown, below = _grown_below(twin_of(less), refused, begin, drives)
        shown = {one.name for one in below}
        if len(shown) == len(refused):
            whole = less
        elif shown:
            whole = made([c for c in chosen if c.name not in shown])
            again = [c for c in refused if c.name in shown]
            grown, below = _grown_below(twin_of(whole), again, begin, drives)
    final, sure, done = whole.final, whole.sure, whole.done
    tick("held-out data")
    ladder = tuple(ladder_of(search, final, len(kept), lost, judges, {a.name for a in model.effects}))
    done += [judge_removal(search, final, name, model, judges) for name in lost]
    blind = [a.name for a in gone if a.effect.slot == "perception"]
    done += judge_perception(model, logs, held_out or {}, seen, blind, twins)
    sure |= {(d.effect.name, key): value for d in done for key, value in d.effect.parameters.items()
             if d.effect.action != "remove"}  # fmt: skip
    steps = [rung.step for rung in ladder]
    explains = shares(steps)
    named = tuple(dataclasses.replace(d.effect, gain=explains.get(d.effect.name, d.effect.gain)) for d in done)
    channels = target.by_channel(final.values)
    left = (steps[-1].chi2_per_n, steps[-1].held_out_chi2_per_n or 0.0)
    explained = max(left) <= NOTHING_LEFT and max(channels.values(), default=0.0) <= CHANNEL_MISFIT
    refused_names = tuple(d.effect.name for d in done if d.wrong)
    wrong = [d.wrong for d in done if d.wrong]
    # Logs that are predicted from the others may show nothing of an effect: those judge only what was fitted again
    if not wrong and (kept or (held_out and whole.chosen)):
        wrong = worse_together(steps)
    if below:
        extended = dataclasses.replace(grown, remainder=model.remainder, remainder_shape=model.remainder_shape)
        detections = {key: value for key, value in sure.items() if key[0] in {e.name for e in seen}}
        extended, twin = fitted_model(extended, final, detections, (), seen, provenance), grown
    else:
        extended = fitted_model(model, final, sure, remove, wanted, provenance)
        twin = with_remainder(extended, search, final, judges)
    notes = [d.note for d in done if d.note]
    tick("fitting beside what is left")
    last_row, why = ONCE_MORE, WHY_ONCE_MORE
    better = beside_remainder(twin, [*final.names, *(one.name for one in below)], drives)
    if below and not better:
        last_row, why = f"+ {', '.join(one.name for one in below)}, where what is left lasts", WHY_THERE
        along = [name for one in below for name in (one.name, *confused_with(twin, one.name))]
        better = beside_remainder(twin, dict.fromkeys(along), drives, always=True)
    if better:
        sure |= better
        named = tuple(_with_values(e, better) for e in (*named, *(one.as_named() for one in below)))
        extended = fitted_model(extended, final, better, (), (), provenance)
        plain = Search(experiment_set(logs, extended, extra=effects), ())
        last = plain.trial((), {})
        judges = folds(logs, held_out, extended, effects)
        ladder = (*ladder, Rung(last_row, step(plain, last, judges)))
        twin = with_remainder(extended, plain, last, judges)
        notes += [f"{one.name}: {SHOWN_BELOW}" for one in below]
        notes.append(f"the last row, {last_row[2:]}: {why}")
    return Extension(
        model=with_shape(twin, logs, held_out or {}, effects),
        effects=named,
        refitted={name: value for name, value in sure.items() if name[0] not in add},
        ladder=ladder,
        noise_floor=target.noise(),
        refusal="; ".join(wrong),
        notes=(*notes, *edges(final), *assumed(final, model)),
        explained=explained,
        excused=bool(model.remainder),
        refused=refused_names,
    )


class _Made(NamedTuple):
    """A joint fit: of which effects, their values with intervals, and whether each may stay."""

    chosen: Sequence[Candidate]
    final: Trial
    sure: Estimates
    done: list[Acceptance]

    @property
    def refused(self) -> list[Candidate]:
        """New effects that may not stay where each sample counts for itself."""
        return [c for c, d in zip(self.chosen, self.done, strict=True) if d.wrong and d.effect.action == "add"]


def _grown_below(
    twin: VehicleModel, refused: Sequence[Candidate], begin: Values, drives: Drives
) -> tuple[VehicleModel, list[Below]]:
    """The twin with those of the effects that all drives show where its remainder lasts, each beside those before it,
    and these."""
    found: list[Below] = []
    for candidate in refused:
        if one := shown_below(twin, drives, candidate, begin):
            twin = with_below(twin, drives, one)
            found.append(one)
    return twin, found


def _with_values(e: NamedEffect, better: Estimates) -> NamedEffect:
    return dataclasses.replace(e, parameters={k: better.get((e.name, k), value) for k, value in e.parameters.items()})


def _wanted(model: VehicleModel, add: Sequence[str], effects: Sequence[Effect]) -> list[Effect]:
    """The effects that are meant. Raises ModelError."""
    from vehicle.model.effect_catalogue import find_effect
    from vehicle.model.vehicle_model import check_base

    found = [find_effect(name, {e.name: e for e in effects}) for name in dict.fromkeys(add)]
    for effect in found:
        check_base(effect, model.base)
    return found


def _chosen(model: VehicleModel, effects: Sequence[Effect], target: ExperimentSet) -> list[Candidate]:
    """What is to be fitted, each with its points of departure. Raises ModelError."""
    found: list[Candidate] = []
    for effect in effects:
        suited = candidates(model, [effect], ay="ay" in target.channels, refined=True)
        if not suited:
            inputs = f"{' + '.join(model.inputs.longitudinal)} and {model.inputs.steer}"
            why = f"it needs other inputs than {inputs}, or a motor_torque whose data are known"
            raise ModelError(f"cannot be fitted to this model: {why}", key=effect.name)
        found += suited
    return found


def _present(model: VehicleModel, name: str) -> AppliedEffect:
    names = [a.name for a in model.effects]
    if name in names:
        return model.effects[names.index(name)]
    has = ", ".join(names) or "none"
    raise ModelError("effect is not in the model", found=name, allowed=has, nearest=nearest_name(name, names))


def _search(target: ExperimentSet, model: VehicleModel, tried: Sequence[Candidate], lost: Sequence[str]) -> Search:
    """What fits the new model. Scales of the input map that nobody knows are fitted along, as `diagnose` does, but for
    those that an effect repeats."""
    free, start = free_scales(model, [one.effect for one in tried])
    off = {(a.name, key.name): key.neutral for a in model.effects if a.name in lost for key in a.effect.parameters}
    return Search(target, tried, nuisance=free if tried else (), start=start, fixed=off)


def _fitted(
    search: Search, begin: Values, kept: Sequence[str], chosen: Sequence[Candidate], *, together: bool
) -> Trial:
    """All together. together: they were fitted beside each other before, and go on from there at once; else each effect
    is begun where it takes away most beside those before it."""
    if together:
        search.target.settle(begin)
        return settled_fit(search, search.trial([*kept, *(one.name for one in chosen)], begin))
    now = search.trial(kept, begin)
    for candidate in chosen:
        known = {name: value for name, value in begin.items() if name[0] == candidate.name}
        points = list(candidate.points)
        if len(known) == len(candidate.coordinates):
            car = {name: value for name, value in begin.items() if name[0] == "parameters"}
            points.insert(0, {**known, **car})
        left = [square(search.target.whitened(now.values | point)) for point in points]
        best = [points[k] for k in np.argsort(left, kind="stable")[:_BEGINNINGS]]
        trials = [search.trial((*now.names, candidate.name), now.values | point) for point in best]
        now = min(trials, key=lambda t: t.chi2)
        search.target.settle(now.values)
    return settled_fit(search, now)
