"""The probability of a rare failure: levels lead to it, then independent weighted draws measure it.

First, subset simulation in the space of standard normal variables: of each level the worst tenth is kept and walked on,
until enough drives fail. It shows where failures lie. A mixture of Student distributions is fitted to them, and what is
reported comes from independent draws of that mixture alone, with their likelihood ratios: subset simulation's own
estimate is one product of dependent shares, whose spread cannot be told honestly from a single pass.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.campaigns.failure_probability import Probability, weighted
from pytest_dvp.logs.log_contents import FloatArray

Judge: TypeAlias = Callable[[FloatArray], FloatArray]
"""Objectives (n,) of points (n, d) in the unit cube, without unit: < 0 fails; NaN is undecided."""

SHARE = 0.1  # of a level that leads to the next one; Au and Beck's choice, near the best for any problem
WALK = 0.8  # correlation of a step with where it begins; adapted to an acceptance of 0.44 (Papaioannou et al.)
MOST_LEVELS = 12  # 10^-12 is the least probability that can be reached
DEFENSIVE = 0.1
"""Share of the final draws from the declared distribution itself: no weight exceeds 1/DEFENSIVE, so that a region of
failures that the levels have missed still counts, and the spread stays finite. Source: Hesterberg, Weighted Average
Importance Sampling and Defensive Mixture Distributions, Technometrics 37 (1995)."""
FREEDOM = 4.0
"""Degrees of freedom of the Student distributions that are drawn from: their tails lie above those of what is sought in
every direction, as a normal distribution fitted to few points does not."""
PRIOR = 2.0
"""Effective points, for each variable, that count for a spread of 1 in the fit of a covariance: a direction along which
the failures are not bounded keeps its declared spread, which few points, copies in a chain, show too small."""
REFITS, REFIT = 2, 0.1  # rounds of weighted draws to which the mixture is fitted again; share of the budget of each
LEADING = 0.3  # share of the budget for the levels
ELSEWHERE = 0.15  # share of the budget to look for failures in other directions than those found
COMMON = 0.25  # share of what was found that lies within APART of a point of a region that counts as found
APART = 0.5  # cosine of the angle to what was found, below which a direction is another one
COMPONENTS = 4  # most distributions of the mixture; the criterion of Schwarz chooses how many


@dataclasses.dataclass(frozen=True)
class Mixture:
    """Student distributions with FREEDOM: weights (k,), means (k, d), and Cholesky factors (k, d, d) of their
    covariances' scale, all in standard deviations."""

    weights: FloatArray
    means: FloatArray
    factors: FloatArray

    def draw(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Points (count, d), in units of standard deviations."""
        which = rng.choice(len(self.weights), count, p=self.weights)
        noise = rng.standard_normal((count, self.means.shape[1]))
        noise = noise / np.sqrt(rng.chisquare(FREEDOM, count) / FREEDOM)[:, None]
        spread: FloatArray = np.einsum("nij,nj->ni", self.factors[which], noise)
        return np.asarray(self.means[which] + spread)

    def log_densities(self, points: FloatArray) -> FloatArray:
        """Logarithms (n, k) of weight times density at points (n, d), in units of standard deviations."""
        from scipy.linalg import solve_triangular
        from scipy.special import gammaln

        size = points.shape[1]
        found = np.empty((len(points), len(self.weights)))
        constant = float(gammaln(0.5 * (FREEDOM + size)) - gammaln(0.5 * FREEDOM))
        constant -= 0.5 * size * math.log(FREEDOM * math.pi)
        for k, (weight, mean, factor) in enumerate(zip(self.weights, self.means, self.factors, strict=True)):
            z = solve_triangular(factor, (points - mean).T, lower=True)
            kernel = -0.5 * (FREEDOM + size) * np.log1p((z**2).sum(axis=0) / FREEDOM)
            found[:, k] = math.log(max(weight, 1e-300)) + kernel - np.log(np.diag(factor)).sum()
        return np.asarray(found + constant)


def rare_probability(judge: Judge, size: int, budget: int, seed: int) -> Probability:
    """The probability that the objective is below 0, for `size` independent shares, with about `budget` drives.

    LEADING of them lead to the failures, REFITS rounds correct the mixture, the rest is measured with; only that counts
    for the estimate. Same seed, same points asked for.
    """
    from scipy.stats import norm

    rng = np.random.default_rng(seed)
    level = max(round(LEADING * budget / 4), 10)
    at = rng.standard_normal((level, size))
    start = at, _decided(judge(np.asarray(norm.cdf(at))))
    found = _levels(judge, start, level, round(LEADING * budget) - level, rng)
    spent = level + found.spent
    at, values = found.at, found.values
    order = np.argsort(values, kind="stable")
    # Where no level reached a failure, what came nearest leads; the defensive share keeps the answer honest.
    kept = order[: max(int((values < 0.0).sum()), level // 10, size + 2)]
    # The points of a chain together are about as good as its head alone.
    points, weights = at[kept], np.full(len(kept), max(SHARE * level, 2.0) / len(kept))
    other, more = _elsewhere(
        judge, found, at[kept], max(float(values[kept].max()), 0.0), round(ELSEWHERE * budget), rng
    )
    spent += more
    if len(other):
        points = np.vstack([points, other])
        weights = np.concatenate([weights, np.full(len(other), max(SHARE * level, 2.0) / len(other))])
    mixture = fitted(points, weights, rng)

    def drawn(count: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        plain = rng.random(count) < DEFENSIVE
        at = np.where(plain[:, None], rng.standard_normal((count, size)), mixture.draw(count, rng))
        return at, _ratio(at, mixture), judge(np.asarray(norm.cdf(at)))

    for turn in range(REFITS):
        count = max(round(REFIT * budget), 10)
        if turn == 0:
            at, ratio = _all_directions(points, mixture, count, rng)
            objectives = judge(np.asarray(norm.cdf(at)))
        else:
            at, ratio, objectives = drawn(count)
        spent += len(at)
        hit = objectives < 0.0
        if hit.sum() > 1:
            share = ratio[hit] / ratio[hit].sum()
            effective = 1.0 / float((share**2).sum())
            points, weights = np.vstack([points, at[hit]]), np.concatenate([weights, share * effective])
            mixture = fitted(points, weights, rng)
    at, ratio, objectives = drawn(max(budget - spent, budget // 3, 10))
    undecided = np.isnan(objectives)
    return weighted(
        ratio, (~undecided & (objectives < 0.0)).astype(float), undecided.astype(float), spent + len(at),
        "subset simulation and independent weighted draws",
    )  # fmt: skip


def _all_directions(
    failed: FloatArray, mixture: Mixture, count: int, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Draws (n, d) and their likelihood ratios (n,): half of the mixture, half in all directions as far out as the
    points `failed` (n, d) [standard deviations]. The levels lose a region of failures by chance, as a lineage dies out;
    another one of about its probability lies about as far out. Source: Harbitz, Structural Safety 3 (1986)."""
    from scipy.special import gammaln, logsumexp
    from scipy.stats import norm

    size = failed.shape[1]
    radii = np.sqrt((failed**2).sum(axis=1))
    middle, spread = float(radii.mean()), max(float(radii.std()), 0.3)
    directions = rng.standard_normal((count, size))
    directions /= np.sqrt((directions**2).sum(axis=1))[:, None]
    shell = np.abs(rng.normal(middle, spread, count))[:, None] * directions
    at = np.where((np.arange(count) % 2 == 0)[:, None], shell, mixture.draw(count, rng))
    r = np.maximum(np.sqrt((at**2).sum(axis=1)), 1e-9)
    surface = math.log(2.0) + 0.5 * size * math.log(math.pi) - float(gammaln(0.5 * size)) + (size - 1) * np.log(r)
    radial = np.logaddexp(norm.logpdf(r, middle, spread), norm.logpdf(-r, middle, spread)) - surface
    both = np.logaddexp(radial, logsumexp(mixture.log_densities(at), axis=1)) - math.log(2.0)
    return at, np.exp(norm.logpdf(at).sum(axis=1) - both)


def _ratio(points: FloatArray, mixture: Mixture) -> FloatArray:
    """Likelihood ratios (n,), without unit, of points (n, d) in standard deviations that are drawn from the declared
    distribution with DEFENSIVE probability, else from the mixture."""
    from scipy.special import logsumexp
    from scipy.stats import norm

    declared = norm.logpdf(points).sum(axis=1)
    shaped = logsumexp(mixture.log_densities(points), axis=1)
    both = np.logaddexp(math.log(DEFENSIVE) + declared, math.log(1.0 - DEFENSIVE) + shaped)
    return np.asarray(np.exp(declared - both))


@dataclasses.dataclass(frozen=True)
class _Reached:
    """Points (n, d) in standard deviations and objectives (n,) without unit of the last level; the same of all that
    was driven; and how many drives that took."""

    at: FloatArray
    values: FloatArray
    all_at: FloatArray
    all_values: FloatArray
    spent: int


def _levels(
    judge: Judge, start: tuple[FloatArray, FloatArray], level: int, budget: int, rng: np.random.Generator
) -> _Reached:
    """From the first level `start`, points (n, d) and their objectives (n,), to the failures.

    Source: Au and Beck, Probabilistic Engineering Mechanics 16 (2001); the walk is Papaioannou, Betz, Zwirglmaier,
    Straub, MCMC algorithms for subset simulation, same journal 41 (2015), section 4.
    """
    from scipy.stats import norm

    at, values = start
    all_at, all_values = [at], [values]
    spent, walk = 0, WALK
    for _ in range(MOST_LEVELS):
        if (values < 0.0).mean() >= 2.0 * SHARE or spent + level > budget or not np.isfinite(values).any():
            break
        order = np.argsort(values, kind="stable")[: max(round(SHARE * level), 2)]
        threshold = max(float(values[order[-1]]), 0.0)
        heads, head_values = at[order], values[order]
        chains, chain_values = [heads], [head_values]
        for _ in range(math.ceil(level / len(order)) - 1):
            steps = walk * heads + math.sqrt(1.0 - walk * walk) * rng.standard_normal(heads.shape)
            tried = _decided(judge(np.asarray(norm.cdf(steps))))
            spent += len(steps)
            all_at.append(steps)
            all_values.append(tried)
            taken = tried <= threshold
            heads = np.where(taken[:, None], steps, heads)
            head_values = np.where(taken, tried, head_values)
            chains.append(heads)
            chain_values.append(head_values)
            spread = math.sqrt(1.0 - walk * walk) * math.exp(0.5 * (float(taken.mean()) - 0.44))
            walk = math.sqrt(1.0 - min(spread, 0.99) ** 2)
        at, values = np.vstack(chains), np.concatenate(chain_values)
    return _Reached(at, values, np.vstack(all_at), np.concatenate(all_values), spent)


def _elsewhere(
    judge: Judge, found: _Reached, known: FloatArray, near: float, budget: int, rng: np.random.Generator
) -> tuple[FloatArray, int]:
    """Points (m, d) in standard deviations that lie in other directions than the `known` ones (n, d) and come as near
    to a failure, with an objective of at most `near`; and the drives that it took to look for them.

    The levels are walked once more, from all that was driven, with what lies within APART of a known point forbidden:
    of two regions of failures, one dies out in the levels by chance, as a lineage does.
    """
    from scipy.stats import norm

    towards = known / np.maximum(np.sqrt((known**2).sum(axis=1)), 1e-9)[:, None]
    # A lineage of which little is left does not count as found: its region is looked for anew.
    common = (towards @ towards.T > APART).mean(axis=1) >= COMMON
    towards = towards[common] if common.any() else towards

    def beside(at: FloatArray) -> NDArray[np.bool_]:
        lengths = np.maximum(np.sqrt((at**2).sum(axis=1)), 1e-9)
        return np.asarray((at @ towards.T).max(axis=1) < APART * lengths)

    def barred(u: FloatArray) -> FloatArray:
        values = judge(u)
        return np.where(beside(np.asarray(norm.ppf(u))), values, np.inf)

    level = max(budget // 4, 10)
    values = np.where(beside(found.all_at), found.all_values, np.inf)
    first = np.argsort(values, kind="stable")[:level]
    reached = _levels(barred, (found.all_at[first], values[first]), level, budget, rng)
    alike = reached.values <= near
    return reached.at[alike], reached.spent


def _decided(values: FloatArray) -> FloatArray:
    """Undecided drives lead nowhere."""
    return np.where(np.isnan(values), np.inf, values)


def fitted(points: FloatArray, weights: FloatArray, rng: np.random.Generator) -> Mixture:
    """The mixture for points (n, d) in standard deviations with weights (n,), which sum to the number of effective
    points, without unit: as many components as Schwarz's criterion finds worth their parameters."""
    size, total = points.shape[1], float(weights.sum())
    best: tuple[float, Mixture] | None = None
    for count in range(1, COMPONENTS + 1):
        if count > 1 and total < 2.0 * count * (size + 1):
            break
        mixture, likelihood = _expectation_maximisation(points, weights, count, rng)
        free = count * (1 + size + size * (size + 1) / 2) - 1
        criterion = free * math.log(max(total, 2.0)) - 2.0 * likelihood
        if best is None or criterion < best[0]:
            best = criterion, mixture
    assert best is not None
    return best[1]


def _expectation_maximisation(
    points: FloatArray, weights: FloatArray, count: int, rng: np.random.Generator
) -> tuple[Mixture, float]:
    """Source: Dempster, Laird, Rubin, J. Royal Statistical Society B 39 (1977), with Student densities for the shares
    and the prior of PRIOR on the covariances."""
    from scipy.special import logsumexp

    n, size = points.shape
    centres = [points[int(rng.choice(n, p=weights / weights.sum()))]]
    while len(centres) < count:  # far from one another
        near = np.min([((points - centre) ** 2).sum(axis=1) for centre in centres], axis=0)
        centres.append(points[int(np.argmax(near * weights))])
    distance = np.stack([((points - centre) ** 2).sum(axis=1) for centre in centres], axis=1)
    share = np.eye(count)[np.argmin(distance, axis=1)]
    likelihood = -math.inf
    mixture = Mixture(np.ones(1), points[:1], np.eye(size)[None])
    prior = PRIOR * size
    for _ in range(30):
        owned = share * weights[:, None]
        sums = np.maximum(owned.sum(axis=0), 1e-9)
        means = owned.T @ points / sums[:, None]
        factors = []
        for k in range(count):
            off = points - means[k]
            scatter = (owned[:, k, None] * off).T @ off + prior * np.eye(size)
            factors.append(np.linalg.cholesky(scatter / (sums[k] + prior)))
        mixture = Mixture(sums / sums.sum(), means, np.array(factors))
        densities = mixture.log_densities(points)
        total = logsumexp(densities, axis=1)
        share = np.exp(densities - total[:, None])
        before, likelihood = likelihood, float((weights * total).sum())
        if likelihood - before < 1e-4 * abs(likelihood):
            break
    return mixture, likelihood
