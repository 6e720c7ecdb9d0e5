"""Data that judge a fit and were not fitted on: given, else each log from the others, else the end of a single one."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pytest_dvp.gap.diagnose.diagnosis import Step
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, experiment_set
from pytest_dvp.gap.diagnose.least_squares import VALLEYS
from pytest_dvp.gap.diagnose.linear_algebra import square
from pytest_dvp.gap.diagnose.run_setup import RunSetup, split_setup
from pytest_dvp.gap.diagnose.search import MIN_BOOTSTRAP_SHARE, PRACTICAL, Search
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.log_part import cut_log
from vehicle.model.effect_catalogue import run_setups

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel

EXTRAPOLATES = 0.3  # of what an effect does to the data that judge it, that it must do to those fitted on
HELD_OUT_SHARE = 0.4  # of a single log, its end
RIVAL_SHARE = 0.5  # of what an effect explains, that another one must explain in its place to be a rival
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


def rivals_over_segments(
    search: Search,
    judges: Sequence[Fold],
    best: Trial,
    possible: Callable[[Trial, str], bool] = lambda other, name: True,
) -> dict[str, tuple[str, ...]]:
    """Effects by the named one that do as well in its place, where parts of all the data are drawn by chance.
    possible: whether a set that ends with another effect may be true at all, in the place of this one.

    Where a model leaves more than noise, its errors repeat themselves from sample to sample, and a gap between two sets
    that noise could not make is no proof. Whole segments of the data fitted on and of those held out are drawn instead.
    """
    shown = [fold for fold in judges if all(fold_excites(search, fold, best, name) for name in best.names)]

    def segments(trial: Trial) -> FloatArray:
        parts = [trial.segment_chi2]
        for fold in shown:
            parts.append(fold.judge.by_segment(fold.judge.whitened(refit_on_fold(search, fold, trial).values)))
        return np.concatenate(parts)

    found: dict[str, tuple[str, ...]] = {}
    ahead = segments(best)
    for name in best.names:
        most = (1.0 - RIVAL_SHARE) * float((segments(search.without(best, name)) - ahead).sum())
        rivals = []
        for other in search.in_place_of(best, name):
            if not search.is_rival(best, other, name):
                continue
            behind = segments(other)
            close = float((behind - ahead).sum()) < most
            if close and search.bootstrap_share(behind, ahead) < MIN_BOOTSTRAP_SHARE:
                rivals += (
                    [other.names[-1]] if search.is_credible(other, other.names[-1]) and possible(other, name) else []
                )
        found[name] = tuple(rivals)
    return found


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
