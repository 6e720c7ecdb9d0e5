"""Whether an effect may stay in a model: what it explains where it is fitted, and what it does to data held out."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TYPE_CHECKING

from pytest_dvp.gap.diagnose.candidates import Candidate
from pytest_dvp.gap.diagnose.diagnosis import Estimate, NamedEffect, Step
from pytest_dvp.gap.diagnose.fitted_values import Estimates
from pytest_dvp.gap.diagnose.held_out import ROUNDING, Fold, fold_excites, refit_on_fold
from pytest_dvp.gap.diagnose.linear_algebra import square
from pytest_dvp.gap.diagnose.search import PRACTICAL, Search
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.gap.diagnose.veto import allowed_loss
from pytest_dvp.gap.words.diagnosis import figure

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import VehicleModel


@dataclasses.dataclass(frozen=True, slots=True)
class Acceptance:
    """An effect, why it must not stay as it is (empty if it may), and what is to be known."""

    effect: NamedEffect
    wrong: str = ""
    note: str = ""


def judge_addition(
    search: Search, final: Trial, candidate: Candidate, judges: Sequence[Fold], model: VehicleModel, sure: Estimates
) -> Acceptance:
    """An effect beside all the others: it must pay where it is fitted and must not lose where it is not."""
    name = candidate.name
    rest = [n for n in final.names if n != name]
    less = search.trial(rest, final.values)
    mine = {key: value for (effect, key), value in sure.items() if effect == name}
    changed = any(a.name == name for a in model.effects)
    effect = NamedEffect(name=name, parameters=mine, action="change" if changed else "add")
    gain = (less.chi2 - final.chi2) / search.count
    level = max(1.0, final.chi2 / search.count)
    if gain < search.least_gain(level, first=not rest):
        beside = f" beside {', '.join(rest)}" if rest else ""
        if changed:
            fitted = ", ".join(f"{key} = {e.value:.4g} {e.unit}".rstrip(" -") for key, e in mine.items())
            return Acceptance(effect, wrong=(
                f"{name} is in the model already, and another value gains too little{beside}: chi²/N "
                f"{figure(less.chi2 / search.count)} as it stands, {figure(final.chi2 / search.count)} with {fitted}; "
                "it stays as it is: leave it out of what is added"
            ))  # fmt: skip
        return Acceptance(effect, wrong=(
            f"{name} explains too little{beside} to be worth an effect: chi²/N {figure(less.chi2 / search.count)} "
            f"without it, {figure(final.chi2 / search.count)} with it; leave it out, or drive what would show it: "
            f"{candidate.effect.reveals}"
        ))  # fmt: skip
    before = after = 0.0
    samples = 0
    for fold in judges:
        if not fold_excites(search, fold, final, name):
            continue  # what its own data do not show cannot be fitted, and so not judged
        before += _left(fold, refit_on_fold(search, fold, less))
        after += _left(fold, refit_on_fold(search, fold, final))
        samples += fold.judge.count
    if not samples:
        return Acceptance(effect, note=(
            f"{name} is not judged on held-out data: no part of the logs shows it without the rest; "
            "name a log with --held-out"
        ))  # fmt: skip
    before, after = before / samples, after / samples
    effect = dataclasses.replace(effect, held_out_gain=before - after)
    rounding = ROUNDING * max(1.0, before)
    if after - before > rounding and after - before > allowed_loss(search, final, name, level, gain, judges):
        return Acceptance(effect, wrong=(
            f"{f'the new value of {name}' if changed else name} loses on held-out data, chi²/N "
            f"{figure(before)} -> {figure(after)} ({_percent(before, after)}), though it gains where it is fitted "
            f"({_percent(less.chi2, final.chi2)}): leave it out, or fit on more logs"
        ))  # fmt: skip
    if after - before > rounding:
        return Acceptance(effect, note=(
            f"{name} loses a little on held-out data, chi²/N {figure(before)} -> {figure(after)}, beside a gain of "
            f"{figure(gain)} where it is fitted"
        ))  # fmt: skip
    if before - after < rounding:
        return Acceptance(effect, note=f"held-out data do not show {name}: they neither gain nor lose by it")
    return Acceptance(effect)


def judge_removal(search: Search, final: Trial, name: str, model: VehicleModel, judges: Sequence[Fold]) -> Acceptance:
    """An effect that was taken out must not be missed, neither in the logs fitted on nor in those held out."""
    applied = next(a for a in model.effects if a.name == name)
    off = {k.name: Estimate(k.neutral, k.neutral, k.neutral, k.unit) for k in applied.effect.parameters}
    effect = NamedEffect(name=name, parameters=off, action="remove")
    back = {(name, key): value for key, value in applied.values.items()}
    data = [("the data fitted on", search.target)]
    data += [("held-out data", fold.judge) for fold in judges if fold.fitted is None]
    for called, each in data:
        count = max(each.count, 1)
        with_it = square(each.whitened(final.values | back)) / count
        without = square(each.whitened(final.values)) / count
        effect = dataclasses.replace(effect, held_out_gain=with_it - without if each is not search.target else None)
        if without - with_it > PRACTICAL * max(1.0, with_it):
            return Acceptance(effect, wrong=(
                f"without {name} the error on {called} grows, chi²/N {figure(with_it)} -> {figure(without)} "
                f"({_percent(with_it, without)}): keep it"
            ))  # fmt: skip
    return Acceptance(effect)


def worse_together(steps: Sequence[Step]) -> list[str]:
    """Why the new model as a whole loses on the data held out; empty if it does not. What stays within the noise has
    lost nothing: of a twin with a known remainder, which counts as noise, drives differ by that much."""
    before, after = steps[0].held_out_chi2_per_n, steps[-1].held_out_chi2_per_n
    if before is None or after is None or after <= 1.0 or after - before <= ROUNDING * max(1.0, before):
        return []
    return [
        f"the new model loses on held-out data, chi²/N {figure(before)} -> {figure(after)} "
        f"({_percent(before, after)}): fit on more logs, or fewer values"
    ]


def _left(fold: Fold, trial: Trial) -> float:
    return square(fold.judge.whitened(trial.values))


def _percent(before: float, after: float) -> str:
    if before <= 0.0:
        return "from nothing"
    change = 100.0 * (after / before - 1.0)
    return f"{change:+.0f} %" if abs(change) >= 10.0 else f"{change:+.2g} %"
