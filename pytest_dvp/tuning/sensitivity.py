"""Which knob moves which metric: elementary effects of the trials that a search has made anyway."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Mapping

import numpy as np

from pytest_dvp.tuning.tune import Trial, Tuning


@dataclasses.dataclass(frozen=True, slots=True)
class Influence:
    """Of a knob on a metric: mean size and spread of its elementary effects, in units of the metric's scale for the
    whole range of the knob; count of pairs. A spread as large as the mean tells of interactions or a bend."""

    mean: float
    spread: float
    count: int


def sensitivity(tuning: Tuning) -> dict[str, dict[str, Influence]]:
    """Knob -> metric of the objective -> influence, from all pairs of trials that differ in one knob alone.

    Source: Morris, Factorial Sampling Plans for Preliminary Computational Experiments, Technometrics 33 (1991): mu* and
    sigma; here on the points of the search instead of random ones, so that it costs no simulation.
    """
    found: dict[str, dict[str, Influence]] = {}
    terms = {term.metric: term.scale for term in tuning.study.objective.terms}
    for knob in tuning.study.knobs:
        effects: dict[str, list[float]] = {metric: [] for metric in terms}
        for one, other in _pairs(tuning.trials, knob.name):
            reach = knob.share(other.point[knob.name]) - knob.share(one.point[knob.name])
            for metric, scale in terms.items():
                a, b = one.metrics.get(metric), other.metrics.get(metric)
                if a is not None and b is not None and reach != 0.0:
                    effects[metric].append((b - a) / scale / reach)
        found[knob.name] = {metric: _influence(values) for metric, values in effects.items() if values}
    return found


def as_dict(found: Mapping[str, Mapping[str, Influence]]) -> dict[str, dict[str, dict[str, float]]]:
    """JSON-able."""
    return {knob: {m: dataclasses.asdict(i) for m, i in metrics.items()} for knob, metrics in found.items()}


def _influence(values: list[float]) -> Influence:
    return Influence(float(np.mean(np.abs(values))), float(np.std(values)), len(values))


def _pairs(trials: tuple[Trial, ...], name: str) -> list[tuple[Trial, Trial]]:
    """Trials that are neighbours in one knob, all others being equal."""
    lines: dict[tuple[tuple[str, float], ...], list[Trial]] = {}
    for trial in trials:
        lines.setdefault(tuple((k, v) for k, v in trial.point.items() if k != name), []).append(trial)
    found: list[tuple[Trial, Trial]] = []
    for line in lines.values():
        found += itertools.pairwise(sorted(line, key=lambda trial: trial.point[name]))
    return found
