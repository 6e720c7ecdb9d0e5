"""The search for the effects that a model lacks: try all, fit the best few, add one, look again.

Greedy choice is repaired afterwards: what no longer pays is dropped, and each effect must stand against every other one
in its place. What does nearly as well in its place is its rival.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from copy import copy
from math import inf, isinf, sqrt
from typing import TypeAlias

import numpy as np

from pytest_dvp.gap.diagnose.accelerometer_place import placed, points_there
from pytest_dvp.gap.diagnose.all_cores import mapped
from pytest_dvp.gap.diagnose.bootstrap import bootstrap_share
from pytest_dvp.gap.diagnose.candidates import (
    Candidate,
    Point,
    has_price,
    is_certain,
    is_worth_naming,
    sizes,
    without_finer,
)
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, Values
from pytest_dvp.gap.diagnose.first_order_gain import FirstOrderGain
from pytest_dvp.gap.diagnose.least_squares import Coordinate, Stop, fit, intervals
from pytest_dvp.gap.diagnose.linear_algebra import orthonormal, row_products, square
from pytest_dvp.gap.diagnose.masked_pairs import late_pair, masked_pair
from pytest_dvp.gap.diagnose.open_values import carries
from pytest_dvp.gap.diagnose.simpler_effects import is_simpler, plainer, simplified
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.gap.diagnose.usual_car import LARGEST, USUAL, is_bare, usual_car, with_seen
from pytest_dvp.gap.diagnose.usual_values import MAX_UNRECOVERED_SHARE, usual_set
from pytest_dvp.gap.diagnose.whole_actuators import whole_actuators

MOST = 12  # effects added to one model, beside finer ones,
FEWER = 8  # and so many while chi^2/N is above
NEAR = 20.0  # this, and above
SHARE = 0.05  # of what the model as given leaves: far from the car, what more is named are fragments of what is missing
PRACTICAL = 0.05  # of max(1, chi^2/N): a gain below it is not worth an effect,
FIRST = 0.03  # and this for the first one: pure noise yields less than 0.002; and for all while more is left than this
FAR = 2.0  # times the noise, of a model without known remainder: there what is left out for its size adds up
MIN_BOOTSTRAP_SHARE = 0.95  # share of bootstrap samples in which an effect must gain
BOOTSTRAP_SLACK = 0.1  # of a gain that the draws without it may lose
CLEAR_GAIN_FACTOR = 5.0  # times that: a gain that needs no bootstrap, for effects that show in a single event
EVIDENT_GAIN_FACTOR = 2.0  # times that: a gain that makes an effect worth its name, however small its value looks
FINER_EFFECT_RATIO = 0.8  # of what the best of the others leaves: a finer effect that leaves less comes before it
RIVAL = 0.02  # of max(1, chi^2/N): a gap below it tells nothing
ROUGH = 2.0 * PRACTICAL  # of max(1, chi^2/N): a set further behind the best need not be fitted well
PRICE = 0.005  # of max(1, chi^2/N), for a parameter
EQUAL = 5e-4  # of chi^2/N: sets that differ by less do the same
MISFIT = 1.3  # chi^2/N over all channels, above which something is left
CHANNEL_MISFIT = 1.5  # of one channel
FEW = 4.2  # three standard deviations of chi^2/N of one of some channels: 3 sqrt(2); what few samples make is no misfit
MATCHED_MISFIT = 0.02  # of what was beyond the noise at first, that a set of many effects may leave, and
MATCHED = 3.0  # times the noise beyond it at most: other beginnings led five cars in MuJoCo to much the same
EXCUSED_MISFIT = 2.0  # of one channel of a twin with a known remainder, which changes from drive to drive
_RETURNS = 1  # times that a search begins again, which takes as long as the first time; chosen
_EXCHANGES = 8  # of effects of a set by others
_REFITTED = 6  # candidates of a round that are fitted, the best of the grid
LARGE = 6  # effects of a set from which on fewer candidates are fitted: each fit moves all of its values
_REFITTED_IN_LARGE = 3  # candidates of a round in such a set, where each fit costs more
_ROUGHLY = 5e-3  # of what the best set so far leaves beyond the noise: a round that gains less ends the fit of a set
# that may take its place, and twice that of one in which another effect will come; chosen: a quarter of RIVAL
_CONTESTANTS = 12  # effects that came nearest when one was named, and may take its place

Tick: TypeAlias = Callable[[str], None]
Ranked: TypeAlias = tuple[float, str, Point]  # chi^2 left, effect, point


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class SearchResult:
    """Result of a search: the final set, rivals of its effects (best first), and effects that could not have shown."""

    final: Trial
    rivals: dict[str, tuple[str, ...]]
    not_excited: tuple[str, ...]


class Search:
    """One search. nuisance: coordinates that are fitted along with every set, from `start` on (the model's input map);
    fixed: values of what is not searched; refiners: effects that change while driving, tried at the end only."""

    bootstrap_share = staticmethod(bootstrap_share)

    def __init__(self, target: ExperimentSet, tried: Sequence[Candidate], *, nuisance: Sequence[Coordinate] = (),
                 start: Values | None = None, fixed: Values | None = None, refiners: Sequence[Candidate] = (),
                 tick: Tick = lambda text: None) -> None:  # fmt: skip
        self.target, self.tick = target, tick
        self.tried = {c.name: c for c in tried}
        self.refiners = {c.name: c for c in refiners}
        self.known = {**self.refiners, **self.tried}
        self.nuisance, self.start, self.fixed = tuple(nuisance), dict(start or {}), dict(fixed or {})
        self.count = max(target.count, 1)
        self.starts = target.starts()
        self._shown: dict[str, float] = {}  # of the first scan, which alone is sure to look at the strongest of each
        self._near: dict[str, tuple[str, ...]] = {}
        self._given = 0.0  # chi^2 of the model as given, once the search runs
        self._way = ""  # from where effects are looked for, in the words of progress
        self.bare = self.apart = False  # began with what nearly every car has; drives of their own are held out
        self._late = True  # whether the keys are fitted that come late
        self._whole: Trial | None = None
        self._less: dict[str, Trial] = {}
        self._rough: dict[str, Trial] = {}

    def run(self) -> SearchResult:
        """Search until nothing pays any more; where much is left, begin again from what came second."""
        base = self.trial((), self.start)
        self._given = base.chi2
        if self.within_noise(base):
            self._scan(base, self.tried)
            return SearchResult(base, {}, self.unseen())
        turns: list[Trial] = []
        best, rivals = self._contest(grown := self._risen(base, turns))
        contested = {frozenset(grown.names)}
        if self.cost(best) > MISFIT * self.count:
            turns = [] if self.bare else late_pair(self, base) + turns
        for number, turn in enumerate(sorted(turns, key=self.cost)[:_RETURNS], 1):
            if self.cost(best) < MISFIT * self.count or self._is_matched(base, best):
                break
            self.target.settle(turn.values)
            self._way = f"much is left, another beginning ({number} of {_RETURNS} at most), "
            grown = self._risen(self.trial(turn.names, turn.values), [])
            self._way = ""
            if frozenset(grown.names) in contested:  # it came to the same
                continue
            contested.add(frozenset(grown.names))
            other, others_rivals = self._contest(grown)
            if self.cost(other) < self.cost(best):
                best, rivals = other, others_rivals
        self.target.settle(best.values)
        whole = self._whole_actuator(best)
        if whole is not best or frozenset(best.names) not in contested:  # in the place of others it may let more show
            best = whole if self.bare and self.apart else self.grown(whole, [])
        best = self.credible_set(self.trial(best.names, best.values, zoom=True, like=best))
        best = usual_set(
            best,
            without=lambda name: self.without(best, name),
            filled=lambda less, name: self.pruned(self.grown(less, [], barred=(name,))),
            refit=lambda other: self.trial(other.names, other.values, zoom=True, like=other),
        )
        self.target.settle(best.values)
        return SearchResult(best, rivals, self.unseen())

    def _is_matched(self, base: Trial, best: Trial) -> bool:
        """True if a set of many effects explains nearly all: another order of them leads to much the same."""
        left, was = best.chi2 - self.count, base.chi2 - self.count
        return len(best.names) >= LARGE and left < min(MATCHED_MISFIT * was, MATCHED * self.count)

    def unseen(self) -> tuple[str, ...]:
        """Effects of which not even the strongest would have changed anything that is worth a name, by name."""
        return tuple(sorted(name for name, change in self._shown.items() if change < PRACTICAL))

    def _risen(self, now: Trial, turns: list[Trial]) -> Trial:
        """The set grown, keys that come late last; from a bare data sheet, what nearly every car has comes at once."""
        self._late = False
        if not now.names and not self.target.excused and any(one.seen for one in self.tried.values()):
            self._scan(now, self.tried)  # the first one says what could not have shown
        now = self.grown(with_seen(self, now), turns, until=lambda one: is_bare(self, one))
        if is_bare(self, now):
            self.bare = True
            now = usual_car(self)
            now = now if self.apart else self.grown(now, [])
        self._late = True
        self.target.settle(now.values)
        if self.bare and self.apart:
            return self.trial(now.names, now.values)
        now = self.grown(self.trial(now.names, now.values), [])
        whole = self._whole_actuator(now)
        return now if whole is now else self.grown(whole, [])

    def _whole_actuator(self, now: Trial) -> Trial:
        """The set with all of an actuator of which it has a part, if that does better."""
        whole = whole_actuators(self, now) if self.misfit(now) else iter(())
        return next((trial for trial in whole if self.is_worth_adding(now, trial)), now)

    def grown(self, now: Trial, turns: list[Trial], barred: Collection[str] = (), most: int = 0,
              until: Callable[[Trial], bool] = lambda now: False) -> Trial:  # fmt: skip
        """The set with more effects, one by one, until none pays. turns: takes the second best of each round; barred:
        effects that are not tried; most: effects of a set, 0 for the usual number; until: ends it earlier."""
        while not until(now := placed(self, now, PRACTICAL)):
            left = f"; so far {', '.join(now.names)}: chi²/N {now.chi2 / self.count:.3g}" if now.names else ""
            self.tick(f"{self._way}effect {len(now.names) + 1}: trying {len(self.tried)}{left}")
            paying = self.paying(now, barred, most or (LARGEST if self.bare else MOST))
            if not paying:
                break
            turns += paying[1:2]
            self.target.settle(paying[0].values)
            now = self.trial(paying[0].names, paying[0].values, like=paying[0])
        return now

    def is_worth_adding(self, without: Trial, with_it: Trial, *, count: int = 0) -> bool:
        """True if the step to the other set is worth an effect: in size, and in nearly every draw of segments."""
        count = count or self.count
        gain = (without.chi2 - with_it.chi2) / count
        worth = self.least_gain(with_it.chi2 / count, first=not without.names)
        if not worth <= gain <= CLEAR_GAIN_FACTOR * worth:  # too little, or so much that no draw is needed
            return gain > worth
        share = self.bootstrap_share(without.segment_chi2, with_it.segment_chi2, slack=BOOTSTRAP_SLACK)
        return share >= MIN_BOOTSTRAP_SHARE

    def least_gain(self, left: float, *, first: bool) -> float:
        """chi^2/N that is worth an effect, the first one or one beside others, which leaves `left` of chi^2/N."""
        return (FIRST if first or (left > FAR and not self.target.excused) else PRACTICAL) * max(1.0, left)

    def cost(self, trial: Trial) -> float:
        """chi^2 and a price for each parameter: of two sets that do alike the simpler one wins."""
        limits = sum(isinf(c.key.neutral) for c in trial.fit.coordinates)  # one that is always met is a gain
        priced = sum(has_price(c, trial.values) for c in trial.fit.coordinates)
        return trial.chi2 + PRICE * max(self.count, trial.chi2) * priced + EQUAL * self.count * limits

    def lasting(self) -> Search:
        """The same search, for which the known remainder is an error that lasts."""
        other = copy(self)
        other.target = self.target.lasting()
        return other

    def trial(self, names: Sequence[str], start: Values, *, zoom: bool = False, target: ExperimentSet | None = None,
              kept: Values | None = None, like: Trial | None = None, above: float = inf,
              enough: float = 0.0) -> Trial:  # fmt: skip
        """A set of effects fitted jointly from `start` on, to the search's own data or to others.

        kept: values of effects beside them that are not fitted. like: a trial of much the same, to begin with its
        derivatives. above: a chi^2 beyond which the fit may stay rough; enough: a round that gains less ends it. What
        `start` says of the car itself ("parameters") is kept as it is, too, and what logs show of keys that come late.
        """
        target = target or self.target
        every = [c for name in names for c in self.known[name].coordinates]
        late = {c.name: self.known[c.effect].seen.get(c.name, c.key.neutral) for c in every if c.key.late}
        coordinates = [*self.nuisance, *(c for c in every if self._late or c.name not in late)]
        stop = Stop(enough=max(2e-4 * target.count, enough), above=above)
        car = {name: value for name, value in start.items() if name[0] == "parameters"}
        shown = {} if self._late else {c: start.get(c, v) for c, v in late.items() if c in self.known[c[0]].seen}
        fixed = self.fixed | car | shown | dict(kept or {})
        found = fit(target, coordinates, late | dict(start), fixed=fixed, stop=stop, zoom=zoom,
                    known=like.fit if like else None)  # fmt: skip
        return Trial(tuple(names), fixed | found.values, found, target.by_segment(found.residual))

    def paying(self, now: Trial, barred: Collection[str] = (), most: int = MOST) -> list[Trial]:
        """Sets with one more effect that pays, best first. Finer effects only where a misfit is left, as a late clock
        looks like one, and after the others: if none of those pays, or a finer one does far better than the best."""
        if self.within_noise(now):
            return []
        most = most if now.chi2 < max(NEAR * self.count, SHARE * self._given) else FEWER
        full = sum(not self.known[name].detail for name in now.names) >= most
        found: list[Trial] = []
        for detail in (True,) if full else (False, True):
            if detail and not self.misfit(found[0] if found else now):
                break
            few = [n for n, c in self.tried.items() if c.detail == detail and n not in barred]
            ranking = self._scan(now, few, PRACTICAL * max(self.count, now.chi2) if now.names else 0.0)
            far = now.chi2 > NEAR * self.count  # where one wild segment makes every interval wide
            paying: list[Trial] = []
            for batch in self._batches(now, ranking):
                worth = [t for t in self._additions(now, batch) if self.is_worth_adding(now, t)]
                if worth and not found and self._trifle(worth[0]):
                    return []  # what it is, is too small to be named, and no other effect should stand for it
                paying = [t for t in worth if self.is_credible(t, t.names[-1], certain=not far)]
                if paying:
                    break
            for trial in paying:
                self._near[trial.names[-1]] = tuple(name for _, name, _ in ranking[:_CONTESTANTS])
            if paying and (not found or self.cost(paying[0]) < FINER_EFFECT_RATIO * self.cost(found[0])):
                found = [*paying, *found]
        return found or ([] if barred or not self.misfit(now) else masked_pair(self, now))

    def misfit(self, now: Trial) -> bool:
        """True if more is left than noise, in all or in one channel; of a twin with a known remainder, more than that
        does anew (`lasting_remainder`): by how much it drifts is no measure of what is missing."""
        target, most = (self.target.lasting(), EXCUSED_MISFIT) if self.target.excused else (self.target, CHANNEL_MISFIT)
        channels, known = target.by_channel(now.values), target.anew()
        usual = float(np.mean([known[c] for c in channels])) if channels else 1.0  # they have about as many samples
        chi2 = square(target.whitened(now.values)) if self.target.excused else now.chi2
        few = 1.0 + FEW * sqrt(len(channels) / self.count)
        return chi2 > MISFIT * usual * self.count or any(channels[c] > max(most * known[c], few) for c in channels)

    def within_noise(self, now: Trial) -> bool:
        """True if no channel is off by more than its sensor is, or than the twin's known remainder allows."""
        return max(self.target.by_channel(now.values).values(), default=0.0) < 1.0

    def _batches(self, now: Trial, ranking: list[Ranked]) -> Iterator[list[Ranked]]:
        """A ranking from its best on; then, far from the noise, once from the first one on that was not fitted, if that
        promises what is worth an effect: each time some fits of a large set."""
        yield ranking
        left = ranking[_REFITTED if len(now.names) < LARGE else _REFITTED_IN_LARGE :]
        far = bool(left) and now.chi2 > FAR * self.count and not self.target.excused
        if far and now.chi2 - left[0][0] > self.least_gain(left[0][0] / self.count, first=False) * self.count:
            yield left

    def _additions(self, now: Trial, ranking: Sequence[Ranked], lowest: float = inf,
                   among: Collection[str] | None = None) -> list[Trial]:  # fmt: skip
        """Sets with one more effect, jointly fitted, best first; what ends far above the best or `lowest` roughly."""
        trials = []
        few = _REFITTED if len(now.names) < LARGE else _REFITTED_IN_LARGE
        for _, name, point in (one for one in ranking[:few] if among is None or one[1] in among):
            above = lowest + ROUGH * max(self.count, lowest)
            enough = _ROUGHLY * (min(now.chi2, lowest) - self.count)
            trials.append(self.trial((*now.names, name), now.values | point, like=now, above=above, enough=enough))
            lowest = min(lowest, trials[-1].chi2)
        return sorted(trials, key=self.cost)

    def _scan(self, now: Trial, names: Iterable[str], needed: float = 0.0) -> list[Ranked]:
        """chi^2 that each effect would leave (the others adapt to first order), and the point where; best first.
        needed: the gain in chi^2 of which an effect must promise some (`FirstOrderGain`)."""
        whole = FirstOrderGain(self.target, now)

        def looked_at(name: str) -> tuple[float, list[Ranked]]:
            look, candidate = copy(whole), self.tried[name]
            points = points_there(now, candidate.coarse if now.names else candidate.points)
            options = look.remaining_chi2(candidate, points, needed)
            return look.strongest, [(left, name, point) for left, point in options]

        found = mapped(looked_at, few := [name for name in names if name not in now.names])
        if not now.names and needed <= 0.0:
            self._shown = {n: seen / self.count for n, (seen, _) in zip(few, found, strict=True)} | self._shown
        ranking = [min(options, key=lambda option: option[0]) for _, options in found if options]
        return sorted(ranking, key=lambda entry: (entry[0], entry[1]))

    def _trifle(self, trial: Trial) -> bool:
        """True if the last effect is there, but smaller than is worth a name."""
        return not self._matters(trial, trial.names[-1], self.target) and self.cost(trial) < MISFIT * self.count

    def _matters(self, trial: Trial, name: str, target: ExperimentSet) -> bool:
        """True if the effect is as large as one needs to be to be worth a name, or small but clearly to be seen: of a
        twin with a known remainder only where nothing else is named, for its drift beside that looks the same."""
        mine = [c for c in trial.fit.coordinates if c.effect == name]
        if any(is_worth_naming(c.key, trial.values[c.name]) for c in sizes(mine)):
            return True
        if trial.names[1:] and target.excused:
            return False
        off = target.whitened(trial.values | {c.name: c.key.neutral for c in mine})
        others = [k for k, c in enumerate(trial.fit.coordinates) if c.effect != name]
        basis = orthonormal(trial.fit.jacobian[others])  # the others adapt to first order
        change = off - trial.fit.residual
        gain = square(off) - trial.chi2 - square(row_products(basis, change))
        return gain > EVIDENT_GAIN_FACTOR * (PRACTICAL if trial.names[1:] else FIRST) * max(
            float(target.count), trial.chi2
        )

    def is_credible(self, trial: Trial, name: str, target: ExperimentSet | None = None, certain: bool = True) -> bool:
        """True if an effect's values mean something: above the least size and not at an end; if asked, certain as well,
        and with no value at an end of those that say how it acts, either."""
        mine = [c for c in trial.fit.coordinates if c.effect == name]
        if any(c.is_at_limit(trial.values[c.name]) for c in (mine if certain else sizes(mine))):
            return False
        sure = intervals(without_finer(trial.fit, name), target.starts() if target else self.starts)
        if certain and not any(is_certain(c, trial.values[c.name], sure[c.name]) for c in sizes(mine)):
            return False
        return self._matters(trial, name, target or self.target)

    def _contest(self, best: Trial) -> tuple[Trial, dict[str, tuple[str, ...]]]:
        """Drop what no longer pays, exchange what another effect does better, and list what does nearly as well."""
        rivals: dict[str, tuple[str, ...]] = {}
        for _ in range(_EXCHANGES):
            best = simplified(self, self.pruned(best), PRACTICAL)
            rivals, exchanged = {}, None
            self._roughly_without_each(best)
            least_needed_first = sorted(best.names, key=lambda n: self._roughly_without(best, n).chi2)
            for k, name in enumerate(least_needed_first):
                self.tick(f"rivals of {name}, {k + 1} of {len(best.names)}; chi²/N {best.chi2 / self.count:.3g}")
                trials = self.in_place_of(best, name)
                sound = [
                    t
                    for t in trials
                    if self.is_credible(t, t.names[-1]) and not is_simpler(self, name, best, t, PRACTICAL)
                ]
                stays = self.bare and self.apart  # for held-out drives choose between rivals
                if sound and not stays and self.cost(sound[0]) < self.cost(best) - 1e-3 * self.count:
                    exchanged = sound[0]
                    break
                rivals[name] = tuple(
                    t.names[-1] for t in trials if self.cannot_tell_apart(best, t) and self.is_rival(best, t, name)
                )
            if exchanged is None:
                return best, rivals
            best = self.trial(exchanged.names, exchanged.values, zoom=True, like=exchanged)
        return best, rivals

    def in_place_of(self, best: Trial, name: str, among: Collection[str] | None = None) -> list[Trial]:
        """The set with another effect in the place of this one, jointly fitted, best first; among: only these are."""
        self._remember(best)
        enough = 2 * _ROUGHLY * (best.chi2 - self.count)
        without = self._less.get(name) or self._fitted_without(best, name, enough=enough)
        others = [other for other in self._contestants(name) if other not in best.names]
        ranking = self._scan(without, others, without.chi2 - best.chi2)
        return self._additions(without, ranking, best.chi2, among)

    def _contestants(self, name: str) -> list[str]:
        """What may take the place of an effect: what came near when it was named, what is often confused with it."""
        tied = (other for other, c in self.tried.items() if c.is_tied(self.known[name]))
        return [other for other in dict.fromkeys((*self._near.get(name, self.tried), *tied)) if other in self.tried]

    def cannot_tell_apart(self, best: Trial, other: Trial) -> bool:
        """True if these data do not tell the two sets apart."""
        gap = (other.chi2 - best.chi2) / self.count / max(1.0, best.chi2 / self.count)
        return gap < RIVAL or (
            gap < PRACTICAL and self.bootstrap_share(other.segment_chi2, best.segment_chi2) < MIN_BOOTSTRAP_SHARE
        )

    def is_rival(self, best: Trial, other: Trial, name: str) -> bool:
        """False if what is in an effect's place contains it, or is a finer form that does worse in nearly all draws."""
        new, share = other.names[-1], self.bootstrap_share(other.segment_chi2, best.segment_chi2)
        return self.contained(new) != name and not (self.known[new].detail and share >= MIN_BOOTSTRAP_SHARE)

    def contained(self, name: str) -> str:
        """The simpler effect that this one can do exactly, "" if there is none."""
        return self.known[name].effect.diagnosed.contains

    def without(self, best: Trial, name: str) -> Trial:
        """The set without one effect, fitted anew; remembered while the set is the same."""
        self._remember(best)
        if name not in self._less:
            self._less[name] = self._fitted_without(best, name)
        return self._less[name]

    def _roughly_without(self, best: Trial, name: str) -> Trial:
        """The same, but no better than is needed to see that the effect pays, where it pays by far."""
        self._remember(best)
        if name in self._less:
            return self._less[name]
        if name not in self._rough:
            self._roughly_without_each(best, (name,))
        return self._rough[name]

    def _roughly_without_each(self, best: Trial, names: Sequence[str] = ()) -> None:
        """The same for each name, of all effects if none is given, side by side."""
        self._remember(best)
        missing = [n for n in names or best.names if n not in self._less and n not in self._rough]
        above = best.chi2 + CLEAR_GAIN_FACTOR * PRACTICAL * max(self.count, best.chi2)
        for name, found in zip(missing, mapped(lambda n: self._fitted_without(best, n, above), missing), strict=True):
            if found.chi2 <= above:
                self._less[name] = found
            self._rough[name] = found

    def _remember(self, best: Trial) -> None:
        if self._whole is not best:
            self._whole, self._less, self._rough = best, {}, {}

    def _fitted_without(self, best: Trial, name: str, above: float = inf, enough: float = 0.0) -> Trial:
        kept = {k: v for k, v in best.values.items() if k[0] != name}
        return self.trial([n for n in best.names if n != name], kept, like=best, above=above, enough=enough)

    def pruned(self, best: Trial) -> Trial:
        """The set without effects that no longer pay, or without which no more than noise is left."""
        while len(best.names) > 1:
            self._roughly_without_each(best)
            least_lost = min((self._roughly_without(best, name) for name in best.names), key=self.cost)
            if self.pays(least_lost, best) and not self.within_noise(least_lost):
                return best
            best = least_lost
        return best

    def pays(self, less: Trial, best: Trial) -> bool:
        """True if an effect is worth its place; of what nearly every car has, far from the noise, if it pays its price:
        a drive that does not ask for it is not all drives."""
        seen = {name for name in best.names if self.known[name].seen}
        usual = self.bare and best.chi2 > FAR * self.count and {*best.names} - {*less.names} <= {*USUAL, *seen}
        return self.cost(less) > self.cost(best) if usual else self.is_worth_adding(less, best)

    def credible_set(self, best: Trial) -> Trial:
        """The set without effects that do not pay or whose value means nothing, and what takes the place of these, if
        that makes up for them: a wind at the end of its range had stood for a drag."""
        less = self._drop_implausible(best)
        if not self.misfit(less) or self.bare:  # held-out data say what may come in their place
            return less
        other = self._drop_implausible(best, refill=True)
        if other.chi2 - best.chi2 < MAX_UNRECOVERED_SHARE * (less.chi2 - best.chi2):
            return other
        self.target.settle(best.values)  # as it was before the others were tried
        return less

    def _drop_implausible(self, best: Trial, *, refill: bool = False) -> Trial:
        """The set without effects that do not pay or whose value means nothing, the last named first; refill: with
        others in the place of these."""
        barred: list[str] = []
        while True:
            best = self.pruned(best)
            vague = [n for n in best.names if not (self.is_credible(best, n) or carries(self, best, n, FAR))]
            if not vague:
                return best
            barred.append(vague[-1])
            best = plainer(self, best, vague[-1])
            if refill and self.misfit(best):
                best = self.grown(best, [], barred)
