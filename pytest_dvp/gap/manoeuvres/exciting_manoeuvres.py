"""The manoeuvres that show effects which the data could not have shown."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pytest_dvp.gap.diagnose.candidates import Candidate, candidates
from pytest_dvp.gap.diagnose.experiment import Values
from pytest_dvp.gap.diagnose.search import PRACTICAL
from pytest_dvp.gap.manoeuvres.catalogue import MANOEUVRES, Manoeuvre
from pytest_dvp.gap.manoeuvres.choice import (
    ENOUGH,
    MOST_REPEATS,
    Choice,
    PlanError,
    RehearsalInputs,
    candidates_by_name,
    sign_of,
)
from pytest_dvp.gap.manoeuvres.driving_limits import Envelope
from pytest_dvp.gap.manoeuvres.rehearsal import NOISE, Hypothesis, Rehearsal, typical
from pytest_dvp.gap.manoeuvres.simulated_drive import Drive

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel

_PLENTY = 0.5  # of the largest change: shows it as well, so that the shorter drive is taken


def excite(model: VehicleModel, names: Sequence[str], noise: Mapping[str, float] | None = None,
           envelope: Envelope | None = None, *, shared: Values | None = None, effects: Sequence[Effect] = (),
           beside: int = 0, manoeuvres: Sequence[Manoeuvre] = MANOEUVRES) -> tuple[Choice, ...]:  # fmt: skip
    """The fewest manoeuvres that show every one of these effects, that which shows most of them first.

    An effect of typical size counts as shown if it changes chi^2/N three times as much as a diagnosis needs, and that
    no other effect of the catalogue, to first order, does the same; where nothing achieves that, if it shows at all.
    Each drive keeps within the limits without the effects that it is to show and with each of them, of typical size.
    beside: samples of the logs there are. Other arguments and PlanError as with `decide`; effects that nothing shows
    are in `not_shown` of the last choice.
    """
    from vehicle.model.effect_catalogue import catalogue

    noise, envelope = dict(noise or NOISE), envelope or Envelope()
    known = candidates_by_name(model, tuple(names), effects)
    asked = RehearsalInputs(model, noise, envelope, dict(shared or {}), tuple(effects))
    mine = [_typical(known[name]) for name in names]
    every = candidates(model, [*catalogue().values(), *effects])
    others = [_typical(c) for c in every if c.name not in names]
    tables = [
        _Table(asked, drive, mine, others) for drive in (asked.perform(m, {}) for m in manoeuvres) if drive is not None
    ]  # fmt: skip
    if not tables:
        raise PlanError("no manoeuvre keeps within the envelope; widen it")
    told: dict[str, bool] = {}

    def worth(table: _Table, name: str) -> float:
        return table.distinct[name] if told[name] else table.visible[name]

    left, chosen = list(names), []
    while left and tables:
        told.update({n: max(t.distinct[n] for t in tables) >= ENOUGH for n in left})
        most = max(sum(worth(t, n) >= ENOUGH for n in left) for t in tables)
        if not most:
            break
        able = [t for t in tables if sum(worth(t, n) >= ENOUGH for n in left) == most]
        least = {id(t): min(worth(t, n) for n in left if worth(t, n) >= ENOUGH) for t in able}
        top = max(least.values())
        best = min((t for t in able if least[id(t)] >= _PLENTY * top), key=lambda t: t.drive.seconds)
        shown = [n for n in left if worth(best, n) >= ENOUGH]
        moving = [h.values for h in mine if h.name in shown and h.candidate.effect.slot != "sensor"]
        kept = asked.together(best.drive, [{}, *moving])
        if not kept or kept[0] is not best.drive:  # with one of them it breaks a limit: smaller, or not at all
            at = tables.index(best)
            tables[at : at + 1] = [_Table(asked, drive, mine, others) for drive in kept[:1]]
            continue
        signs = sorted((sign_of(best.rehearsal, "", h, worth(best, h.name)) for h in mine if h.name in shown),
                       key=lambda s: s.gap)  # fmt: skip
        ranking = {t.drive.manoeuvre.name: min(worth(t, n) for n in shown) for t in tables}
        gap, count = signs[0].gap, best.rehearsal.count
        joint = [k * gap * count / (beside + k * count) for k in range(1, MOST_REPEATS + 1)]
        repeats = next((k for k, value in enumerate(joint, 1) if value >= ENOUGH), MOST_REPEATS)
        weak = joint[repeats - 1] < PRACTICAL
        chosen.append(Choice(tuple(shown), True, best.drive, gap, tuple(signs), ranking, repeats, weak))
        left = [n for n in left if n not in shown]
    if not chosen:
        raise PlanError(f"no manoeuvre shows {', '.join(left)} within these limits")
    if left:
        chosen[-1] = dataclasses.replace(chosen[-1], not_shown=tuple(left))
    return tuple(chosen)


def _typical(candidate: Candidate) -> Hypothesis:
    return Hypothesis(candidate, typical(candidate.coordinates, candidate.points))


class _Table:
    """What a drive shows: visible, the change of chi^2/N by each effect; distinct, what of it is left when any one
    other effect, in any size, may explain it (effects that no usual data tell from it excepted)."""

    def __init__(
        self, asked: RehearsalInputs, drive: Drive, mine: Sequence[Hypothesis], others: Sequence[Hypothesis]
    ) -> None:
        self.drive = drive
        self.rehearsal: Rehearsal = asked.rehearse(drive, {})
        every = [*mine, *others]
        changes = np.array([self.rehearsal.whitened(h.values) for h in every])
        products = changes @ changes.T
        self.visible: dict[str, float] = {}
        self.distinct: dict[str, float] = {}
        for k, h in enumerate(mine):
            own = float(products[k, k])
            rest = [
                own - float(products[k, j]) ** 2 / max(float(products[j, j]), 1e-12) for j, other in enumerate(every)
                if j != k and other.name not in h.candidate.effect.ties and h.name not in other.candidate.effect.ties
            ]  # fmt: skip
            self.visible[h.name] = own / self.rehearsal.count
            self.distinct[h.name] = min([own, *rest]) / self.rehearsal.count
