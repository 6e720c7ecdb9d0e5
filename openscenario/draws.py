"""Values of stochastic distributions: a share of the probability, 0 < u < 1, becomes a value (inverse transform).

A draw is made from (seed, parameter, number of the case), not from a generator that runs on: case 700 is known without
cases 0 to 699, and what one parameter gets does not depend on which others are varied. Nothing here depends on the
versions of Python or numpy.
"""

from __future__ import annotations

import bisect
import hashlib
import itertools
import math
from collections.abc import Callable, Sequence
from statistics import NormalDist
from typing import Final, TypeAlias

from openscenario.model.distributions import (
    Histogram,
    LogNormalDistribution,
    NormalDistribution,
    PoissonDistribution,
    ProbabilityDistributionSet,
    StochasticDistributionType,
    UniformDistribution,
    UserDefinedDistribution,
)
from openscenario.model.traffic import Range

Inverse: TypeAlias = Callable[[float], float | str]

_NORMAL: Final = NormalDist()
_REACH: Final = (
    40.0  # standard deviations of a Poisson distribution that its table covers; beyond lies less than 1e-300
)
_LARGEST_EXPONENT: Final = 700.0  # exp of more overflows


class NothingToDraw(ValueError):
    """The distribution has no value of positive probability, or none that a number can hold."""


def share(seed: float, name: str, case: int) -> float:
    """A number evenly distributed between 0 and 1, both excluded, by seed, parameter and 0-based case."""
    digest = hashlib.blake2b(f"{float(seed)!r}|{case}|{name}".encode("utf-8", "surrogatepass"), digest_size=8).digest()
    return ((int.from_bytes(digest, "big") >> 11) + 0.5) / 2**53


def inverse(distribution: StochasticDistributionType) -> Inverse:
    """The function from a share of the probability to the value.

    Raises:
        NothingToDraw: no weight at all, a range without probability, a distribution of the user's own.
    """
    match distribution:
        case UniformDistribution(range=whole):
            return lambda u: _within(whole, u)
        case NormalDistribution(expected_value=mean, variance=variance, range=limits):
            low, high = _ends(limits)
            return _normal(mean, math.sqrt(variance), low, high)
        case LogNormalDistribution(range=limits):
            return _log_normal(distribution)
        case PoissonDistribution(expected_value=rate, range=limits):
            return _poisson(rate, *_ends(limits))
        case ProbabilityDistributionSet(elements=elements):
            pick = _pick([element.weight for element in elements])
            return lambda u: elements[pick(u)[0]].value
        case Histogram(bins=bins):
            choose = _pick([each.weight for each in bins])

            def value(u: float) -> float:
                number, rest = choose(u)
                return _within(bins[number].range, rest)

            return value
        case UserDefinedDistribution(type=name):
            raise NothingToDraw(f"a distribution of the user's own: {name[:60]}")


def _within(limits: Range, share: float) -> float:
    return min(limits.lower_limit + share * (limits.upper_limit - limits.lower_limit), limits.upper_limit)


def _ends(limits: Range | None) -> tuple[float, float]:
    return (-math.inf, math.inf) if limits is None else (limits.lower_limit, limits.upper_limit)


def _normal(mean: float, deviation: float, low: float, high: float) -> Callable[[float], float]:
    """The normal distribution cut to [low, high]."""
    if deviation == 0.0:
        if not low <= mean <= high:
            raise NothingToDraw("the range excludes the only value")
        return lambda u: mean
    below, above = (low - mean) / deviation, (high - mean) / deviation
    sign = 1.0
    if below > 0.0:  # the upper tail, mirrored: near 1 the shares lie too close together to be told apart
        below, above, sign = -above, -below, -1.0
    start, end = _below(below), _below(above)
    if not end - start > 0.0:
        raise NothingToDraw("the range has no probability")

    def value(u: float) -> float:
        quantile = start + (u if sign > 0.0 else 1.0 - u) * (end - start)
        if not 0.0 < quantile < 1.0:
            quantile = min(max(quantile, 5e-324), 1.0 - 2**-53)
        return min(max(mean + sign * deviation * _NORMAL.inv_cdf(quantile), low), high)

    return value


def _below(z: float) -> float:
    return 0.5 * math.erfc(-z / math.sqrt(2.0))


def _log_normal(distribution: LogNormalDistribution) -> Callable[[float], float]:
    mean = distribution.expected_value
    squared = math.log1p(distribution.variance / mean / mean)
    if not math.isfinite(squared):
        raise NothingToDraw("the variance is too large for the expected value")
    low, high = _ends(distribution.range)
    if high <= 0.0:
        raise NothingToDraw("the range has no probability: a log-normal value is positive")
    floor = math.log(low) if low > 0.0 else -math.inf
    ceiling = math.log(high) if math.isfinite(high) else math.inf
    exponent = _normal(math.log(mean) - squared / 2.0, math.sqrt(squared), floor, ceiling)
    return lambda u: min(max(math.exp(min(exponent(u), _LARGEST_EXPONENT)), low), high)


def _poisson(rate: float, low: float, high: float) -> Callable[[float], float]:
    """Whole numbers, by a table of their probabilities around the expected value."""
    if rate == 0.0:
        first = last = 0
    else:
        reach = _REACH * (math.sqrt(rate) + 1.0)
        first, last = max(0, math.floor(rate - reach)), math.ceil(rate + reach)
    first = max(first, math.ceil(max(low, -1.0)))
    last = min(last, math.floor(min(high, 1e9)))
    if first > last:
        raise NothingToDraw("the range has no probability")
    weights = [
        1.0 if rate == 0.0 else math.exp(k * math.log(rate) - rate - math.lgamma(k + 1)) for k in range(first, last + 1)
    ]
    pick = _pick(weights)
    return lambda u: float(first + pick(u)[0])


def _pick(weights: Sequence[float]) -> Callable[[float], tuple[int, float]]:
    """The function from a share to the number of what it falls on and the share within it."""
    sums = list(itertools.accumulate(weights))
    if not sums or not sums[-1] > 0.0:
        raise NothingToDraw("all weights are 0")
    last = max(number for number, weight in enumerate(weights) if weight > 0.0)

    def pick(u: float) -> tuple[int, float]:
        goal = u * sums[-1]
        number = min(bisect.bisect_right(sums, goal), last)
        start = sums[number - 1] if number else 0.0
        return number, min(max((goal - start) / weights[number], 0.0), 1.0)

    return pick
