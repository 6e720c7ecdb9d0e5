"""Bayesian optimisation with a Gaussian process over the continuous ranges of the knobs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.tuning.tuned_parameter import Knob, Point

BATCH = 4  # points asked for at once, whatever the number of cores
CANDIDATES = 1000  # points at which the acquisition is looked at, for each batch
LENGTHS = (0.1, 0.2, 0.4, 0.8)  # of the range: length scales that the marginal likelihood chooses from
NOISE = 1e-4  # variance of a score beside that of all scores: a drive repeats itself, the process is only smooth
BOLD = 1.5  # standard deviations below the mean that a point is hoped to reach
MOST = 300  # newest points that the process is fitted to, with the best: the cost grows with their cube


class GaussianProcess:
    """Asks where the lower confidence bound of a Gaussian process is least; one batch believes its own predictions.

    Sources: Srinivas et al., Gaussian Process Optimization in the Bandit Setting, ICML 2010 (the bound); Ginsbourger et
    al., Kriging is well-suited to parallelize optimization, 2010 (the "kriging believer" of a batch); Rasmussen and
    Williams, Gaussian Processes for Machine Learning, 2006, algorithm 2.1.
    """

    def __init__(self, knobs: Sequence[Knob], start: Point, seed: int) -> None:
        self.knobs, self._start, self._first = tuple(knobs), dict(start), True
        self._rng = np.random.default_rng(seed)
        self._at: list[list[float]] = []
        self._scores: list[float] = []
        self._length = LENGTHS[1]

    def ask(self) -> list[Point]:
        """The start alone first, then even draws until there are two for each knob, then BATCH points each time."""
        if self._first:
            return [dict(self._start)]
        size = len(self.knobs)
        if len(self._scores) < 2 * size + 2:
            return [self._point(row) for row in self._rng.random((BATCH, size))]
        at, scores = self._known()
        best = at[int(np.argmin(scores))]
        picked: list[FloatArray] = []
        for _ in range(BATCH):
            near = np.clip(best + self._rng.normal(0.0, 0.05, (CANDIDATES // 4, size)), 0.0, 1.0)
            tried = np.vstack([self._rng.random((CANDIDATES - len(near), size)), near])
            mean, deviation = predicted(at, scores, tried, self._length)
            k = int(np.argmin(mean - BOLD * deviation))
            picked.append(tried[k])
            at, scores = np.vstack([at, tried[k]]), np.append(scores, mean[k])
        return [self._point(row) for row in picked]

    def tell(self, points: Sequence[Point], scores: Sequence[float]) -> None:
        """Scores of the batch, smaller is better."""
        self._first = False
        self._at += [[knob.share(point[knob.name]) for knob in self.knobs] for point in points]
        self._scores += scores
        if len(self._scores) > 1:
            at, known = self._known()
            self._length = chosen_length(at, known)

    def _known(self) -> tuple[FloatArray, FloatArray]:
        scores = np.array(self._scores)
        kept = sorted({*range(len(scores))[-MOST:], *np.argsort(scores, kind="stable")[:20].tolist()})
        return np.array(self._at)[kept], scores[kept]

    def _point(self, shares: FloatArray) -> Point:
        return {knob.name: knob.at(float(share)) for knob, share in zip(self.knobs, shares, strict=True)}


def predicted(at: FloatArray, scores: FloatArray, tried: FloatArray, length: float) -> tuple[FloatArray, FloatArray]:
    """Mean (m,) and standard deviation (m,) in units of the scores at `tried` (m, d), after scores (n,) at `at` (n, d)
    in shares of the ranges."""
    from scipy.linalg import cho_factor, cho_solve

    centre, scale = scores.mean(), max(float(scores.std()), 1e-12)
    factor = cho_factor(_covariance(at, at, length) + NOISE * np.eye(len(at)), lower=True)
    between = _covariance(tried, at, length)
    mean = between @ cho_solve(factor, (scores - centre) / scale)
    variance = 1.0 - np.einsum("ij,ji->i", between, cho_solve(factor, between.T))
    return centre + scale * mean, scale * np.sqrt(np.maximum(variance, 0.0))


def chosen_length(at: FloatArray, scores: FloatArray) -> float:
    """Of LENGTHS the one with the greatest marginal likelihood of scores (n,) at (n, d) shares of the ranges; units of
    the scores do not matter."""
    from scipy.linalg import cho_factor, cho_solve

    y = (scores - scores.mean()) / max(float(scores.std()), 1e-12)
    likelihoods = []
    for length in LENGTHS:
        factor = cho_factor(_covariance(at, at, length) + NOISE * np.eye(len(at)), lower=True)
        likelihoods.append(-0.5 * float(y @ cho_solve(factor, y)) - float(np.log(np.diag(factor[0])).sum()))
    return LENGTHS[int(np.argmax(likelihoods))]


def _covariance(one: FloatArray, other: FloatArray, length: float) -> FloatArray:
    """Matern 5/2: rough enough for a margin that bends where another road user becomes the tightest."""
    squared = ((one[:, None, :] - other[None, :, :]) ** 2).sum(axis=2)
    r = np.sqrt(5.0 * squared) / length
    return np.asarray((1.0 + r + r * r / 3.0) * np.exp(-r))


def make(knobs: Sequence[Knob], start: Point, seed: int) -> GaussianProcess:
    """The search from `start` on."""
    return GaussianProcess(knobs, start, seed)
