"""What a search leaves to find below what it cannot explain.

A search counts what a model leaves as noise of each sample, and an effect has to take a share of that to be worth its
name. Where much is left, that hides effects which the data show beyond doubt: a steering that lags by 0.04 s takes
nothing off positions that drift for other reasons, and a dead time, a tyre or a servo is found for it in every later
diagnosis that starts from the twin. So the search goes on with what is left as what it is, an error that lasts
(`lasting_remainder`). There an effect counts if the data fitted on and the data held out both ask for it, in the same
size.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from pytest_dvp.gap.diagnose.beyond_remainder import AGREES, APART, EVIDENT
from pytest_dvp.gap.diagnose.candidates import Candidate, candidates, candidates_of, is_worth_naming, sizes
from pytest_dvp.gap.diagnose.diagnosis import Estimate, NamedEffect
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, Values
from pytest_dvp.gap.diagnose.first_order_gain import FirstOrderGain
from pytest_dvp.gap.diagnose.fitted_twin import Drives, refitted, remeasured, values_of, with_values
from pytest_dvp.gap.diagnose.fitted_values import estimates
from pytest_dvp.gap.diagnose.linear_algebra import square
from pytest_dvp.gap.diagnose.rivals import RIVAL_SHARE
from pytest_dvp.gap.diagnose.search import Search, Tick
from vehicle.model.effect_catalogue import catalogue

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import VehicleModel

SHOWN_BELOW = "these data show it only where what is left counts as an error that lasts"
MOST = 4  # effects found so; chosen: of 27 twins of strangers' cars ten had one or two
_FITTED = 10  # effects of a round, the best to first order; chosen
_WIND = "headwind"  # in the slot of the forces, and yet of the day as the road is


class Below(NamedTuple):
    """An effect that both data show where the remainder lasts: what it is fitted with, what it gains in all (chi^2),
    and others that gain nearly as much."""

    name: str
    parameters: dict[str, Estimate]
    gain: float
    rivals: tuple[str, ...] = ()

    @property
    def values(self) -> dict[tuple[str, str], float]:
        """(effect, key) -> value."""
        return {(self.name, key): one.value for key, one in self.parameters.items()}

    def as_named(self) -> NamedEffect:
        """As a diagnosis names it: never more than provisional, for it takes next to nothing off the error."""
        doubts = [f"these data cannot tell it from {', '.join(self.rivals)}"] if self.rivals else []
        return NamedEffect(self.name, self.parameters, self.rivals, doubts=(*doubts, SHOWN_BELOW))


def below_remainder(twin: VehicleModel, drives: Drives, tick: Tick = lambda text: None) -> list[Below]:
    """The effects that all drives of a twin show where its remainder lasts, one after the other, each beside those
    before it; [] without a remainder or data held out."""
    found: list[Below] = []
    while twin.remainder and drives.held_out and len(found) < MOST:
        so_far = f"; so far {', '.join(each.name for each in found)}" if found else ""
        tick(f"what is left as an error that lasts: effect {len(found) + 1}{so_far}")
        options = _shown(twin, drives)
        if not options:
            break
        best, others = options[0], options[1:]
        rivals = tuple(other.name for other in others if other.gain > RIVAL_SHARE * best.gain)
        found.append(best._replace(rivals=rivals))
        twin = with_below(twin, drives, best)
    return found


def with_below(twin: VehicleModel, drives: Drives, found: Below) -> VehicleModel:
    """The twin with the effect, fitted anew together with what it is often confused with where the remainder lasts, if
    data held out gain by that, and the remainder that it has then. All others stay as the fit of each sample has
    them."""
    known = {e.name: e for e in drives.effects}
    values = {key: one.value for key, one in found.parameters.items()}
    grown = twin.with_effect(known.get(found.name, found.name), values)
    anew = refitted(grown, [*confused_with(grown, found.name), found.name], drives)
    return remeasured(with_values(grown, anew.trial.values) if anew.after < anew.before else grown, drives)


def shown_below(twin: VehicleModel, drives: Drives, candidate: Candidate, start: Values) -> Below | None:
    """One effect, if it pays on all drives of the twin where its remainder lasts, in whatever size. start: where its
    fit may begin."""
    if not (twin.remainder and drives.held_out):
        return None
    target, judge = drives.lasting(twin)
    search = Search(target, [candidate, *_often_confused(twin, candidate)])
    mine = {c.name: start[c.name] for c in candidate.coordinates if c.name in start}
    look = FirstOrderGain(target, search.trial((), {}))
    points = [*([mine] if len(mine) == len(candidate.coordinates) else []), *candidate.points]
    _, point = min(look.remaining_chi2(candidate, points), key=lambda option: option[0], default=(0.0, {}))
    return _both_show(search, judge, twin, candidate, point, agrees=0.0) if point else None


def _shown(twin: VehicleModel, drives: Drives) -> list[Below]:
    """What both data show, the largest gain first."""
    target, judge = drives.lasting(twin)
    present = {a.name for a in twin.effects}
    known = {**catalogue(), **{e.name: e for e in drives.effects}}
    tried = [
        c
        for c in candidates(twin, known.values(), ay="ay" in target.channels, refined=True)
        if c.name not in (*present, _WIND) and c.effect.slot != "road"  # what two drives of a day share is no car's
    ]
    search = Search(target, [*tried, *candidates_of(twin, present)])
    now = search.trial((), {})
    options = FirstOrderGain(target, now).promising(tried)[:_FITTED]
    each = (_both_show(search, judge, twin, c, point) for left, c, point in options if now.chi2 - left > EVIDENT**2)
    return sorted((found for found in each if found), key=lambda found: -found.gain)


def confused_with(twin: VehicleModel, name: str) -> list[str]:
    """The other effects of the twin that are often confused with one of its effects."""
    return [other.name for one in candidates_of(twin, [name]) for other in _often_confused(twin, one)]


def _often_confused(twin: VehicleModel, candidate: Candidate) -> list[Candidate]:
    """The effects of the twin that have stood for this one as far as they could."""
    every = candidates_of(twin, [applied.name for applied in twin.effects])
    return [other for other in every if other.is_tied(candidate) and other.name != candidate.name]


def _both_show(
    search: Search, judge: ExperimentSet, twin: VehicleModel, candidate: Candidate, point: Values,
    agrees: float = AGREES,
) -> Below | None:  # fmt: skip
    """The effect fitted from a point on, together with those of the twin that have stood for it, if it takes EVIDENT
    standard deviations off the data fitted on, APART off those held out, of what it changes there the share `agrees` at
    least, and is as large as one is worth a name.

    A dead time has taken what a lag does as far as it can: beside a dead time that stays as it is, each drive asks for
    another lag.
    """
    confused = _often_confused(twin, candidate)
    of_twin = values_of(twin)
    names = [other.name for other in confused]
    base = search.trial(names, {c.name: of_twin[c.name] for other in confused for c in other.coordinates})
    trial = search.trial((*names, candidate.name), {**base.values, **point})
    gain = base.chi2 - trial.chi2
    without, with_it = judge.whitened(base.values), judge.whitened(trial.values)
    held_out, changed = square(without) - square(with_it), square(without - with_it)
    large = any(is_worth_naming(c.key, trial.values[c.name]) for c in sizes(candidate.coordinates))
    sure = large and search.is_credible(trial, candidate.name, search.target)
    if sure and gain > EVIDENT**2 and held_out > APART**2 and held_out >= agrees * changed:
        mine = {key: one for (name, key), one in estimates(trial, search).items() if name == candidate.name}
        return Below(candidate.name, mine, gain + held_out)
    return None
