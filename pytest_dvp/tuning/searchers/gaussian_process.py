"""Bayesian optimisation with a Gaussian process over the continuous ranges of the knobs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.tuning.tuned_parameter import Knob, Point

BATCH = 4  # points asked for at once, whatever the number of cores
CANDIDATES = 1000  # points at which the acquisition is looked at, for each batch
LENGTHS = (0.1, 0.2, 0.4, 0.8)  # of the range: length scales that the marginal likelihood chooses from
IDLE = 3.2  # of the range: length of a knob that hardly matters
NOISE = 1e-4  # variance of a score beside that of all scores: a drive repeats itself, the process is only smooth
JAGGED = (NOISE, 0.01, 0.1)
"""The same of a margin that jumps a little everywhere, as where a scan comes each 0.1 s; the likelihood chooses."""
BOLD = 1.5  # standard deviations below the mean that a point is hoped to reach
NEAR = (0.01, 0.03, 0.1)  # of the range: spreads of the candidates around the best points; a narrow ridge needs all
BEST = 4  # chosen: points around which those lie: the best one alone may be the end of a wrong slope
GROWN = 1.1  # times as many scores as before, at which the lengths are chosen anew: a tenth seldom changes them
PROMISING = 0.05  # share of the space, the best by prediction, over which every second point spreads; chosen
MOST = 300  # newest points that the process is fitted to, with the best: the cost grows with their cube


class GaussianProcess:
    """Asks where the lower confidence bound of a Gaussian process is least, and with every second point of a batch
    where it knows least of the most promising part of the space. A batch takes its own predictions for scores.

    Sources: Srinivas et al., Gaussian Process Optimization in the Bandit Setting, ICML 2010 (the bound); Ginsbourger et
    al., Kriging is well-suited to parallelize optimization, 2010 (the "kriging believer" of a batch); Rasmussen and
    Williams, Gaussian Processes for Machine Learning, 2006, algorithm 2.1.
    """

    def __init__(self, knobs: Sequence[Knob], start: Point, seed: int) -> None:
        self.knobs, self._start, self._first = tuple(knobs), dict(start), True
        self._rng = np.random.default_rng(seed)
        self._at: list[list[float]] = []
        self._scores: list[float] = []
        self._lengths, self._noise, self._chosen = np.full(len(knobs), LENGTHS[1]), NOISE, 0

    def ask(self) -> list[Point]:
        """The start alone first, then even draws until there are two for each knob, then BATCH points each time."""
        if self._first:
            return [dict(self._start)]
        size = len(self.knobs)
        if len(self._scores) < 2 * size + 2:
            return [self._point(row) for row in self._rng.random((BATCH, size))]
        at, scores = self._known()
        best = at[np.argsort(scores, kind="stable")[:BEST]]
        picked: list[FloatArray] = []
        for number in range(BATCH):
            around = best[self._rng.integers(len(best), size=CANDIDATES // 2)]
            spread = np.array(NEAR)[self._rng.integers(len(NEAR), size=len(around))]
            near = np.clip(around + spread[:, None] * self._rng.normal(size=around.shape), 0.0, 1.0)
            tried = np.vstack([self._rng.random((CANDIDATES - len(near), size)), near])
            mean, deviation = predicted(at, scores, tried, self._lengths, self._noise)
            wanted = mean - BOLD * deviation
            if number % 2:  # what jumps shows no slope: where a failure is near, everything is looked at
                wanted = np.where(mean <= np.quantile(mean[: CANDIDATES - len(near)], PROMISING), -deviation, np.inf)
            k = int(np.argmin(wanted))
            picked.append(tried[k])
            at, scores = np.vstack([at, tried[k]]), np.append(scores, mean[k])
        return [self._point(row) for row in picked]

    def learn(self, points: Sequence[Point], scores: Sequence[float]) -> None:
        """Scores of earlier points, which spare it the even draws."""
        self.tell(points, scores)

    def tell(self, points: Sequence[Point], scores: Sequence[float]) -> None:
        """Scores of the batch, smaller is better."""
        self._first = False
        self._at += [[knob.share(point[knob.name]) for knob in self.knobs] for point in points]
        self._scores += scores
        if len(self._scores) > max(1.0, GROWN * self._chosen):
            self._chosen = len(self._scores)
            at, known = self._known()
            self._lengths, self._noise = chosen_lengths(at, known, self._lengths)

    def _known(self) -> tuple[FloatArray, FloatArray]:
        scores = np.array(self._scores)
        kept = sorted({*range(len(scores))[-MOST:], *np.argsort(scores, kind="stable")[:20].tolist()})
        return np.array(self._at)[kept], scores[kept]

    def _point(self, shares: FloatArray) -> Point:
        return {knob.name: knob.at(float(share)) for knob, share in zip(self.knobs, shares, strict=True)}


def predicted(
    at: FloatArray, scores: FloatArray, tried: FloatArray, length: float | FloatArray, noise: float = NOISE
) -> tuple[FloatArray, FloatArray]:
    """Mean (m,) and standard deviation (m,) in units of the scores at `tried` (m, d), after scores (n,) at `at` (n, d)
    in shares of the ranges; one length or (d,) lengths."""
    from scipy.linalg import cho_factor, cho_solve

    centre, scale = scores.mean(), max(float(scores.std()), 1e-12)
    factor = cho_factor(_covariance(at, at, length) + noise * np.eye(len(at)), lower=True)
    between = _covariance(tried, at, length)
    mean = between @ cho_solve(factor, (scores - centre) / scale)
    variance = 1.0 - np.einsum("ij,ji->i", between, cho_solve(factor, between.T))
    return centre + scale * mean, scale * np.sqrt(np.maximum(variance, 0.0))


def chosen_length(at: FloatArray, scores: FloatArray) -> float:
    """Of LENGTHS the one with the greatest marginal likelihood of scores (n,) at (n, d) shares of the ranges; units of
    the scores do not matter."""
    y = (scores - scores.mean()) / max(float(scores.std()), 1e-12)
    return LENGTHS[int(np.argmax([_likelihood(at, y, length) for length in LENGTHS]))]


def chosen_lengths(at: FloatArray, scores: FloatArray, lengths: FloatArray) -> tuple[FloatArray, float]:
    """A length (d,) [share of the range] for each knob, of LENGTHS or IDLE, and a noise of JAGGED: from `lengths` on,
    one knob after the other, whatever makes the scores more likely. Knobs that do not matter then cost no drives."""
    y = (scores - scores.mean()) / max(float(scores.std()), 1e-12)
    common = [np.full(len(lengths), length) for length in (*LENGTHS, IDLE)]
    found, noise = max(
        ((each, noise) for each in (*common, lengths.copy()) for noise in JAGGED),
        key=lambda tried: _likelihood(at, y, tried[0], tried[1]),
    )
    for k in range(len(found)):
        tries = [np.where(np.arange(len(found)) == k, length, found) for length in (*LENGTHS, IDLE)]
        found = tries[int(np.argmax([_likelihood(at, y, each, noise) for each in tries]))]
    return found, noise


def _likelihood(at: FloatArray, y: FloatArray, length: float | FloatArray, noise: float = NOISE) -> float:
    from scipy.linalg import cho_factor, cho_solve

    factor = cho_factor(_covariance(at, at, length) + noise * np.eye(len(at)), lower=True)
    return -0.5 * float(y @ cho_solve(factor, y)) - float(np.log(np.diag(factor[0])).sum())


def _covariance(one: FloatArray, other: FloatArray, length: float | FloatArray) -> FloatArray:
    """Matern 5/2: rough enough for a margin that bends where another road user becomes the tightest."""
    a, b = one / length, other / length
    squared = (a * a).sum(axis=1)[:, None] + (b * b).sum(axis=1)[None, :] - 2.0 * a @ b.T
    r = np.sqrt(5.0 * np.maximum(squared, 0.0))
    return np.asarray((1.0 + r + r * r / 3.0) * np.exp(-r))


def make(knobs: Sequence[Knob], start: Point, seed: int) -> GaussianProcess:
    """The search from `start` on."""
    return GaussianProcess(knobs, start, seed)
