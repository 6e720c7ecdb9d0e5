"""Data that judge a fit and were not fitted on: given, else each log from the others, else the end of a single one."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pytest_dvp.gap.diagnose.diagnosis import Step
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, experiment_set
from pytest_dvp.gap.diagnose.least_squares import VALLEYS
from pytest_dvp.gap.diagnose.linear_algebra import square
from pytest_dvp.gap.diagnose.run_setup import RunSetup, split_setup
from pytest_dvp.gap.diagnose.search import PRACTICAL, Search
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_part import cut_log
from vehicle.model.effect_catalogue import run_setups

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel

EXTRAPOLATES = 0.3  # of what an effect does to the data that judge it, that it must do to those fitted on
HELD_OUT_SHARE = 0.4  # of a single log, its end
ROUNDING = 1e-3  # of max(1, chi^2/N): held-out data that change by less say nothing
_FEWEST = 200  # rows on either side


@dataclasses.dataclass(frozen=True, slots=True)
class Fold:
    """What is fitted on (None: all the logs that are fitted on anyway) and what judges the fit.

    setup: where the judging run has a set-up of its own, its beginning; `judge` is then the rest of it.
    """

    fitted: ExperimentSet | None
    judge: ExperimentSet
    setup: RunSetup | None = None

    def lasting(self) -> Fold:
        """The same data; the known remainder of the model is an error that lasts."""
        fitted = self.fitted and self.fitted.lasting()
        return dataclasses.replace(self, fitted=fitted, judge=self.judge.lasting())


def folds(logs: Mapping[str, Log], held_out: Mapping[str, Log] | None, model: VehicleModel,
          effects: Sequence[Effect] = ()) -> tuple[Fold, ...]:  # fmt: skip
    """How a fit on `logs` is judged; empty if a single log is too short to be parted."""

    def on(chosen: Mapping[str, Log]) -> ExperimentSet:
        return experiment_set(chosen, model, extra=effects)

    if held_out:
        return (Fold(None, on(held_out)),)
    if len(logs) > 1:
        return tuple(
            Fold(on({n: log for n, log in logs.items() if n != name}), on({name: logs[name]})) for name in logs
        )
    ((name, log),) = logs.items()
    border = log.t[0] + (1.0 - HELD_OUT_SHARE) * (log.t[-1] - log.t[0])
    rows = int(np.searchsorted(log.t, border))
    if rows < _FEWEST or len(log.t) - rows < _FEWEST:
        return ()
    return (Fold(on({name: cut_log(log, -np.inf, border)}), on({name: cut_log(log, border, np.inf)})),)


def drives_apart(judges: Sequence[Fold]) -> list[ExperimentSet]:
    """The drives held out as a whole: neither parts of the fitted ones, nor with a set-up of their own."""
    return [fold.judge for fold in judges if fold.fitted is None and fold.setup is None]


def folds_with_setup(
    logs: Mapping[str, Log] | None, model: VehicleModel, effects: Sequence[Effect] = ()
) -> tuple[Fold, ...]:
    """The held-out logs as `folds` has them, but each with a set-up of its own; empty if one is too short for that."""
    found = split_setup(logs or {}, model, tuple(effects))
    return tuple(Fold(None, rest, setup) for setup, rest in found) if len(found) == len(logs or {}) else ()


def refit_on_fold(search: Search, fold: Fold, trial: Trial, *, without: str = "") -> Trial:
    """The trial as its own data have it, had only the fold's been there to fit. without: an effect that is no part of a
    run's own set-up.

    An effect that those do not show or determine keeps its value, for it would take any. Of one whose error has many
    valleys the data that judge may choose their own near the value: half a percent beside it another one begins.
    """
    rough = {name for name in trial.names if any(c.rough for c in search.known[name].coordinates)}
    if rough:
        trial = _valley(search, fold, trial, rough)
    if fold.fitted is None:
        if fold.setup is None or not run_setups() & set(trial.names):
            return trial
        return dataclasses.replace(trial, values=fold.setup.fitted(trial.values, without=without))
    shown = [name for name in trial.names if name not in rough and fold_excites(search, fold, trial, name)]
    while True:
        kept = {key: value for key, value in trial.values.items() if key[0] in set(trial.names) - set(shown)}
        found = search.trial(shown, trial.values, target=fold.fitted, kept=kept)
        vague = [name for name in shown if not search.is_credible(found, name, fold.fitted)]
        if not vague:
            return found
        shown = [name for name in shown if name not in vague]


def _valley(search: Search, fold: Fold, trial: Trial, rough: Collection[str]) -> Trial:
    values, best = trial.values, square(fold.judge.whitened(trial.values))
    for name in rough:
        for c in search.known[name].coordinates:
            for offset in VALLEYS:
                other = trial.values | {c.name: c.value(c.to_unit(trial.values[c.name]) + float(offset))}
                left = square(fold.judge.whitened(other))
                if left < best:
                    values, best = other, left
    return dataclasses.replace(trial, values=values)


def fold_excites(search: Search, fold: Fold, trial: Trial, name: str) -> bool:
    """True if the data that the fold fits on would look different without the effect, and not far less so than those
    that judge it: a limit that town driving hardly touches says nothing about a skid pad."""
    if fold.fitted is None:
        return True
    off = trial.values | {c.name: c.key.neutral for c in search.known[name].coordinates}
    r = fold.fitted.whitened(trial.values)
    change = square(fold.fitted.whitened(off) - r)
    if change <= PRACTICAL * max(fold.fitted.count, square(r)):
        return False
    judged = square(fold.judge.whitened(off) - fold.judge.whitened(trial.values))
    return change * fold.judge.count > EXTRAPOLATES * judged * fold.fitted.count


def step(search: Search, trial: Trial, judges: Sequence[Fold], added: str | None = None) -> Step:
    """The error of a set of effects on the data fitted on, and on the data held out. added: the effect that came in,
    the last one where nothing is said."""
    values = trial.values
    samples = 0
    segments: list[float] = []
    squares: dict[str, list[float]] = {}
    runs = []
    for fold in judges:
        fitted = refit_on_fold(search, fold, trial)
        if fold.setup is not None:
            runs.append({key: value for key, value in fitted.values.items() if key[0] in run_setups()})
        segments += fold.judge.by_segment(fold.judge.whitened(fitted.values)).tolist()
        samples += fold.judge.count
        for name, rmse in fold.judge.rmse(fitted.values).items():
            squares.setdefault(name, []).append(rmse)
    return Step(
        added=added if added is not None else "".join(trial.names[-1:]),
        chi2_per_n=trial.chi2 / search.count,
        channels=search.target.by_channel(values),
        rmse=search.target.rmse(values),
        held_out_chi2_per_n=sum(segments) / samples if samples else None,
        held_out_rmse={name: float(np.sqrt(np.mean(np.square(each)))) for name, each in squares.items()},
        segments=tuple(trial.segment_chi2.tolist()),
        held_out_segments=tuple(segments),
        values=values,
        held_out_setups=tuple(runs),
    )
