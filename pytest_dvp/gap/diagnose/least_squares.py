"""Least squares over the parameters of effects, and the 95 % intervals of their values.

Levenberg-Marquardt on simulation error, then a zoom by coordinate.

Many effects are not smooth in their parameter (dead band, play, delay), so every derivative is a finite difference over
a step that matters, and the end is looked at point by point.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping, Sequence
from math import exp, inf, isfinite, log
from typing import TypeAlias

import numpy as np

from pytest_dvp.gap.compare.start_correction import IntArray
from pytest_dvp.gap.diagnose.all_cores import mapped
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, Values
from pytest_dvp.gap.diagnose.linear_algebra import broyden_update, gram, grams_of_segments, row_products, square
from pytest_dvp.logs.log_contents import FloatArray
from vehicle.model.effect import Key

Residual: TypeAlias = Callable[[FloatArray], FloatArray]
Intervals: TypeAlias = dict[tuple[str, str], tuple[float, float]]
"""(effect, key) -> lower and upper end, in the unit of the value."""

_JUMPS = (0.25, 0.5, 0.75, 1.0)  # samples
STEP = 0.006  # of a coordinate's range, for derivatives
STEPS_OF_JUMPS = 3.0  # as long where the error jumps: over less, single samples make the slope
_BEYOND = 0.25  # of its range, how far outside a coordinate may go if the equation allows it
_LONGEST = 0.35  # of its range, in one step
_NORMAL = 2.5  # standard deviations of a 95 % interval: segments are few, and drift of the position ties neighbours;
# 1.96 held the truth in 86 % of generated logs
IMITATED = 4.3  # root mean squares of a 95 % interval: Student's t of two drives, that fitted on and that held out
_LEFT = 0.1  # chosen; least share of what is known about a value that counts as left without a segment: what shows in a
# single event would leave nothing, and its interval would have no end
_ZOOM = (0.02, 0.005, 0.0015)
_VALLEY = 0.0025  # of the range, from one valley of a rough error to the next
VALLEYS = np.arange(-0.05, 0.05 + _VALLEY / 2, _VALLEY)  # around a value, where each is looked into


@dataclasses.dataclass(frozen=True, slots=True)
class Coordinate:
    """A parameter as a number u, 0 to 1 over its typical range; by ratio where that is positive and wide.

    rough: the error has many valleys over it; jumps: it jumps where an event comes or goes; dead_time: it jumps at
    whole samples of a held command; the share of one that is never known.
    """

    effect: str
    key: Key
    rough: bool = False
    dead_time: float = 0.0
    jumps: bool = False

    @property
    def name(self) -> tuple[str, str]:
        """(effect, key)."""
        return self.effect, self.key.name

    @property
    def by_ratio(self) -> bool:
        """True if equal steps are equal ratios."""
        return self.key.low > 0.0 and self.key.high > 3.0 * self.key.low

    def value(self, u: float) -> float:
        """The parameter at u, kept within what the equation allows."""
        key = self.key
        found = key.low * exp(u * log(key.high / key.low)) if self.by_ratio else key.low + u * (key.high - key.low)
        return min(max(found, key.minimum), key.maximum)

    def to_unit(self, value: float) -> float:
        """u of a value."""
        key = self.key
        if self.by_ratio:
            return log(max(value, 1e-3 * key.low) / key.low) / log(key.high / key.low)
        return (value - key.low) / (key.high - key.low)

    @property
    def search_limits(self) -> tuple[float, float]:
        """Where the search has to stop: a little outside the typical range; where that is by ratio, at the least size
        that is worth a name if that is lower (a lag of 40 ms, where 100 to 800 are typical)."""
        key = self.key
        low, high = -_BEYOND, 1.0 + _BEYOND
        if self.by_ratio and key.neutral <= key.low:
            low = min(low, self.to_unit(key.neutral + key.least))
        return low, high

    def within(self, u: float) -> float:
        """u kept where a search may go, but never past doing nothing, nor past what the equation allows: there nothing
        moves any more, and a value that came so far would neither return nor have an interval."""
        low, high = self.search_limits
        low, high = max(low, self.to_unit(self.key.minimum)), min(high, self.to_unit(self.key.maximum))
        if not self.by_ratio and isfinite(self.key.neutral):
            if self.key.neutral <= self.key.low:
                low = max(low, self.to_unit(self.key.neutral))
            elif self.key.neutral >= self.key.high:
                high = min(high, self.to_unit(self.key.neutral))
        return min(max(u, low), high)

    def is_at_limit(self, value: float) -> bool:
        """True if the value stands where the search had to stop."""
        low, high = self.search_limits
        return not low + 1e-3 < self.to_unit(value) < high - 1e-3

    def step(self, u: float) -> float:
        """Step in u over which a derivative is taken, towards the middle of the range; see `Key.step`."""
        key = self.key
        if key.step > 0.0 and u == self.to_unit(key.neutral):
            return self.to_unit(key.neutral + key.step) - u
        size = STEPS_OF_JUMPS * STEP if self.jumps else STEP
        return size if u < 0.5 else -size

    def slope(self, u: float) -> float:
        """d value / d u, at an end of what the equation allows the one from inside."""
        up, down = self.value(u + 1e-4), self.value(u - 1e-4)
        there = self.value(u)
        return (up - down) / (1e-4 * ((up != there) + (down != there) or 1))


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Fit:
    """values of the coordinates; whitened residual (N,); chi2 its sum of squares; jacobian (p, N) by coordinate in u,
    at these values or close to them."""

    coordinates: tuple[Coordinate, ...]
    values: dict[tuple[str, str], float]
    residual: FloatArray
    chi2: float
    jacobian: FloatArray


@dataclasses.dataclass(frozen=True, slots=True)
class Stop:
    """When a fit ends.

    rounds  at most so many, six times over
    enough  a round that gains less than this in chi^2 is the last
    above   a chi^2; where the fit seems to end beyond it, it may stay rough
    """

    rounds: int = 8
    enough: float = 1.0
    above: float = inf


_STOP = Stop()


def fit(target: ExperimentSet, coordinates: Sequence[Coordinate], start: Values, *, fixed: Values | None = None,
        stop: Stop = _STOP, zoom: bool = False, known: Fit | None = None) -> Fit:  # fmt: skip
    """The values with the least whitened residual, from `start` on.

    fixed: values that stay. zoom: look closer at the end, for parameters that have no derivative. known: a fit of much
    the same, whose derivatives will do to begin with.

    Where derivatives that are corrected by what was seen on the way lead no further, half of them are taken anew,
    those first whose values have moved most; so the last round has fresh ones. With all of them taken anew each time,
    sets of 18 to 20 effects of three cars without one of them needed 15,058 motions in place of 11,319.
    """
    coordinates = tuple(coordinates)
    given = dict(fixed or {})
    u = np.array([c.to_unit(start[c.name]) for c in coordinates])

    def residual(place: FloatArray) -> FloatArray:
        return target.whitened(given | _values(coordinates, place))

    r = residual(u)
    best = square(r)
    jacobian = np.empty((len(coordinates), len(r)))
    lent = _lend(known, coordinates, jacobian)
    _derive(coordinates, jacobian, residual, r, u, [k for k in range(len(u)) if k not in lent])
    old = sorted(lent)  # coordinates whose derivatives are of another place,
    moved = np.zeros(len(u))  # and how far each has moved in this fit since
    damping = 1e-3
    for _ in range(6 * stop.rounds if coordinates else 0):
        before, place, rest = best, u, r
        u, r, best, damping = _improve(coordinates, residual, jacobian, u, r, best, damping, 4 if old else 5)
        if before - best >= stop.enough:
            broyden_update(jacobian, u - place, r - rest)
            old, moved = list(range(len(u))), moved + np.abs(u - place)
            continue
        if best > stop.above:
            break
        if old:
            old.sort(key=lambda k: -moved[k])
            taken = old[: (len(u) + 1) // 2]
            _derive(coordinates, jacobian, residual, r, u, taken)
            old, damping = old[len(taken) :], 1e-3
            moved[taken] = 0.0
            continue
        if not any(c.dead_time for c in coordinates):
            break
        u, r, best = _over_jumps(coordinates, target.sample, residual, u, r, best)
        if before - best < stop.enough:
            break
        _derive(coordinates, jacobian, residual, r, u)
        moved[:] = 0.0
    if best <= stop.above:
        there = u
        u, r, best = _into_valleys(coordinates, residual, u, r, best)
        if zoom:
            u, r, best = _zoom(coordinates, residual, u, r, best)
        if coordinates and (zoom or u is not there):
            _derive(coordinates, jacobian, residual, r, u)
    return Fit(coordinates, _values(coordinates, u), r, best, jacobian)


def intervals(
    found: Fit, starts: IntArray, exact: FloatArray | None = None
) -> dict[tuple[str, str], tuple[float, float]]:
    """95 % interval of each value, in the unit of the value.

    Clustered by segment (starts (m,) in the residual): noise within a segment may be coloured in any way; segments
    count as independent. How far the values move without one of them says how unsure they are. exact (N,): the residual
    with the model integrated in small steps; how far that would move a value is part of its uncertainty, too.
    Source: Liang and Zeger, Biometrika 73 (1986) 13, in the form of a jackknife (CR3): Bell and McCaffrey, Survey
    Methodology 28 (2002) 169. A factor m/(m - p) in its place would make 19 values of 22 segments 2.7 times as unsure.
    """
    if not found.coordinates:
        return {}
    j, r = found.jacobian, found.residual
    by_segment = grams_of_segments(j, starts)
    scores = np.add.reduceat(j * r, starts, axis=1)
    bread = np.linalg.pinv(by_segment.sum(axis=0))
    clustered = _jackknife(by_segment, scores, bread)
    plain = np.diag(bread) * (found.chi2 / max(int(np.count_nonzero(r)), 1))
    spread = np.sqrt(np.maximum(np.maximum(clustered, plain), 0.0))
    moved = bread @ row_products(j, exact - r) if exact is not None else np.zeros(len(j))
    result = {}
    for c, row, s, d in zip(found.coordinates, j, spread, moved, strict=True):
        value = found.values[c.name]
        if c.jumps and not row.any():  # no event in these data hangs on it
            low, high = c.search_limits
            result[c.name] = (min(value, c.value(low)), max(value, c.value(high)))
            continue
        width = _NORMAL * float(s) + abs(float(d)) + (_VALLEY if c.rough else STEPS_OF_JUMPS * STEP if c.jumps else 0.0)
        half = width * abs(c.slope(c.to_unit(value)))
        result[c.name] = (max(value - half, c.key.minimum), min(value + half, c.key.maximum))
    return result


def _jackknife(by_segment: FloatArray, scores: FloatArray, bread: FloatArray) -> FloatArray:
    """Variance (p,) of each coordinate u, found by leaving out one segment after the other.

    by_segment (m, p, p): scalar products of the derivatives in each segment; scores (p, m): those of the derivatives
    with the residual; bread (p, p): inverse of the products over all segments.
    """
    m = len(by_segment)
    sizes, axes = np.linalg.eigh(bread)
    root = (axes * np.sqrt(np.maximum(sizes, 0.0))) @ axes.T
    shares, turns = np.linalg.eigh(root @ by_segment @ root)  # of what is known about each direction
    left = np.maximum(1.0 - shares, _LEFT)
    along = np.einsum("mij,mi->mj", turns, (root @ scores).T) / left
    moved = root @ np.einsum("mij,mj->im", turns, along)
    return np.asarray((moved * moved).sum(axis=1) * ((m - 1) / m))


def widen_dead_times(
    target: ExperimentSet, found: Fit, values: Values, sure: Mapping[tuple[str, str], tuple[float, float]]
) -> dict[tuple[str, str], tuple[float, float]]:
    """Intervals of dead times, of which no derivative says how far they may go: their share of a sample at least, and
    as far as the error stays the same. The others as they are."""
    wide = dict(sure)
    for c in found.coordinates:
        if not c.dead_time:
            continue
        value = found.values[c.name]
        ends = []
        for side in (-1.0, 1.0):
            reach = c.dead_time * target.sample
            for share in _JUMPS:
                other = dict(values) | {c.name: max(value + side * share * target.sample, 0.0)}
                if square(target.whitened(other)) - found.chi2 > _NORMAL**2:
                    break
                reach = max(reach, share * target.sample)
            ends.append(value + side * reach)
        low, high = sure[c.name]
        wide[c.name] = (max(min(low, ends[0]), c.key.minimum), max(high, ends[1]))
    return wide


def widen_imitated(found: Fit, sure: Intervals, imitates: Mapping[str, Mapping[str, float]]) -> Intervals:
    """Intervals with what the known remainder of a twin imitates added, squares with squares.

    imitates: effect -> key -> root mean square over the drives that a twin was learnt from, in the unit of the value.
    """
    wide = {}
    for c in found.coordinates:
        value, (low, high) = found.values[c.name], sure[c.name]
        more = IMITATED * imitates.get(c.effect, {}).get(c.key.name, 0.0)
        wide[c.name] = (max(value - float(np.hypot(value - low, more)), c.key.minimum),
                        min(value + float(np.hypot(high - value, more)), c.key.maximum))  # fmt: skip
    return wide


def _over_jumps(
    coordinates: Sequence[Coordinate], sample: float, residual: Residual, u: FloatArray, r: FloatArray, best: float
) -> tuple[FloatArray, FloatArray, float]:
    """Dead times moved by parts of a sample: at whole samples the error jumps, and no derivative leads across."""
    for k, c in enumerate(coordinates):
        if not c.dead_time:
            continue
        value = c.value(float(u[k]))
        for share in (*_JUMPS, *(-one for one in _JUMPS)):
            moved = u.copy()
            moved[k] = c.within(c.to_unit(value + share * sample))
            left = residual(moved)
            chi2 = square(left)
            if chi2 < best:
                u, r, best = moved, left, chi2
    return u, r, best


def _values(coordinates: Sequence[Coordinate], u: FloatArray) -> dict[tuple[str, str], float]:
    return {c.name: c.value(float(place)) for c, place in zip(coordinates, u, strict=True)}


def _lend(known: Fit | None, coordinates: Sequence[Coordinate], jacobian: FloatArray) -> set[int]:
    """Fill rows of the jacobian (p, N) that a known fit has; which."""
    if known is None or known.jacobian.shape[1] != jacobian.shape[1]:
        return set()
    rows = {c.name: k for k, c in enumerate(known.coordinates)}
    lent = {k: rows[c.name] for k, c in enumerate(coordinates) if c.name in rows}
    for k, row in lent.items():
        jacobian[k] = known.jacobian[row]
    return set(lent)


def _derive(coordinates: Sequence[Coordinate], jacobian: FloatArray, residual: Residual, r: FloatArray, u: FloatArray,
            which: Iterable[int] | None = None) -> None:  # fmt: skip
    def row(k: int) -> None:
        step = coordinates[k].step(float(u[k]))
        moved = u.copy()
        moved[k] += step
        np.subtract(residual(moved), r, out=jacobian[k])
        jacobian[k] /= step

    mapped(row, range(len(u)) if which is None else which)


def _improve(
    coordinates: Sequence[Coordinate],
    residual: Residual,
    jacobian: FloatArray,
    u: FloatArray,
    r: FloatArray,
    best: float,
    damping: float,
    tries: int,
) -> tuple[FloatArray, FloatArray, float, float]:
    normal, slope = gram(jacobian), row_products(jacobian, r)
    scale = np.diag(normal).copy()
    scale[scale <= 0.0] = 1.0
    for _ in range(tries):
        step = -np.linalg.solve(normal + damping * np.diag(scale) + 1e-12 * np.eye(len(u)), slope)
        if not np.isfinite(step).all():
            break
        step = np.clip(step, -_LONGEST, _LONGEST)
        moved = np.array([c.within(float(place)) for c, place in zip(coordinates, u + step, strict=True)])
        left = residual(moved)
        chi2 = square(left)
        if isfinite(chi2) and chi2 < best:
            return moved, left, chi2, max(damping / 10.0, 1e-7)
        damping *= 8.0
    return u, r, best, damping


def _into_valleys(
    coordinates: Sequence[Coordinate], residual: Residual, u: FloatArray, r: FloatArray, best: float
) -> tuple[FloatArray, FloatArray, float]:
    for k in range(len(u)):
        there = u
        for offset in VALLEYS if coordinates[k].rough else ():
            moved = u.copy()
            moved[k] = coordinates[k].within(float(u[k] + offset))
            left = residual(moved)
            if square(left) < best:
                there, r, best = moved, left, square(left)
        u = there
    return u, r, best


def _zoom(
    coordinates: Sequence[Coordinate], residual: Residual, u: FloatArray, r: FloatArray, best: float
) -> tuple[FloatArray, FloatArray, float]:
    for reach in _ZOOM:
        for k in range(len(u)):
            for side in (reach, -reach):
                for _ in range(4):
                    moved = u.copy()
                    moved[k] = coordinates[k].within(float(u[k]) + side)
                    left = residual(moved)
                    chi2 = square(left)
                    if not chi2 < best:
                        break
                    u, r, best = moved, left, chi2
    return u, r, best
