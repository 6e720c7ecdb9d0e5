"""Which manoeuvre decides between rivals, and which excites what the data could not show."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Mapping, Sequence
from math import ceil
from typing import TYPE_CHECKING

from pytest_dvp.reality_gap.candidates import Candidate, candidates
from pytest_dvp.reality_gap.experiment import Values
from pytest_dvp.reality_gap.manoeuvres.catalogue import CITY, MANOEUVRES, Manoeuvre
from pytest_dvp.reality_gap.manoeuvres.envelope import Envelope
from pytest_dvp.reality_gap.manoeuvres.perform import SIZES, Drive, perform
from pytest_dvp.reality_gap.manoeuvres.rehearsal import NOISE, Hypothesis, Rehearsal, alike, apart, typical
from pytest_dvp.reality_gap.search import PRACTICAL

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.model import VehicleModel

CLEAR = 3.0  # times what a diagnosis needs: the gap to be had before a drive is enough
MOST_REPEATS = 5
TIE = 0.9  # of the largest gap: as good, so that the shorter drive is taken
_LOOKED_AT = 3  # manoeuvres that are fitted, not only looked at to first order


class PlanError(ValueError):
    """No manoeuvre can be advised; one line that says why."""


@dataclasses.dataclass(frozen=True, slots=True)
class Sign:
    """By what two are told apart: at `time` [s] `channel` of the other differs by `difference` in its unit."""

    truth: str
    other: str
    gap: float
    channel: str
    time: float
    difference: float


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Choice:
    """The manoeuvre that is advised.

    gap: chi^2/N of its log by which the least distinct pair differs after a refit (deciding), or by which the least
    visible effect changes it (exciting); `effects` it is about, `signs` by what they show, largest gap last; `ranking`:
    the gap of each manoeuvre to first order; repeats: how often it is to be driven; weak: it is the best there is in
    this envelope, and yet too little; not_shown: effects that nothing of the catalogue shows.
    """

    effects: tuple[str, ...]
    exciting: bool
    drive: Drive
    gap: float
    signs: tuple[Sign, ...]
    ranking: Mapping[str, float]
    repeats: int
    weak: bool
    not_shown: tuple[str, ...] = ()

    @property
    def manoeuvre(self) -> Manoeuvre:
        """What is driven."""
        return self.drive.manoeuvre


def decide(model: VehicleModel, hypotheses: Mapping[str, Values], noise: Mapping[str, float] | None = None,
           envelope: Envelope | None = None, *, shared: Values | None = None, effects: Sequence[Effect] = (),
           beside: int = 0) -> Choice:  # fmt: skip
    """The manoeuvre that tells effects apart: each in turn is the truth, the others are fitted to its log.

    hypotheses: effect -> its values as fitted; for one without values those with which it is most like the first in a
    drive about town (the first: in the middle of its range). noise: standard deviation by measured channel; shared:
    values of what is known beside; effects: the user's own; beside: samples of the logs there are, which count too.

    Raises PlanError: no such effect, fewer than two, nothing fits the envelope.
    """
    noise, envelope = dict(noise or NOISE), envelope or Envelope()
    known = tried_on(model, tuple(hypotheses), effects)
    if len(hypotheses) < 2:
        raise PlanError(f"nothing to decide: {', '.join(hypotheses) or 'no effect'} alone, name two or more")
    asked = _Asked(model, noise, envelope, dict(shared or {}), tuple(effects))
    mine = _complete(asked, [known[name] for name in hypotheses], hypotheses)
    first: list[tuple[float, Drive]] = []
    for manoeuvre in MANOEUVRES:
        found = perform(manoeuvre, model, asked.shared | dict(mine[0].values), envelope)
        if found is not None:
            first.append((_screened(asked, found, mine), found))
    if not first:
        raise PlanError("no manoeuvre of the catalogue keeps within the envelope; widen it")
    first.sort(key=lambda entry: -entry[0])
    best: list[tuple[float, Drive, tuple[Sign, ...]]] = []
    for screened, found in first:
        if len(best) == _LOOKED_AT or (best and screened < TIE * max(entry[0] for entry in best)):
            break
        drives = _together(asked, found, mine)
        if drives:
            signs = _signs(asked, drives, mine)
            best.append((signs[0].gap, drives[0], signs))
    if not best:
        raise PlanError("no manoeuvre of the catalogue keeps within the envelope with every rival; widen it")
    top = max(entry[0] for entry in best)
    gap, drive, signs = min((e for e in best if e[0] >= TIE * top), key=lambda e: e[1].seconds)
    ranking = {found.manoeuvre.name: screened for screened, found in first}
    return Choice(tuple(hypotheses), False, drive, gap, signs, ranking, *_repeats(gap, drive, len(noise), beside))


def excite(model: VehicleModel, names: Sequence[str], noise: Mapping[str, float] | None = None,
           envelope: Envelope | None = None, *, shared: Values | None = None, effects: Sequence[Effect] = (),
           beside: int = 0) -> tuple[Choice, ...]:  # fmt: skip
    """The fewest manoeuvres that show every one of these effects, that which shows most of them first.

    An effect counts as shown if one of typical size changes chi^2/N as much as a diagnosis needs, three times over.
    Arguments and PlanError as with `decide`; effects that nothing shows are in `not_shown` of the last choice.
    """
    noise, envelope = dict(noise or NOISE), envelope or Envelope()
    known = tried_on(model, tuple(names), effects)
    asked = _Asked(model, noise, envelope, dict(shared or {}), tuple(effects))
    mine = [Hypothesis(known[name], typical(known[name].coordinates, known[name].points)) for name in names]
    drives = [d for d in (perform(m, model, asked.shared, envelope) for m in MANOEUVRES) if d is not None]
    if not drives:
        raise PlanError("no manoeuvre of the catalogue keeps within the envelope; widen it")
    tables: list[tuple[Drive, dict[str, Sign]]] = []
    for drive in drives:
        rehearsal = Rehearsal(drive, model, {}, noise, shared=asked.shared, extra=asked.effects)
        tables.append((drive, {h.name: _sign(rehearsal, "", h, None) for h in mine}))
    enough = CLEAR * PRACTICAL
    left, chosen = list(names), []
    while left:
        drive, table = max(tables, key=lambda e: (sum(e[1][n].gap >= enough for n in left),
                                                  min(e[1][n].gap for n in left), -e[0].seconds))  # fmt: skip
        shown = [n for n in left if table[n].gap >= enough]
        if not shown:
            break
        # among those that show as many, the one that shows the faintest best
        equal = [e for e in tables if all(e[1][n].gap >= enough for n in shown)]
        drive, table = max(equal, key=lambda e: min(e[1][n].gap for n in shown))
        signs = tuple(sorted((table[n] for n in shown), key=lambda s: s.gap))
        ranking = {d.manoeuvre.name: min(t[n].gap for n in shown) for d, t in tables}
        chosen.append(Choice(tuple(shown), True, drive, signs[0].gap, signs, ranking,
                             *_repeats(signs[0].gap, drive, len(noise), beside)))  # fmt: skip
        left = [n for n in left if n not in shown]
    if left and chosen:
        chosen[-1] = dataclasses.replace(chosen[-1], not_shown=tuple(left))
    if not chosen:
        raise PlanError(f"no manoeuvre of the catalogue shows {', '.join(left)} within this envelope")
    return tuple(chosen)


@dataclasses.dataclass(frozen=True, slots=True)
class _Asked:
    model: VehicleModel
    noise: dict[str, float]
    envelope: Envelope
    shared: dict[tuple[str, str], float]
    effects: tuple[Effect, ...]

    def rehearse(self, drive: Drive, truth: Values) -> Rehearsal:
        return Rehearsal(drive, self.model, truth, self.noise, shared=self.shared, extra=self.effects)


def tried_on(model: VehicleModel, names: Sequence[str], effects: Sequence[Effect] = ()) -> dict[str, Candidate]:
    """The effects of these names as a fit begins with them.

    Raises PlanError: no effect of that name, or none that acts on this model's motion.
    """
    from vehicle.model.catalogue import catalogue
    from vehicle.model.errors import nearest_name

    every = {**catalogue(), **{e.name: e for e in effects}}
    found = {c.name: c for c in candidates(model, every.values())}
    for name in names:
        if name not in every:
            near = nearest_name(name, every)
            hint = f", did you mean {near!r}?" if near else " (dvp effects lists them)"
            raise PlanError(f"no effect called {name!r}{hint}")
        if name not in found:
            raise PlanError(f"{name} cannot be planned for: it does not act on this model, or not on its motion")
    return found


def _complete(asked: _Asked, wanted: Sequence[Candidate], given: Mapping[str, Values]) -> list[Hypothesis]:
    """All hypotheses with values; those without are made like the first."""
    first = wanted[0]
    values = dict(given[first.name]) or typical(first.coordinates, first.points)
    found = [Hypothesis(first, values)]
    town: Rehearsal | None = None
    for candidate in wanted[1:]:
        values = dict(given[candidate.name])
        if not values:
            if town is None:
                drive = perform(CITY, asked.model, asked.shared | dict(found[0].values), asked.envelope, (*SIZES, 0.4))
                if drive is None:
                    raise PlanError("not even a gentle drive keeps within the envelope; widen it")
                town = asked.rehearse(drive, found[0].values)
            values = alike(town, candidate)
        found.append(Hypothesis(candidate, values))
    return found


def _screened(asked: _Asked, drive: Drive, mine: Sequence[Hypothesis]) -> float:
    """The least gap of all pairs, to first order."""
    rehearsal = asked.rehearse(drive, mine[0].values)
    at = [rehearsal.whitened(h.values) for h in mine]
    tangents = [rehearsal.tangent(h, r) for h, r in zip(mine, at, strict=True)]
    pairs = itertools.permutations(range(len(mine)), 2)
    return min(apart(at[b] - at[a], tangents[b]) for a, b in pairs) / rehearsal.count


def _together(asked: _Asked, drive: Drive, mine: Sequence[Hypothesis]) -> list[Drive]:
    """The drive as each of them would have it, all of one size that keeps every one within the envelope."""
    for size in (s for s in SIZES if s <= drive.size):
        found = [drive] if size == drive.size else []
        for h in mine[len(found) :]:
            one = perform(drive.manoeuvre, asked.model, asked.shared | dict(h.values), asked.envelope, (size,))
            if one is None:
                break
            found.append(one)
        if len(found) == len(mine):
            return found
    return []


def _signs(asked: _Asked, drives: Sequence[Drive], mine: Sequence[Hypothesis]) -> tuple[Sign, ...]:
    """Every pair with its gap after a refit, the least first."""
    signs = []
    for drive, truth in zip(drives, mine, strict=True):
        rehearsal = asked.rehearse(drive, truth.values)
        signs += [_sign(rehearsal, truth.name, o, rehearsal.refitted(o)) for o in mine if o is not truth]
    return tuple(sorted(signs, key=lambda s: s.gap))


def _sign(rehearsal: Rehearsal, truth: str, other: Hypothesis, chi2: float | None) -> Sign:
    if chi2 is None:
        r = rehearsal.whitened(other.values)
        chi2 = float(r @ r)
    shares = rehearsal.channels(other.values)
    channel = max(shares, key=lambda name: shares[name])
    time, difference = rehearsal.largest(other.values, channel)
    return Sign(truth, other.name, chi2 / rehearsal.count, channel, time, difference)


def _repeats(gap: float, drive: Drive, channels: int, beside: int) -> tuple[int, bool]:
    """How often a drive is needed beside what there is, and whether even that is little."""
    samples = channels * len(drive.t)
    wanted = CLEAR * PRACTICAL
    for k in range(1, MOST_REPEATS + 1):
        if k * gap * samples >= wanted * (beside + k * samples):
            return k, False
    alone = ceil(MOST_REPEATS / 2)
    return alone, gap < PRACTICAL
