"""A bandit over sub-regions: each knob's range is cut into equal parts, and each part is an arm."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.tuning.tuned_parameter import Knob, Point

PARTS = 5  # arms of a knob, the default of VerifAI's sampler
ELITE = 0.2  # share of all scores so far that counts as a win, where none is below 0


class Bandit:
    """Draws the part of each knob by the upper confidence bound of its share of wins, and evenly within it.

    A score below 0 (a failure) is a win; so is the best ELITE of all as long as failures are rare, which shows the way
    to them. Source: Auer, Cesa-Bianchi and Fischer, Finite-time analysis of the multiarmed bandit problem, Machine
    Learning 47 (2002), UCB1; the sampler `mab` of VerifAI, Dreossi et al., CAV 2019, has an arm for each part of each
    dimension, too.
    """

    def __init__(self, knobs: Sequence[Knob], start: Point, seed: int) -> None:
        self.knobs, self._start = tuple(knobs), dict(start)
        self._rng = np.random.default_rng(seed)
        self._batch = 8 + 2 * len(self.knobs)
        self._parts = np.zeros((0, len(self.knobs)), dtype=np.int64)
        self._scores = np.zeros(0)

    def ask(self) -> list[Point]:
        """The start alone first, then one batch each time."""
        if not len(self._scores):
            return [dict(self._start)]
        played, wins = self._record()
        points: list[Point] = []
        for _ in range(self._batch):
            # a little noise decides between arms that are equal
            bound = _bounds(played, wins) + 1e-6 * self._rng.random(played.shape)
            parts = np.argmax(bound, axis=1)
            played[np.arange(len(parts)), parts] += 1.0  # as if it had lost: a batch is not one part again and again
            shares = (parts + self._rng.random(len(self.knobs))) / PARTS
            points.append({knob.name: knob.at(float(u)) for knob, u in zip(self.knobs, shares, strict=True)})
        return points

    def tell(self, points: Sequence[Point], scores: Sequence[float]) -> None:
        """Scores of the batch, smaller is better."""
        shares = np.array([[knob.share(point[knob.name]) for knob in self.knobs] for point in points])
        self._parts = np.concatenate([self._parts, np.minimum((shares * PARTS).astype(np.int64), PARTS - 1)])
        self._scores = np.concatenate([self._scores, np.array(scores, dtype=np.float64)])

    def _record(self) -> tuple[FloatArray, FloatArray]:
        """How often each part of each knob was played, and how often it won: (knobs, PARTS) each."""
        failed = self._scores < 0.0
        won = failed if failed.mean() > ELITE else self._scores <= max(np.quantile(self._scores, ELITE), -1e-12)
        played, wins = np.zeros((2, len(self.knobs), PARTS))
        for k in range(len(self.knobs)):
            played[k] = np.bincount(self._parts[:, k], minlength=PARTS)
            wins[k] = np.bincount(self._parts[:, k], weights=won, minlength=PARTS)
        return played, wins


def _bounds(played: FloatArray, wins: FloatArray) -> FloatArray:
    """Upper confidence bound (knobs, PARTS) of the share of wins of each part, 0 or more."""
    some = np.maximum(played, 0.5)
    total = played.sum(axis=1, keepdims=True)
    return np.asarray(wins / some + np.sqrt(2.0 * np.log(total + 1.0) / some))


def make(knobs: Sequence[Knob], start: Point, seed: int) -> Bandit:
    """The search from `start` on."""
    return Bandit(knobs, start, seed)
