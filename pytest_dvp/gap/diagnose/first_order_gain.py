"""What effects would change on top of a set that is fitted, to first order in everything already found."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from pytest_dvp.gap.diagnose.candidates import Candidate, Point, is_finer
from pytest_dvp.gap.diagnose.experiment import ExperimentSet
from pytest_dvp.gap.diagnose.least_squares import Coordinate
from pytest_dvp.gap.diagnose.linear_algebra import orthonormal, row_products, square

if TYPE_CHECKING:
    from pytest_dvp.gap.diagnose.trial import Trial


_REACHES = (0.12, 0.06, 0.03)  # of a range, by which a key is moved
HOPELESS = 0.1  # of the gain that is needed; chosen, not measured: a weak point may understate a strong one


class FirstOrderGain:
    """What effects would change on top of a set that is fitted. strongest: square of the largest that `at` saw."""

    def __init__(self, target: ExperimentSet, now: Trial) -> None:
        self._target, self._values, self._rest = target, now.values, now.fit.residual
        self._basis = orthonormal(now.fit.jacobian)
        self._shadow = row_products(self._basis, self._rest)
        self._before = square(self._rest) - square(self._shadow)
        self._nothing = 1e-7 * target.count
        self.strongest = 0.0

    def remaining_chi2(
        self, candidate: Candidate, points: Sequence[Point], needed: float = 0.0
    ) -> list[tuple[float, Point]]:
        """chi^2 left at the points (strongest first), and at one more that promises most.

        needed: a gain in chi^2; an effect that promises no more than HOPELESS of it, were it as strong as it likes, is
        looked at in its weakest point only, with each place where `ay` may be measured: a wrong one hides it.
        """
        self.strongest = 0.0
        if any(c.jumps for c in candidate.coordinates):
            return self._descended(candidate, points, needed)
        weak = [p for p in points if all(p[c.name] == points[-1][c.name] for c in candidate.coordinates)]
        if needed > 0.0 and len(points) > len(weak):
            looks = [self._step(point) for point in weak]
            if all(raw >= self._nothing and size > 0.0 and slope**2 < HOPELESS * needed * size
                   for raw, size, slope in looks):  # fmt: skip
                return [(self._before + 2.0 * slope + size, p) for (_, size, slope), p in zip(looks, weak, strict=True)]
        # Weaker points of an effect that the model has lie beyond its own values; one of a place may lie anywhere.
        fades = not candidate.own and not any(c.key.where for c in candidate.coordinates)
        options: list[tuple[float, Point]] = []
        hoped: list[tuple[float, Point]] = []
        for point in points:
            raw, size, slope = self._step(point)
            self.strongest = max(self.strongest, raw)
            if raw < self._nothing:
                if not fades:
                    continue
                if options:  # between the last point that shows and this one
                    options += self._halved(candidate, options[-1][1], point)
                break
            options.append((self._before + 2.0 * slope + size, point))
            share = -slope / size if size > 0.0 else 0.0  # of the change that would be best, were it in proportion
            if 0.0 < share < 1.0:
                hoped += [(self._before + share * slope, less) for less in candidate.weaker(point, share)]
        at_once = [c for c in candidate.coordinates if not c.key.late]
        if len(options) > 1 and len(at_once) == 1:
            options += self._beside(at_once[0], options)
        if hoped:
            less = min(hoped, key=lambda option: option[0])[1]
            options.append((self._left(less), less))
        return options

    def promising(self, candidates: Iterable[Candidate]) -> list[tuple[float, Candidate, Point]]:
        """chi^2 left with each candidate at its best coarse point, and that point; the least first. Candidates that
        change nothing anywhere are left out."""
        found = [
            (left, candidate, point)
            for candidate in candidates
            for left, point in sorted(self.remaining_chi2(candidate, candidate.coarse), key=lambda o: o[0])[:1]
        ]
        return sorted(found, key=lambda o: (o[0], o[1].name))

    def _descended(self, candidate: Candidate, points: Sequence[Point], needed: float) -> list[tuple[float, Point]]:
        """The points of a grid of an effect that comes and goes (a change of gear), and those where the best of them
        lead, each key moved in turn: a fit finds no other valley than the one that it begins in. With a gain that is
        needed, other effects are there, each look costs more, and only the best point is followed."""
        options: list[tuple[float, Point]] = []
        for point in points:
            raw, size, slope = self._step(point)
            self.strongest = max(self.strongest, raw)
            if raw >= self._nothing:
                options.append((self._before + 2.0 * slope + size, point))
        if not options:
            return []
        ways = [min(options, key=lambda option: option[0])]
        if needed <= 0.0:  # the best of each value of each key
            for c in candidate.coordinates:
                for value in dict.fromkeys(point[c.name] for point in points):
                    ways += sorted((o for o in options if o[1][c.name] == value), key=lambda option: option[0])[:1]
        for left, point in [way for k, way in enumerate(ways) if way not in ways[:k]]:
            for reach in _REACHES:
                moved = True
                while moved:
                    moved = False
                    for c in candidate.coordinates:
                        if is_finer(c.key):
                            continue
                        for side in (reach, -reach):
                            u = c.within(c.to_unit(point[c.name]) + side)
                            other = point | {c.name: c.value(u)}
                            if (found := self._left(other)) < left - self._nothing:
                                left, point, moved = found, other, True
                                break
            options.append((left, point))
        return options

    def _beside(self, c: Coordinate, options: Sequence[tuple[float, Point]]) -> list[tuple[float, Point]]:
        """Points halfway from the best one to its neighbours on the line: the valley of a limit may lie between two."""
        best = min(options, key=lambda option: option[0])[1]
        line = sorted({p[c.name] for _, p in options})
        k = line.index(best[c.name])
        near = [line[j] for j in (k - 1, k + 1) if 0 <= j < len(line)]
        middles = [best | {c.name: c.value(0.5 * (c.to_unit(best[c.name]) + c.to_unit(value)))} for value in near]
        return [(self._left(point), point) for point in middles]

    def _halved(self, candidate: Candidate, strong: Point, weak: Point) -> list[tuple[float, Point]]:
        """Points between one that shows and one that does not, halfway each time: where a limit begins to bite."""
        found: list[tuple[float, Point]] = []
        for _ in range(4):
            middle = dict(weak)
            for c in candidate.coordinates:
                middle[c.name] = c.value(0.5 * (c.to_unit(strong[c.name]) + c.to_unit(weak[c.name])))
            raw, size, slope = self._step(middle)
            if raw < self._nothing:
                weak = middle
                continue
            found.append((self._before + 2.0 * slope + size, middle))
            if found[-1][0] < self._before:
                break
            strong = middle
        return found

    def _left(self, point: Point) -> float:
        _, size, slope = self._step(point)
        return self._before + 2.0 * slope + size

    def _step(self, point: Point) -> tuple[float, float, float]:
        """Squares of the change, in all and beyond what the others can do, and its product with what is there."""
        change = self._target.whitened(self._values | point) - self._rest
        turned = row_products(self._basis, change)
        raw = square(change)
        return raw, raw - square(turned), row_products(change[None, :], self._rest)[0] - float(self._shadow @ turned)
