"""A local descent over the continuous ranges of the knobs: steps around the best point, which grow and shrink."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pytest_dvp.tuning.tuned_parameter import Knob, Point

BATCH = 4  # points asked for at once, whatever the number of cores
STEP = 0.1  # of the range, first step
GROW, SHRINK = 1.5, 0.6  # about the one-fifth rule: a batch of 4 that holds a better point was not too bold
LEAST_STEP = 0.002  # of the range, below which the search has ended


class Descent:
    """An evolution strategy (1+4): normal steps around the best point, kept if one is better.

    Source: Rechenberg's one-fifth success rule, Evolutionsstrategie, 1973; here by batches.
    """

    def __init__(self, knobs: Sequence[Knob], start: Point, seed: int) -> None:
        self.knobs, self._first, self._step = tuple(knobs), True, STEP
        self._rng = np.random.default_rng(seed)
        self._best = dict(start)
        self._score = float("inf")

    def ask(self) -> list[Point]:
        """The start alone first, then BATCH steps each time; empty when the steps have become small."""
        if self._first:
            return [dict(self._best)]
        if self._step < LEAST_STEP:
            return []
        steps = self._rng.normal(0.0, self._step, (BATCH, len(self.knobs)))
        return [
            {k.name: k.at(k.share(self._best[k.name]) + float(d)) for k, d in zip(self.knobs, row, strict=True)}
            for row in steps
        ]

    def tell(self, points: Sequence[Point], scores: Sequence[float]) -> None:
        """Scores of the batch, smaller is better."""
        k = min(range(len(scores)), key=lambda i: (scores[i], i))
        better = scores[k] < self._score
        if better:
            self._best, self._score = dict(points[k]), scores[k]
        if not self._first:
            self._step *= GROW if better else SHRINK
        self._step = min(self._step, 0.3)  # of the range: beyond it a step is no longer local
        self._first = False


def make(knobs: Sequence[Knob], start: Point, seed: int) -> Descent:
    """The search from `start` on."""
    return Descent(knobs, start, seed)
