"""How much of the variance of results each parameter decides, from drives that were made anyway."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from scipy.spatial import cKDTree

from pytest_dvp.logs.log_contents import FloatArray

Estimator: TypeAlias = Callable[[FloatArray, FloatArray], FloatArray]

NEIGHBOURS = 20
"""Drives that count as alike, beside one for each column they are alike in. With three, as Broto et al. take, shares of
an even sample are off by 0.12: drives that are near in one column of a Sobol sequence are far apart in the others, so
that their variance is too large by 1/k. With 32 a result that is bent much loses 0.14 among 128 drives."""
EXACT = 6  # parameters up to which all subsets are asked, 64 of them; beyond, those of PERMUTATIONS orders
PERMUTATIONS = 16  # seconds for eight parameters; shares of a sum of two of them are then off by less than 0.1
MOST = 600  # drives that are looked at: seconds for six parameters; more drives change a share by a percent or two
GROUPS = 10  # of a jackknife


def first_order(x: FloatArray, y: FloatArray) -> FloatArray:
    """Share (m, r) [-] of the variance of each result y (n, r; any unit) that each column of x (n, m; shares of its
    distribution [-]) explains alone, for independent columns: 0 to 1, and one below 0 is noise.

    First-order Sobol indices from given data: variance of the mean over bins of one column, less what the noise in the
    bins adds to it. Source: Plischke, Borgonovo, Smith, Global sensitivity measures from given data, European Journal
    of Operational Research 226 (2013).
    """
    n, size = x.shape
    bins = max(4, min(12, round(n**0.5 / 2)))
    found = np.zeros((size, y.shape[1]))
    for k in range(size):
        which = np.minimum((np.argsort(np.argsort(x[:, k], kind="stable")) * bins) // n, bins - 1)
        groups = [y[which == each] for each in range(bins)]
        means = np.array([group.mean(axis=0) for group in groups])
        noise = np.mean([group.var(axis=0, ddof=1) / len(group) for group in groups], axis=0)
        found[k] = (means.var(axis=0) - noise) / y.var(axis=0)
    return found


def shapley(x: FloatArray, y: FloatArray) -> FloatArray:
    """Share (m, r) [-] of the variance of each result y (n, r; any unit) that falls to each column of x (n, m; shares
    of its distribution [-]), which may depend on each other.

    Shapley effects: what a column adds to the variance explained, averaged over all orders in which columns can be
    added; what two of them explain together falls to both. They add up to 1; one below 0 is noise. The columns should
    be spread alike, as shares of a distribution are. E[Var(y | some columns)] is the variance of the drives that are
    nearest in these columns about a plane through them. On the function of Ishigami (three columns) a share is off by
    0.07 among 128 drives and by 0.03 among 512; many columns need many drives. Of more than MOST drives the first are
    looked at. Sources: Owen and Prieur, SIAM/ASA J. Uncertainty Quantification 5 (2017); Broto, Bachoc, Depecker, ibid.
    8 (2020).
    """
    x, y = x[:MOST], y[:MOST]
    size = x.shape[1]
    every = np.asarray(y.var(axis=0, ddof=1), dtype=float)
    known: dict[frozenset[int], FloatArray] = {frozenset(): every, frozenset(range(size)): np.zeros(y.shape[1])}

    def left(columns: frozenset[int]) -> FloatArray:
        """Mean variance of y among drives that are alike in these columns."""
        if columns not in known:
            known[columns] = _left_among_neighbours(x[:, sorted(columns)], y)
        return known[columns]

    found = np.zeros((size, y.shape[1]))
    if size <= EXACT:
        for k in range(size):
            others = [each for each in range(size) if each != k]
            for many in range(size):
                weight = 1.0 / (size * math.comb(size - 1, many))
                for some in map(frozenset, itertools.combinations(others, many)):
                    found[k] += weight * (left(some) - left(some | {k}))
    else:
        rng = np.random.default_rng(0)
        for _ in range(PERMUTATIONS):
            order = [int(each) for each in rng.permutation(size)]
            for place, k in enumerate(order):
                before = frozenset(order[:place])
                found[k] += (left(before) - left(before | {k})) / PERMUTATIONS
    return np.asarray(found / every, dtype=float)


def with_error(estimator: Estimator, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The shares (m, r) [-], and the standard error of each (m, r) [-], by leaving out every tenth drive (jackknife); x
    and y as the estimator takes them."""
    rows = np.arange(len(y))
    without = np.array([estimator(x[rows % GROUPS != k], y[rows % GROUPS != k]) for k in range(GROUPS)])
    spread = np.sqrt((GROUPS - 1) / GROUPS * ((without - without.mean(axis=0)) ** 2).sum(axis=0))
    return estimator(x, y), spread


def _left_among_neighbours(place: FloatArray, y: FloatArray) -> FloatArray:
    """Mean over the drives of the variance of y (n, r) about a plane through the drives nearest in place (n, m)."""
    count = min(NEIGHBOURS + place.shape[1], len(y))
    _, near = cKDTree(place).query(place, k=count)
    away = place[near] - place[:, None, :]
    plane, _ = np.linalg.qr(np.concatenate([np.ones((*away.shape[:2], 1)), away], axis=2))
    values = y[near] - y[:, None]
    on_plane = plane.transpose(0, 2, 1) @ values
    rest = (values**2).sum(axis=1) - (on_plane**2).sum(axis=1)
    return np.asarray(rest.mean(axis=0) / (count - plane.shape[2]))
