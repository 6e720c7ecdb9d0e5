"""The manoeuvre that tells effects apart: each in turn is the truth, and the others are fitted to its log."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, TypeAlias

from pytest_dvp.gap.diagnose.candidates import Candidate
from pytest_dvp.gap.diagnose.experiment import Values
from pytest_dvp.gap.diagnose.search import PRACTICAL
from pytest_dvp.gap.manoeuvres.catalogue import CITY, MANOEUVRES, Manoeuvre
from pytest_dvp.gap.manoeuvres.choice import (
    ENOUGH,
    MOST_REPEATS,
    TIE,
    Choice,
    LargestDifference,
    PlanError,
    RehearsalInputs,
    candidates_by_name,
    sign_of,
)
from pytest_dvp.gap.manoeuvres.driving_limits import Envelope
from pytest_dvp.gap.manoeuvres.rehearsal import NOISE, Hypothesis, Rehearsal, closest_values, separable_chi2, typical
from pytest_dvp.gap.manoeuvres.simulated_drive import SIZES, Drive

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel

_Gaps: TypeAlias = dict[tuple[str, str], float]  # (truth, other) -> gap in chi^2/N

_LOOKED_AT = 2  # manoeuvres that are fitted, not only looked at to first order


class Evidence:
    """What the logs that there are say: `samples` of them, and the chi^2 that each effect leaves in them.

    near: values of effects that the logs hardly rule out, and more of other data would.
    """

    def __init__(
        self, samples: int = 0, left: Mapping[str, float] | None = None, near: Mapping[str, Values] | None = None
    ) -> None:
        self.samples, self.left, self.near = samples, dict(left or {}), dict(near or {})

    def joint(self, truth: str, other: str, gap: float, count: int, repeats: int = 1) -> float:
        """Gap in chi^2/N of these logs and a drive of `count` samples together, driven `repeats` times."""
        before = max(self.left.get(other, 0.0) - self.left.get(truth, 0.0), 0.0)
        return (before + repeats * count * gap) / max(self.samples + repeats * count, 1)


def decide(model: VehicleModel, hypotheses: Mapping[str, Values], noise: Mapping[str, float] | None = None,
           envelope: Envelope | None = None, *, evidence: Evidence | None = None, shared: Values | None = None,
           effects: Sequence[Effect] = (), manoeuvres: Sequence[Manoeuvre] = MANOEUVRES) -> Choice:  # fmt: skip
    """The manoeuvre with the largest worst gap over all pairs; of those as good the shortest.

    hypotheses: effect -> its values as fitted; for one without values those with which it is most like the first in a
    drive about town (the first: in the middle of its range). noise: standard deviation by measured channel; evidence:
    what the logs that there are say; shared: values of what is known beside; effects: the user's own; manoeuvres: those
    that can be driven.

    Raises PlanError: no such effect, fewer than two, nothing fits the envelope.
    """
    noise, envelope, evidence = dict(noise or NOISE), envelope or Envelope(), evidence or Evidence()
    known = candidates_by_name(model, (*hypotheses, *evidence.near), effects)
    if len(hypotheses) < 2:
        raise PlanError(f"nothing to decide: {', '.join(hypotheses) or 'no effect'} alone, name two or more")
    asked = RehearsalInputs(model, noise, envelope, dict(shared or {}), tuple(effects))
    mine = _complete(asked, [known[name] for name in hypotheses], hypotheses)
    others = [*mine, *(Hypothesis(known[name], values) for name, values in evidence.near.items())]
    drives = [asked.perform(m, mine[0].values) for m in manoeuvres]
    screened = [(_screened(asked, drive, mine, others, evidence), drive) for drive in drives if drive is not None]
    if not screened:
        raise PlanError("no manoeuvre keeps within the envelope; widen it")
    tied = _tied(set(hypotheses), [gaps for gaps, _ in screened])
    ranked = sorted(((_least(gaps, tied), drive) for gaps, drive in screened), key=lambda entry: -entry[0])
    best: list[_Looked] = []
    for gap, drive in ranked:
        if len(best) == _LOOKED_AT or (best and gap < TIE * max(entry.worth for entry in best)):
            break
        every = asked.together(drive, [h.values for h in mine])
        if every:
            best.append(_Looked(asked, every, mine, others, evidence, tied))
    if not best:
        raise PlanError("no manoeuvre keeps within the envelope with every rival; widen it")
    top = max(entry.worth for entry in best)
    chosen = min((entry for entry in best if entry.worth >= TIE * top), key=lambda entry: entry.drive.seconds)
    ranking = {drive.manoeuvre.name: gap for gap, drive in ranked}
    repeats = next((k for k in range(1, MOST_REPEATS + 1) if chosen.joint(k) >= ENOUGH), MOST_REPEATS)
    # what nothing tells from the best explanation does not bear on the choice, but it does on what comes of it
    open_still = min((gap for pair, gap in chosen.gaps(repeats).items() if pair[0] == mine[0].name), default=ENOUGH)
    signs = tuple(s for s in chosen.signs if s.other in hypotheses)
    weak = min(chosen.joint(repeats), open_still) < PRACTICAL
    return Choice(tuple(hypotheses), False, chosen.drive, signs[0].gap, signs, ranking, repeats, weak)


def _tied(asked_for: set[str], screened: Sequence[_Gaps]) -> set[tuple[str, str]]:
    """Pairs with an effect that was not asked about, which no manoeuvre tells apart."""
    return {
        pair for pair in screened[0]
        if pair[1] not in asked_for and max(gaps[pair] for gaps in screened) < PRACTICAL
    }  # fmt: skip


def _least(gaps: _Gaps, tied: set[tuple[str, str]]) -> float:
    return min(gap for pair, gap in gaps.items() if pair not in tied)


class _Looked:
    """A manoeuvre with every rival's refit to what each would show. signs: every pair, the least gap first."""

    def __init__(
        self,
        asked: RehearsalInputs,
        drives: Sequence[Drive],
        mine: Sequence[Hypothesis],
        others: Sequence[Hypothesis],
        evidence: Evidence,
        tied: set[tuple[str, str]],
    ) -> None:
        self.drive, self._evidence, self._count, self._tied = drives[0], evidence, 1, tied
        signs = []
        for drive, truth in zip(drives, mine, strict=True):
            rehearsal = asked.rehearse(drive, truth.values)
            self._count = rehearsal.count
            for other in others:
                if other is not truth:
                    signs.append(sign_of(rehearsal, truth.name, other, rehearsal.refitted(other) / rehearsal.count))
        self.signs: tuple[LargestDifference, ...] = tuple(sorted(signs, key=lambda s: s.gap))
        self.worth = self.joint(1)

    def gaps(self, repeats: int) -> _Gaps:
        """The gap of every pair in the logs there are and these drives together."""
        return {
            (s.truth, s.other): self._evidence.joint(s.truth, s.other, s.gap, self._count, repeats) for s in self.signs
        }

    def joint(self, repeats: int) -> float:
        """The least of them, but for what nothing tells apart."""
        return _least(self.gaps(repeats), self._tied)


