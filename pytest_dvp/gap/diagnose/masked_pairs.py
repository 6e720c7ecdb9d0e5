"""Effects that hide each other: alike, of opposite sign, and in a car both at once.

A car that brakes in a bend loads its front axle, which turns it in, and its steered wheels brake across it, which turns
it out. Neither may be worth a name while the other one is missing. Effects that are alike say so of each other
(`ties`); these pairs are tried together, to first order in everything already found.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from pytest_dvp.gap.diagnose.candidates import Candidate, Point
from pytest_dvp.gap.diagnose.fitting import Fitting
from pytest_dvp.gap.diagnose.linear_algebra import orthonormal, row_products, square
from pytest_dvp.logs.log_contents import FloatArray

if TYPE_CHECKING:
    from pytest_dvp.gap.diagnose.experiment import ExperimentSet
    from pytest_dvp.gap.diagnose.trial import Trial

_FITTED = 3  # pairs, the best to first order
LARGEST = 1.25  # times the change of a point, to which a first order is followed
_ALIKE = 1e-3  # of a change, that must stand beside the other one


def masked_pair(search: Fitting, now: Trial) -> list[Trial]:
    """The best set with two more effects that hide each other, if each of them pays beside the other one; else none."""
    ranking = promising(search.target, now, tied_pairs(search.tried, now.names))
    trials = [search.trial((*now.names, *pair), now.values | point, like=now) for _, pair, point in ranking[:_FITTED]]
    for both in sorted(trials, key=search.cost):
        pair = both.names[-2:]
        alone = [search.trial([n for n in both.names if n != out], both.values, like=both) for out in pair]
        pays = all(search.is_worth_adding(less, both) for less in (now, *alone))
        if pays and all(search.is_credible(both, name) for name in pair):
            return [both]
    return []


def late_pair(search: Fitting, base: Trial) -> list[Trial]:
    """The best set of two effects of tyres in the place of none, if it pays: neither may show without the other (a tyre
    that slips late and saturates)."""
    tyres = [c for c in search.tried.values() if c.effect.tyres and not c.detail]
    middle = [c.points[len(c.points) // 2] for c in tyres]
    pairs = [
        search.trial((a.name, b.name), base.values | p | q)
        for (a, p), (b, q) in itertools.combinations(zip(tyres, middle, strict=True), 2)
    ]
    pairs = [t for t in sorted(pairs, key=search.cost)[:_FITTED] if search.is_worth_adding(base, t)]
    return [t for t in pairs if all(search.is_credible(t, name) for name in t.names)][:1]


def tied_pairs(tried: Mapping[str, Candidate], names: Sequence[str]) -> list[tuple[Candidate, Candidate]]:
    """Pairs of tyre effects outside `names`, at least one of them a detail, that are said to be alike."""
    free = [c for c in tried.values() if c.effect.tyres and c.name not in names]
    return [
        (a, b)
        for k, a in enumerate(free)
        for b in free[k + 1 :]
        if (a.detail or b.detail) and (a.name in b.effect.ties or b.name in a.effect.ties)
    ]


def promising(
    target: ExperimentSet, now: Trial, pairs: Iterable[tuple[Candidate, Candidate]]
) -> list[tuple[float, tuple[str, str], Point]]:
    """chi^2 that each pair would leave at its best points, the pair, and the points together; best first."""
    rest, basis = now.fit.residual, orthonormal(now.fit.jacobian)
    before = square(rest) - square(row_products(basis, rest))
    seen: dict[str, list[tuple[Point, FloatArray, float, float]]] = {}

    def changes(candidate: Candidate) -> list[tuple[Point, FloatArray, float, float]]:
        if candidate.name not in seen:
            found = []
            for point in candidate.coarse:
                change = target.whitened(now.values | point) - rest
                change -= row_products(basis, change) @ basis
                found.append((point, change, square(change), float(row_products(change[None, :], rest)[0])))
            seen[candidate.name] = found
        return seen[candidate.name]

    ranking = []
    for a, b in pairs:
        options = []
        for p, u, uu, ur in changes(a):
            for q, v, vv, vr in changes(b):
                uv = float(row_products(u[None, :], v)[0])
                area = uu * vv - uv * uv
                if area <= _ALIKE * uu * vv:
                    continue
                share_a, share_b = (uv * vr - vv * ur) / area, (uv * ur - uu * vr) / area
                if 0.0 < share_a <= LARGEST and 0.0 < share_b <= LARGEST:
                    left = before + share_a * ur + share_b * vr
                    options.append((left, _scaled(a, p, share_a) | _scaled(b, q, share_b)))
        if options:
            left, point = min(options, key=lambda option: option[0])
            ranking.append((left, (a.name, b.name), point))
    return sorted(ranking, key=lambda entry: entry[:2])


def _scaled(candidate: Candidate, point: Point, share: float) -> Point:
    less = candidate.weaker(point, min(share, 1.0))
    return less[0] if less else point
