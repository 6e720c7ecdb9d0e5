"""Finds a law in what a model leaves unexplained: where it acts, which quantities it is made of, and how firm it is.

The terms of a grammar are tried directly in what is measured: each is driven through the model with a small
coefficient, and what the residuals have in common with it says how much it would explain. The best are fitted, one is
taken, and the rest is looked at again, up to three terms. Data held out judge. What the model's own values or an effect
of the catalogue explain as well is no law.
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING

from pytest_dvp.gap.diagnose.experiment import ExperimentSet, experiment_set
from pytest_dvp.gap.diagnose.least_squares import Coordinate, Fit, Stop, fit, intervals
from pytest_dvp.gap.diagnose.linear_algebra import square
from pytest_dvp.gap.discover.forms import points, terms_at
from pytest_dvp.gap.discover.generic_effect import MOST_TERMS, effect_of, generic_effects, values_of
from pytest_dvp.gap.discover.known_rivals import Rival, known_rivals
from pytest_dvp.gap.discover.law import FoundTerm, Law, Verdict
from pytest_dvp.gap.discover.noise_left import beyond_noise, settle
from pytest_dvp.gap.discover.scan import Scan
from pytest_dvp.gap.discover.term import Point, Term
from pytest_dvp.logs.log import Log
from vehicle.model.effect import Key
from vehicle.model.effect_catalogue import catalogue

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel

LEFT = 1.15  # chi^2/N of the model, below which there is nothing to discover
FAMILIES = 24  # forms that are fitted in each round, the best to first order
CREDIBLE = 1.03  # chi^2/N on both sides (`beyond_noise`), above which the form is not proven,
CHANCE = 3.2  # over the root of the samples: two standard deviations of `beyond_noise` for white noise
SHOWN = 0.1  # chi^2/N beyond the noise, that the held-out data must show before they can prove a form
NOISE_GAIN = 25.0  # of chi^2: the best of 2,500 terms gains more from white noise in one law of 700; true laws left up
# to 10, a braking above a threshold that was taken for a square 860
WORTH = 0.2  # of the error beyond the noise, that a law must take away on both sides
LAST = 0.1  # of the held-out one, that its last term must
PRICE = 0.004  # of chi^2, for each factor of a form
TIED = 0.01  # of max(1, chi^2/N), by which a form must do better than any other one to be the form
ELSEWHERE = 0.02  # the same, for the same form at another point
SAME = 0.998  # correlation of what two forms do, from which they are one in other words
AS_GOOD = 0.05  # of the error beyond the noise: a rival that takes away so much less is as good
FAR_WORSE = 3.0  # times what a law leaves beyond the noise, on both sides: a rival that leaves more is not as good
LOSS = 0.005  # chi^2/N, by which a law may be worse on held-out data that show no error: their noise gives as much

ALONG = {"drive", "brake", "body"}  # parts whose forces along the car no log can tell apart, but near standstill

Tick = Callable[[str], None]


def discover(
    logs: Mapping[str, Log],
    model: VehicleModel,
    held_out: Mapping[str, Log],
    *,
    effects: Sequence[Effect] = (),
    tick: Tick = lambda text: None,
) -> Law:
    """Look for a law of at most three terms. logs and held_out by name; the latter judge and are never fitted. effects:
    the user's own, which the model may hold.

    Raises CompareError or ModelError (one line): an input missing, nothing to judge.
    """
    tick("preparing")
    search = _Discovery(logs, model, held_out, effects, tick)
    return search.run()


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class _Fitted:
    """A law fitted to the data; chi2 of the data fitted and held out, per sample; cost with a price for its factors."""

    terms: tuple[Term, ...]
    fit: Fit | None
    left: float
    judged: float

    @property
    def cost(self) -> float:
        return self.left * (1.0 + PRICE * sum(term.form.complexity for term in self.terms))


class _Discovery:
    def __init__(
        self, logs: Mapping[str, Log], model: VehicleModel, held_out: Mapping[str, Log], effects: Sequence[Effect],
        tick: Tick,
    ) -> None:  # fmt: skip
        self.model, self.tick, self.known = model, tick, {**catalogue(), **{e.name: e for e in effects}}
        extra = (*effects, *generic_effects())
        self.target = experiment_set(logs, model, extra=extra)
        self.judge = experiment_set(held_out, model, extra=extra)
        self.points = points(model, self.target.channels)

    def run(self) -> Law:
        base = _Fitted((), None, self._chi2(self.target, ()), self._chi2(self.judge, ()))
        if base.left < LEFT:
            return self._none(base, f"nothing is left to discover (chi^2/N {base.left:.3g})")
        now, reasons = base, list[str]()
        rivals: list[_Fitted] = []
        for number in range(MOST_TERMS):
            if now.left < CREDIBLE:
                break
            scan, tried = self._scan(now.terms)
            order = self._shortlist(scan, tried)
            if not order or scan.gains[order[0]] < scan.chance:
                if not now.terms:
                    return self._none(base, "no term explains more than a shifted residual does by chance")
                break
            fitted = []
            for place, k in enumerate(order):
                self.tick(f"term {number + 1}: fitting {place + 1} of {len(order)}")
                fitted.append(self._fitted((*now.terms, dataclasses.replace(tried[k], c=float(scan.best[k])))))
            fitted.sort(key=lambda one: one.cost)
            if fitted[0].left > CREDIBLE:  # the first order misranks strong laws: d d d came behind d |d| and 24 others
                self.tick(f"term {number + 1}: forms like {fitted[0].terms[-1].form.text}")
                fitted += [
                    self._fitted((*now.terms, dataclasses.replace(tried[k], c=float(scan.best[k]))))
                    for k in _alike(fitted[0].terms[-1], tried, scan) if k not in order
                ]  # fmt: skip
                fitted.sort(key=lambda one: one.cost)
            best = fitted[0]
            gain = LAST * (base.judged - 1.0) if base.judged - 1.0 >= SHOWN else -LOSS
            if now.left - best.left < LAST * (base.left - 1.0) or now.judged - best.judged < gain:
                break
            rivals = fitted[1:]
            now = best
        if not now.terms:
            return self._none(base, "no term explains a tenth of the error on the held-out data, too")
        return self._judged(base, now, rivals, reasons)

    def _judged(self, base: _Fitted, now: _Fitted, rivals: Sequence[_Fitted], reasons: list[str]) -> Law:
        now = self._settled(now)
        removed = [(b - a) / max(b - 1.0, 1e-9) for b, a in ((base.left, now.left), (base.judged, now.judged))]
        shown = base.judged - 1.0 >= SHOWN
        if removed[0] < WORTH or (shown and removed[1] < WORTH):
            text = f"it takes away {removed[0]:.0%} of the error fitted and {removed[1]:.0%} of the one held out"
            return self._none(base, f"{text}; a law takes away {WORTH:.0%} of both")
        more = [beyond_noise(data, values_of(now.terms)) for data in (self.target, self.judge)]
        counts = (self.target.count, self.judge.count)
        credible = all(one <= CREDIBLE + CHANCE / max(n, 1) ** 0.5 for one, n in zip(more, counts, strict=True))
        for rival in known_rivals(self.target, self.judge, self.model, self.known, self.tick):
            if not _stands_against(rival, base, now, credible=credible, shown=shown):
                share = (base.judged - rival.judged) / max(base.judged - 1.0, 1e-9)
                much = f" ({share:.0%} of the error)" if shown else ""
                data = "held-out data" if shown else "data"
                return self._none(base, f"the {data} are explained as well by {rival.text}{much}")
        now = self._settled(now)
        same, other = self._other_forms(now, rivals)
        elsewhere = self._elsewhere(now)
        now = self._where_it_belongs(now, elsewhere)
        if not credible:
            reasons.append(
                f"it leaves more than noise (chi^2/N {more[0]:.3g} fitted, {more[1]:.3g} held out), so its form is "
                "not proven"
            )
        if not shown:
            reasons.append(f"the held-out data hardly show the error (chi^2/N {base.judged:.3g} without the law)")
        if other:
            reasons.append(f"these data cannot tell its form from {', '.join(other)}")
        parts = {p.part for p in self.points if p.name in elsewhere}
        if not parts <= ALONG and len(parts) > 1:  # a force along the car is the same whichever part it comes from
            reasons.append(f"these data cannot tell whether it acts on {' or '.join(sorted(parts))}")
        if not reasons and (follows := self._still_explained(now.terms)):
            reasons.append(f"something is left that follows {follows}, so the form is near the true one at best")
        verdict: Verdict = "STAND_IN" if reasons else "LAW"
        return Law(
            verdict, self._terms(now, same), tuple(elsewhere), (base.left, base.judged), (now.left, now.judged),
            tuple(reasons), _decides(now) if reasons else "",
        )  # fmt: skip

    def _settled(self, now: _Fitted) -> _Fitted:
        """The law fitted again with the segments begun where it would have them begin: with the starts of a model that
        lacks it, a true law leaves more on held-out data."""
        values = values_of(now.terms)
        settle(self.target, values)
        settle(self.judge, values)
        return self._fitted(now.terms)

    def _none(self, base: _Fitted, reason: str) -> Law:
        error = (base.left, base.judged)
        return Law("NO_LAW", (), (), error, error, (reason,))

    def _scan(self, found: tuple[Term, ...]) -> tuple[Scan, list[Term]]:
        tried = [term for point in self.points for term in terms_at(point)]
        return Scan(self.target, values_of(found), [(*found, term) for term in tried], self.tick), tried

    def _still_explained(self, terms: tuple[Term, ...]) -> str:
        """The term that explains most of what a law leaves, "" if that is no more than white noise shows."""
        self.tick("what is left")
        settle(self.target, values_of(terms))  # a start that is a little off would be explained by a sensor
        scan, tried = self._scan(terms)
        best = int(scan.gains.argmax())
        return f"{tried[best].form.text} ({tried[best].point.name})" if scan.gains[best] > NOISE_GAIN else ""

    def _shortlist(self, scan: Scan, tried: Sequence[Term]) -> list[int]:
        """The best of each form and point, and of forms that do the same the simplest."""
        ranked = sorted(range(len(tried)), key=lambda k: -scan.gains[k])
        chosen: list[int] = []
        seen: set[tuple[Point, object]] = set()
        for k in ranked:
            family = (tried[k].point, tried[k].form)
            if scan.gains[k] <= 0.0 or family in seen:
                continue
            seen.add(family)
            chosen.append(k)
            if len(chosen) == FAMILIES:
                break
        return chosen

    def _fitted(self, terms: tuple[Term, ...]) -> _Fitted:
        coordinates, start = [], {}
        for number, term in enumerate(terms):
            effect = effect_of(term, number)
            span = 4.0 * max(abs(term.coefficient), 1e-9)
            coordinates.append(Coordinate(effect, Key("c", term.unit, -span, span, neutral=0.0, least=0.0)))
            start[effect, "c"] = term.coefficient
            if term.form.filter:
                coordinates.append(
                    Coordinate(effect, Key("tau", "s", 0.05, 100.0, neutral=0.0, least=0.02, minimum=0.02))
                )
                start[effect, "tau"] = term.tau
            if term.has_threshold:
                coordinates.append(Coordinate(effect, Key("v0", "m/s", 0.0, 30.0, neutral=inf, least=0.1, minimum=0.0)))
                start[effect, "v0"] = term.v0
        fixed = values_of(terms)
        found = fit(self.target, coordinates, start, fixed=fixed, stop=Stop(rounds=6, enough=1e-4 * self.target.count))
        told = []
        for number, term in enumerate(terms):
            effect = effect_of(term, number)
            told.append(
                dataclasses.replace(
                    term,
                    c=found.values[effect, "c"] * term.form.size / term.point.size,
                    tau=found.values.get((effect, "tau"), term.tau),
                    v0=found.values.get((effect, "v0"), term.v0),
                )
            )
        law = tuple(told)
        return _Fitted(law, found, found.chi2 / self.target.count, self._chi2(self.judge, law))

    def _chi2(self, data: ExperimentSet, terms: tuple[Term, ...]) -> float:
        return square(data.whitened(values_of(terms))) / max(data.count, 1)

    def _terms(self, now: _Fitted, same: tuple[str, ...]) -> tuple[FoundTerm, ...]:
        assert now.fit is not None
        sure = intervals(now.fit, self.target.starts())
        found = []
        for number, term in enumerate(now.terms):
            low, high = sure[effect_of(term, number), "c"]
            found.append(FoundTerm(term, low, high, same if number == len(now.terms) - 1 else ()))
        return tuple(found)

    def _other_forms(self, now: _Fitted, rivals: Sequence[_Fitted]) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Forms of the last term that do the same in other words, and others that these data cannot tell from it."""
        last = now.terms[-1]
        mine = self.target.whitened(values_of(now.terms))
        without = self.target.whitened(values_of(now.terms[:-1]))
        same, other = dict[str, None](), dict[str, None]()
        for rival in rivals:
            form = rival.terms[-1]
            if form.point.part != last.point.part or rival.left - now.left > TIED * max(1.0, now.left):
                continue
            a, b = mine - without, self.target.whitened(values_of(rival.terms)) - without
            alike = float(a @ b) / max((square(a) * square(b)) ** 0.5, 1e-12)
            if alike > SAME:
                same[form.form.text] = None
            else:
                other[form.form.text] = None
        same.pop(last.form.text, None)
        other.pop(last.form.text, None)
        return tuple(same), tuple(name for name in other if name not in same)

    def _elsewhere(self, now: _Fitted) -> tuple[str, ...]:
        """The law's point, and those at which the same forms do as well."""
        last = now.terms[-1]
        found = [last.point.name]
        for point in self.points:
            if point is last.point or last.form.odd != point.odd:
                continue
            for sign in (1.0, -1.0):
                start = dataclasses.replace(last, point=point, c=sign * last.coefficient * last.form.size / point.size)
                moved = self._fitted((*now.terms[:-1], start))
                if moved.left - now.left < ELSEWHERE * max(1.0, now.left):
                    found.append(point.name)
                    break
        return tuple(found)

    def _where_it_belongs(self, now: _Fitted, elsewhere: Sequence[str]) -> _Fitted:
        """The same law with its last term at the point of its class where a person would look for it."""
        last = now.terms[-1]
        name = _natural(last)
        if last.point.part not in ALONG or name == last.point.name or name not in elsewhere:
            return now
        point = next(p for p in self.points if p.name == name)
        found = []
        for sign in (1.0, -1.0):
            c = sign * last.coefficient * last.form.size / point.size
            found.append(self._fitted((*now.terms[:-1], dataclasses.replace(last, point=point, c=c))))
        return min(found, key=lambda one: one.left)


