"""Tree-structured Parzen estimators over the candidates of the knobs (extra `tune`)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pytest_dvp.tuning.tuned_parameter import Knob, Point

BATCH = 4  # points asked for at once, whatever the number of cores


class Tpe:
    """TPE in the unit cube of the knobs' ranges; a batch is BATCH points.

    Source: Bergstra et al., Algorithms for Hyper-Parameter Optimization, NIPS 2011; package `optuna`.
    """

    def __init__(self, knobs: Sequence[Knob], start: Point, seed: int) -> None:
        import optuna

        optuna.logging.set_verbosity(optuna.logging.ERROR)
        self.knobs, self._start, self._first = tuple(knobs), dict(start), True
        sampler = optuna.samplers.TPESampler(seed=seed, n_startup_trials=10, constant_liar=True)
        self._study = optuna.create_study(sampler=sampler)
        self._asked: list[Any] = []

    def ask(self) -> list[Point]:
        """The start alone first, then BATCH points each time; never empty."""
        if self._first:
            self._study.enqueue_trial({k.name: k.share(self._start[k.name]) for k in self.knobs})
            self._point()
            return [dict(self._start)]
        self._asked = []
        return [self._point() for _ in range(BATCH)]

    def _point(self) -> Point:
        trial = self._study.ask()
        self._asked.append(trial)
        return {k.name: k.at(trial.suggest_float(k.name, 0.0, 1.0)) for k in self.knobs}

    def tell(self, points: Sequence[Point], scores: Sequence[float]) -> None:
        """Scores of the batch, smaller is better."""
        self._first = False
        for trial, score in zip(self._asked, scores, strict=False):
            self._study.tell(trial, score)


def make(knobs: Sequence[Knob], start: Point, seed: int) -> Tpe:
    """The search from `start` on. Raises ModuleNotFoundError without the package."""
    return Tpe(knobs, start, seed)
