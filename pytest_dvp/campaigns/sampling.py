"""Even samples of the unit cube, each a sequence whose beginning does not depend on how much of it is wanted."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

import numpy as np

from pytest_dvp.campaigns.parameter_space import Axis, Shares

SAMPLES = ("grid", "random", "sobol")
"""Names of the samples. Only `random` draws are independent, as an interval of a probability assumes."""


def sample(name: str, axes: Sequence[Axis], count: int, seed: int) -> list[Shares]:
    """`count` points; of a grid at most that many, the finest grid that fits."""
    if name == "grid":
        return list(grid(axes, count))
    if name == "sobol":
        return sobol(len(axes), count, seed)
    return [random_point(len(axes), seed, k) for k in range(count)]


def random_point(size: int, seed: int, number: int) -> Shares:
    """Point `number` of the independent draws of a seed."""
    return tuple(float(share) for share in np.random.default_rng([seed, number]).random(size))


def sobol(size: int, count: int, seed: int) -> list[Shares]:
    """The first points of a scrambled Sobol sequence.

    Source: Owen, Scrambling Sobol' and Niederreiter-Xing points, J. Complexity 14 (1998); `scipy.stats.qmc`.
    """
    from scipy.stats import qmc

    engine = qmc.Sobol(size, scramble=True, seed=np.random.default_rng(seed))
    whole = engine.random_base2(max(math.ceil(math.log2(max(count, 1))), 0))
    return [tuple(float(share) for share in row) for row in whole[:count]]


def grid(axes: Sequence[Axis], count: int) -> Iterator[Shares]:
    """Every combination of equally many values of each axis, of a list no more than it has; the ends are included, but
    of a distribution without ends, of which these are the middles of equally likely parts."""
    limits = [axis.count if axis.count is not None else count for axis in axes]
    steps = [1] * len(axes)
    while True:
        growing = [k for k in range(len(axes)) if steps[k] < limits[k]]
        fitting = [k for k in growing if math.prod(steps) // steps[k] * (steps[k] + 1) <= count]
        if not fitting:
            break
        steps[min(fitting, key=lambda k: (steps[k], k))] += 1
    yield from itertools.product(*(_values(axis, n) for axis, n in zip(axes, steps, strict=True)))


def _values(axis: Axis, steps: int) -> list[float]:
    if axis.count is not None:
        picked = np.unique(np.round(np.linspace(0, axis.count - 1, steps)))
        return [axis.middle(int(k)) for k in picked]
    if axis.endless:
        return [(k + 0.5) / steps for k in range(steps)]
    return [0.5] if steps == 1 else [float(share) for share in np.linspace(0.0, 1.0, steps)]