def _stands_against(rival: Rival, base: _Fitted, now: _Fitted, *, credible: bool, shown: bool) -> bool:
    """True if a law explains more than what is known does. One that leaves only noise needs to leave a little less,
    any other one clearly less of the error on the held-out data, or a fraction of what the rival leaves on both sides;
    on those fitted alone where the held-out ones show no error."""
    if credible:
        return rival.left - now.left > TIED and (not shown or rival.judged - now.judged > TIED)
    pairs = ((rival.left, now.left), (rival.judged, now.judged))
    if shown and all(other - 1.0 > FAR_WORSE * max(own - 1.0, CREDIBLE - 1.0) for other, own in pairs):
        return True
    if shown:
        return rival.judged - now.judged > AS_GOOD * (base.judged - 1.0)
    return rival.left - now.left > AS_GOOD * (base.left - 1.0)


def _alike(term: Term, tried: Sequence[Term], scan: Scan) -> list[int]:
    """Terms at the same point behind the same filter, whose factors differ by one at most; |d| counts as d. Of each
    form the one that explains most."""
    mine = _factors(term)
    best: dict[object, int] = {}
    for k in sorted(range(len(tried)), key=lambda k: -scan.gains[k]):
        other = tried[k]
        if other.point is not term.point or other.form.filter != term.form.filter or scan.gains[k] <= 0.0:
            continue
        theirs = _factors(other)
        if max((mine - theirs).total(), (theirs - mine).total()) <= 1:
            best.setdefault(other.form, k)
    return list(best.values())


def _factors(term: Term) -> Counter[str]:
    return Counter(name.strip("|") for name in (*term.form.gate, *term.form.inside))


def _natural(term: Term) -> str:
    """The point at which a force along the car would be looked for, by what it is made of."""
    names = {*term.form.gate, *term.form.inside}
    if names & {"a+", "[drive]"}:
        return "accel"
    return "brake" if names & {"a-", "[brake]"} else "drag"


def _decides(now: _Fitted) -> str:
    """The drive that would tell more, by what the law is made of."""
    names = {name for term in now.terms for name in (*term.form.gate, *term.form.inside)}
    if {"a-", "[brake]"} & names:
        return "series of braking from several speeds in another order, with long pauses in which the brakes cool"
    if {"d", "|d|", "ay", "|ay|", "r", "tanh(r)"} & names:
        return "steady circles and steering steps at several speeds, to both sides"
    if {"a+", "[drive]"} & names:
        return "acceleration from several speeds with several pedals"
    return "long stretches at several constant speeds, in both directions"
