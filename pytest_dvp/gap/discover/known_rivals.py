"""What is known and may explain an error as well as a law: the model's own values, its calibration, the catalogue."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from math import isfinite
from typing import TYPE_CHECKING

from pytest_dvp.gap.diagnose.candidates import Candidate, candidates
from pytest_dvp.gap.diagnose.experiment import ExperimentSet
from pytest_dvp.gap.diagnose.input_scales import input_map
from pytest_dvp.gap.diagnose.linear_algebra import square
from pytest_dvp.gap.diagnose.search import Search
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.gap.discover.noise_left import settle

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel

CALIBRATION = ("steer_ratio", "steer_offset", "drive_gain", "brake_gain", "rolling_resistance", "aero_drag")
"""Values that every model has, named in its file or not, and that each may be off by too little to be worth a name."""

Tick = Callable[[str], None]


@dataclasses.dataclass(frozen=True, slots=True)
class Rival:
    """Something known, fitted. text: what it is, for a sentence; left, judged: chi^2/N that it leaves on the data
    fitted and held out."""

    text: str
    left: float
    judged: float


def known_rivals(
    target: ExperimentSet, judge: ExperimentSet, model: VehicleModel, known: Mapping[str, Effect], tick: Tick
) -> Iterator[Rival]:
    """Rivals of a law, what costs least first; the caller stops at the first that does as well. known: effects by name.

    The catalogue comes as the sets of a growing diagnosis, and at last as the result of a whole one. Each rival moves
    the starts of the segments (`settle`) of both sets of data.
    """
    every = candidates(model, known.values(), ay="ay" in target.channels, refined=True)
    nuisance, start = input_map(model)
    search = Search(target, every, nuisance=nuisance, start=start)

    def rival(what: str, trial: Trial, search: Search = search) -> Rival:
        settle(target, trial.values)
        settle(judge, trial.values)
        again = search.trial(trial.names, trial.values, like=trial)
        judged = square(judge.whitened(again.values)) / max(judge.count, 1)
        return Rival(what, again.chi2 / max(target.count, 1), judged)

    tick("rivals: the model's own values")
    present = [applied.name for applied in model.effects]
    own = [c.name for c in every if c.name in present]
    given = start | {(a.name, key): value for a in model.effects for key, value in a.values.items()}
    if own:
        yield rival("the model with its own values fitted again", search.trial(own, given))
    tick("rivals: gains and zeros")
    linear = [_from_nothing(c) for c in every if c.name in CALIBRATION or c.name in present]
    free = [c.name for c in linear]
    neutral = {c.name: c.key.neutral for one in linear for c in one.coordinates}
    plain = Search(target, linear, nuisance=nuisance, start=start)
    calibrated = plain.trial(free, neutral | given)
    yield rival(f"the model with its calibration fitted again ({', '.join(free)})", calibrated, plain)
    tick("rivals: the catalogue")
    for trial in _climb(search):
        yield rival(_named(trial), trial)
    best = search.run().final
    if best.names:
        yield rival(_named(best), best)


def _from_nothing(candidate: Candidate) -> Candidate:
    """The candidate with its values by difference, from doing nothing on: by ratio, a fit that begins there cannot
    leave, and its first step out would have to go as far as what is worth a name."""
    return dataclasses.replace(
        candidate,
        coordinates=tuple(
            dataclasses.replace(c, key=dataclasses.replace(c.key, low=c.key.neutral))
            if c.by_ratio and isfinite(c.key.neutral) and c.key.neutral < c.key.low else c
            for c in candidate.coordinates
        ),
    )  # fmt: skip


def _climb(search: Search) -> Iterator[Trial]:
    """The sets of a search's first rise, each with one more effect than the one before; the caller may stop early."""
    now = search.trial((), search.start)
    while paying := search.paying(now):
        search.target.settle(paying[0].values)
        now = search.trial(paying[0].names, paying[0].values, like=paying[0])
        yield now


def _named(trial: Trial) -> str:
    """ "the effects steer_delay (T 0.25 s), mass (ratio 1.06) of the catalogue"."""
    named = []
    for name in trial.names:
        values = [
            f"{c.key.name} {trial.values[c.name]:.3g}{'' if c.key.unit == '-' else ' ' + c.key.unit}"
            for c in trial.fit.coordinates if c.effect == name
        ]  # fmt: skip
        named.append(f"{name} ({', '.join(values)})")
    return f"the effect{'s' if len(named) > 1 else ''} {', '.join(named)} of the catalogue"
