"""The cross-entropy method over the continuous ranges of the knobs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pytest_dvp.tuning.tuned_parameter import Knob, Point

SPREAD = 0.3  # of the range, first standard deviation: its middle two thirds reach over half of the range
ELITE = 0.25  # share of a batch that the next one is drawn around; 10 to 30 % are usual (source, section 5)
SMOOTHING = 0.7  # weight of the new estimate; the rest keeps a batch from collapsing onto one lucky point
LEAST_SPREAD = 0.005  # of the range, below which the search has ended


class CrossEntropy:
    """Draws a batch from a normal distribution for each knob, and fits it to the best of the batch.

    Source: de Boer, Kroese, Mannor, Rubinstein, A Tutorial on the Cross-Entropy Method, Annals of Operations Research
    134 (2005).
    """

    def __init__(self, knobs: Sequence[Knob], start: Point, seed: int) -> None:
        self.knobs, self._start, self._first = tuple(knobs), dict(start), True
        self._rng = np.random.default_rng(seed)
        self._mean = np.array([knob.share(start[knob.name]) for knob in self.knobs])
        self._spread = np.full(len(self.knobs), SPREAD)
        self._batch = 8 + 2 * len(self.knobs)

    def ask(self) -> list[Point]:
        """The start alone first, then one batch each time; empty when the spread is gone."""
        if self._first:
            return [dict(self._start)]
        if (self._spread < LEAST_SPREAD).all():
            return []
        drawn = np.clip(self._rng.normal(self._mean, self._spread, (self._batch, len(self.knobs))), 0.0, 1.0)
        return [{knob.name: knob.at(float(u)) for knob, u in zip(self.knobs, row, strict=True)} for row in drawn]

    def tell(self, points: Sequence[Point], scores: Sequence[float]) -> None:
        """Scores of the batch, smaller is better."""
        if self._first:
            self._first = False
            return
        order = np.argsort(np.array(scores), kind="stable")[: max(2, round(ELITE * len(points)))]
        elite = np.array([[knob.share(points[k][knob.name]) for knob in self.knobs] for k in order])
        self._mean = SMOOTHING * elite.mean(axis=0) + (1.0 - SMOOTHING) * self._mean
        self._spread = SMOOTHING * elite.std(axis=0) + (1.0 - SMOOTHING) * self._spread


def make(knobs: Sequence[Knob], start: Point, seed: int) -> CrossEntropy:
    """The search from `start` on."""
    return CrossEntropy(knobs, start, seed)
