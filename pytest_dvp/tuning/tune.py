"""Tune: a searcher proposes, simulations judge, the best point that breaks nothing is kept."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

from pytest_dvp.tuning.objective import BROKE_OFF, Metrics, Score, metrics_of
from pytest_dvp.tuning.searchers.search import make_searcher
from pytest_dvp.tuning.study import Study
from pytest_dvp.tuning.tuned_parameter import Point, described
from pytest_dvp.workers.pool import Workers

Ended = Literal["nothing improves", "budget"]
STALE = 20  # batches without a new point after which a searcher goes round in circles


@dataclasses.dataclass(frozen=True, slots=True)
class Trial:
    """A point that was judged: its number from 0 (the start), how many simulations had been spent with it, the mean
    of each metric over its simulations (None where one does not define it); each: the metrics of every simulation, in
    the order of `Study.jobs`."""

    number: int
    point: Point
    score: Score
    simulations: int
    metrics: Metrics
    each: tuple[Metrics, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """The trial as JSON holds it."""
        return {
            "number": self.number,
            "simulations": self.simulations,
            "score": self.score.value,
            "broken": list(self.score.broken),
            "parts": dict(self.score.parts),
            "point": dict(self.point),
            "metrics": dict(self.metrics),
        }


@dataclasses.dataclass(frozen=True, slots=True)
class Tuning:
    """Result of `tune`. trials: in the order asked for; best: of them; ended: why it stopped."""

    study: Study
    trials: tuple[Trial, ...]
    ended: Ended

    @property
    def start(self) -> Trial:
        """The trial of the start, always the first."""
        return self.trials[0]

    @property
    def best(self) -> Trial:
        """The best trial."""
        return _best(self.trials)

    @property
    def simulations(self) -> int:
        """Number of simulations up to the last trial."""
        return self.trials[-1].simulations

    def as_dict(self) -> dict[str, Any]:
        """The document of `dvp tune --json`."""
        best = self.best
        return {
            "study": self.study.name,
            "objective": self.study.objective.kind,
            "search": self.study.search,
            "seed": self.study.seed,
            "budget": self.study.budget,
            "simulations": self.simulations,
            "ended": self.ended,
            "start": self.start.as_dict(),
            "best": best.as_dict(),
            "improved": best.score.value < self.start.score.value,
            "knobs": [
                {"name": k.name, "unit": k.unit, "values": list(k.values), "start": self.start.point[k.name],
                 "best": best.point[k.name]}
                for k in self.study.knobs
            ],
            "trials": [trial.as_dict() for trial in self.trials],
        }  # fmt: skip


def tune(
    study: Study, workers: Workers, tick: Callable[[str], None] = lambda text: None,
    done: Callable[[Tuning], None] = lambda so_far: None,
) -> Tuning:  # fmt: skip
    """Search until nothing improves or the budget is spent. Same study, same result, however many workers there are
    and however often it was killed: what was simulated comes from the cache, the search goes the same way again.

    done: told what there is after each batch. Raises what a user's file can raise, and TuneError.
    """
    searcher = make_searcher(study.search, study.knobs, study.start, study.seed)
    trials: list[Trial] = []
    known: dict[tuple[tuple[str, float], ...], Trial] = {}
    each = study.jobs_a_point
    ended: Ended = "nothing improves"
    stale = 0
    while stale < STALE and (points := searcher.ask()):
        fresh = list(dict.fromkeys(_frozen(p) for p in points if _frozen(p) not in known))
        stale = 0 if fresh else stale + 1
        left = (study.budget - len(known) * each) // each
        if left < len(fresh):
            ended = "budget"
            fresh = fresh[: max(left, 0 if known else 1)]
        jobs = [job for frozen in fresh for job in study.jobs(dict(frozen))]
        results = workers.run(jobs, _so_far(study, trials))
        for k, frozen in enumerate(fresh):
            metrics = [metrics_of(result) for result in results[k * each : (k + 1) * each]]
            score = study.objective.score(metrics)
            spent = (len(known) + 1) * each
            known[frozen] = trial = Trial(len(trials), dict(frozen), score, spent, _mean(metrics), tuple(metrics))
            trials.append(trial)
        if trials:
            tick(f"{_so_far(study, trials)}{described(_best(trials).point)}")
            done(Tuning(study, tuple(trials), ended))
        if ended == "budget":
            break
        searcher.tell(points, [known[_frozen(p)].score.value for p in points])
    return Tuning(study, tuple(trials), ended)


def _best(trials: Sequence[Trial]) -> Trial:
    return min(trials, key=lambda trial: (trial.score.value, trial.number))


def _so_far(study: Study, trials: Sequence[Trial]) -> str:
    """`8 of 20 simulations, least score 2.394: `."""
    if not trials:
        return f"0 of {study.budget} simulations: "
    return f"{trials[-1].simulations} of {study.budget} simulations, least score {_best(trials).score.value:.4g}: "


def _frozen(point: Point) -> tuple[tuple[str, float], ...]:
    return tuple(point.items())


def _mean(results: list[Mapping[str, float | None]]) -> dict[str, float | None]:
    found: dict[str, float | None] = {}
    for name in dict.fromkeys(name for metrics in results for name in metrics if name != BROKE_OFF):
        values = [metrics.get(name) for metrics in results]
        known = [value for value in values if value is not None]
        found[name] = sum(known) / len(known) if known and len(known) == len(values) else None
    return found