def _complete(asked: RehearsalInputs, wanted: Sequence[Candidate], given: Mapping[str, Values]) -> list[Hypothesis]:
    """All hypotheses with values; those without are made like the first."""
    first = wanted[0]
    values = dict(given[first.name]) or typical(first.coordinates, first.points)
    found = [Hypothesis(first, values)]
    town: Rehearsal | None = None
    for candidate in wanted[1:]:
        values = dict(given[candidate.name])
        if not values:
            if town is None:
                drive = asked.perform(CITY, found[0].values, (*SIZES, 0.4))
                if drive is None:
                    raise PlanError("not even a gentle drive keeps within the envelope; widen it")
                town = asked.rehearse(drive, found[0].values)
            values = closest_values(town, candidate)
        found.append(Hypothesis(candidate, values))
    return found


def _screened(asked: RehearsalInputs, drive: Drive, mine: Sequence[Hypothesis], others: Sequence[Hypothesis],
              evidence: Evidence) -> _Gaps:  # fmt: skip
    """The joint gaps of all pairs, to first order."""
    rehearsal = asked.rehearse(drive, mine[0].values)
    at = [rehearsal.whitened(h.values) for h in others]
    tangents = [rehearsal.tangent(h, r) for h, r in zip(others, at, strict=True)]
    count = rehearsal.count
    return {
        (truth.name, other.name): evidence.joint(
            truth.name, other.name, separable_chi2(at[b] - at[a], tangents[b]) / count, count
        )
        for (a, truth), (b, other) in itertools.product(enumerate(mine), enumerate(others)) if a != b
    }  # fmt: skip
