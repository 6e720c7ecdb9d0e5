"""The search for the effects that a model lacks: try all, fit the best few, add one, look again.

Greedy choice is repaired afterwards: what no longer pays is dropped, and each effect must stand against every other one
in its place. What does nearly as well in its place is its rival.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from math import isinf

import numpy as np

from pytest_dvp.log import FloatArray
from pytest_dvp.reality_gap.algebra import along, distance, orthonormal, square
from pytest_dvp.reality_gap.candidates import Candidate, least
from pytest_dvp.reality_gap.experiment import Campaign, Values
from pytest_dvp.reality_gap.fit import Coordinate, Fit, fit, intervals

MOST = 6  # effects added to one model
PRACTICAL = 0.05  # of max(1, chi^2/N): a gain below it is not worth an effect
SURE = 0.95  # share of bootstrap samples in which an effect must gain
CLEAR = 20.0  # times PRACTICAL: a gain that needs no bootstrap, for effects that show in a single event
RIVAL = 0.02  # of max(1, chi^2/N): a gap below it tells nothing
_REFITTED = 6  # candidates of a round that are fitted, the best of the grid
_VAGUE = 0.33  # of a limit's range: an interval wider than that says nothing
_CLEAR_OF_NEUTRAL = 1.5  # half-widths of the 95 % interval
_DRAWS = 400
_SEED = 7

Tick = Callable[[str], None]


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Trial:
    """A set of effects, fitted jointly. values: all that make the model what it is, fitted or not; rest (m,): sum of
    squares by segment."""

    names: tuple[str, ...]
    values: dict[tuple[str, str], float]
    found: Fit
    rest: FloatArray

    @property
    def chi2(self) -> float:
        """Sum of squares."""
        return self.found.chi2


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Found:
    """Result of a search: the final set, rivals of each of its effects (best first), and effects of which not even the
    strongest would have shown."""

    final: Trial
    rivals: dict[str, tuple[str, ...]]
    not_excited: tuple[str, ...]


class Search:
    """One search. nuisance: coordinates that are fitted along with every set, from `start` on (the model's input map);
    fixed: values of what is not searched."""

    def __init__(self, target: Campaign, tried: Sequence[Candidate], *, nuisance: Sequence[Coordinate] = (),
                 start: Values | None = None, fixed: Values | None = None, tick: Tick = lambda text: None,
                 ) -> None:  # fmt: skip
        self.target, self.tick = target, tick
        self.tried = {c.name: c for c in tried}
        self.nuisance, self.start, self.fixed = tuple(nuisance), dict(start or {}), dict(fixed or {})
        self.count = max(target.count, 1)
        self.starts = target.starts()
        self._not_excited: tuple[str, ...] = ()
        self._scans: dict[frozenset[str], list[tuple[float, str, dict[tuple[str, str], float]]]] = {}

    def run(self) -> Found:
        """Search until nothing pays any more."""
        base = self.trial((), self.start)
        best = base
        while len(best.names) < MOST:
            self.tick(f"effect {len(best.names) + 1}: trying {len(self.tried)}")
            better = self._next(best)
            if better is None:
                break
            best = better
            self.target.settle(best.values)
            best = self.trial(best.names, best.values, zoom=True)
        best, rivals = self._contest(best)
        return Found(best, rivals, self._not_excited)

    def pays(self, without: Trial, with_it: Trial, *, count: int = 0) -> bool:
        """True if the step to the other set is worth an effect: in size, and in nearly every draw of segments."""
        count = count or self.count
        gain = (without.chi2 - with_it.chi2) / count
        worth = PRACTICAL * max(1.0, with_it.chi2 / count)
        if gain < worth:
            return False
        return gain > CLEAR * worth or self.sure(without.rest, with_it.rest) >= SURE

    def sure(self, worse: FloatArray, better: FloatArray) -> float:
        """Share of draws of segments, with replacement, in which `better` is better."""
        rng = np.random.default_rng(_SEED)
        m = len(worse)
        draws = rng.multinomial(m, np.full(m, 1.0 / m), size=_DRAWS)
        return float(np.mean(draws @ (worse - better) > 0.0))

    def trial(
        self, names: Sequence[str], start: Values, *, zoom: bool = False, target: Campaign | None = None
    ) -> Trial:
        """A set of effects fitted jointly from `start` on, to the search's own data or to others.

        What `start` says of the car itself ("parameters") is kept as it is.
        """
        target = target or self.target
        coordinates = [*self.nuisance, *(c for name in names for c in self.tried[name].coordinates)]
        enough = 2e-4 * target.count
        fixed = self.fixed | {name: value for name, value in start.items() if name[0] == "parameters"}
        found = fit(target, coordinates, start, fixed=fixed, enough=enough, zoom=zoom)
        return Trial(tuple(names), fixed | found.values, found, target.by_segment(found.residual))

    def _next(self, now: Trial) -> Trial | None:
        """The set with one more effect, None if none pays."""
        for trial in self._best_additions(now, _REFITTED):
            if self.pays(now, trial) and self._sound(trial, trial.names[-1]):
                return trial
        return None

    def _best_additions(self, now: Trial, count: int, without: frozenset[str] = frozenset()) -> list[Trial]:
        """Sets with one more effect, jointly fitted, best first."""
        scanned = self._scan(now, without)[:count]
        trials = [self.trial((*now.names, name), now.values | point) for _, name, point in scanned]
        return sorted(trials, key=lambda t: t.chi2)

    def _scan(self, now: Trial, without: frozenset[str]) -> list[tuple[float, str, dict[tuple[str, str], float]]]:
        """chi^2 that each effect would leave (the others adapt to first order), and the point where; best first."""
        known = self._scans.get(frozenset(now.names))
        if known is not None:
            return [entry for entry in known if entry[1] not in without]
        r0, values = now.found.residual, now.values
        basis = orthonormal(now.found.jacobian)
        shown: dict[str, float] = {}
        ranking = []
        for name, candidate in self.tried.items():
            if name in now.names:
                continue
            best: tuple[float, dict[tuple[str, str], float]] | None = None
            for point in candidate.points:
                r = self.target.whitened(values | point)
                change = distance(r, r0) / self.count
                shown[name] = max(shown.get(name, 0.0), change)
                if change < 1e-7:
                    break  # the strongest comes first
                left = square(r) - square(along(basis, r))
                if best is None or left < best[0]:
                    best = left, point
            if best is not None:
                ranking.append((best[0], name, best[1]))
        if not now.names:
            self._not_excited = tuple(sorted(n for n, change in shown.items() if change < PRACTICAL))
        ranking.sort(key=lambda entry: (entry[0], entry[1]))
        self._scans[frozenset(now.names)] = ranking
        return [entry for entry in ranking if entry[1] not in without]

    def _sound(self, trial: Trial, name: str) -> bool:
        """True if the effect's values mean something: above the least size, certain, and not where the search ended."""
        mine = [c for c in trial.found.coordinates if c.effect == name]
        if any(c.edge(trial.values[c.name]) for c in mine):
            return False
        sure = intervals(trial.found, self.starts)
        return any(least(c.key, trial.values[c.name]) and _certain(c, trial.values[c.name], sure[c.name]) for c in mine)

    def _contest(self, best: Trial) -> tuple[Trial, dict[str, tuple[str, ...]]]:
        """Drop what no longer pays, exchange what another effect does better, and list what does nearly as well."""
        rivals: dict[str, tuple[str, ...]] = {}
        for _ in range(3):
            best = self._pruned(best)
            rivals, exchanged = {}, None
            for name in best.names:
                self.tick(f"rivals of {name}")
                rest = tuple(n for n in best.names if n != name)
                kept = {k: v for k, v in best.values.items() if k[0] != name}
                without = self.trial(rest, kept)
                trials = [t for t in self._best_additions(without, _REFITTED, frozenset({name}))
                          if self._sound(t, t.names[-1])]  # fmt: skip
                if trials and trials[0].chi2 < best.chi2 - 1e-3 * self.count:
                    exchanged = trials[0]
                    break
                rivals[name] = tuple(t.names[-1] for t in trials if self.alike(best, t))
            if exchanged is None:
                return best, rivals
            best = self.trial(exchanged.names, exchanged.values, zoom=True)
        return best, rivals

    def alike(self, best: Trial, other: Trial) -> bool:
        """True if these data do not tell the two sets apart."""
        gap = (other.chi2 - best.chi2) / self.count
        worth = max(1.0, best.chi2 / self.count)
        if gap < RIVAL * worth:
            return True
        return gap < PRACTICAL * worth and self.sure(other.rest, best.rest) < SURE

    def _pruned(self, best: Trial) -> Trial:
        while len(best.names) > 1:
            smaller = []
            for name in best.names:
                rest = tuple(n for n in best.names if n != name)
                kept = {k: v for k, v in best.values.items() if k[0] != name}
                smaller.append(self.trial(rest, kept))
            least_lost = min(smaller, key=lambda t: t.chi2)
            if self.pays(least_lost, best):
                return best
            best = least_lost
        return best


def _certain(c: Coordinate, value: float, interval: tuple[float, float]) -> bool:
    """True if the interval is clear of the neutral value, for a limit if it is no wider than a third of its range."""
    low, high = interval
    if isinf(c.key.neutral):
        return c.place(high) - c.place(low) < _VAGUE
    return abs(value - c.key.neutral) > _CLEAR_OF_NEUTRAL * 0.5 * (high - low)
