"""What to drive next, from what a diagnosis could not tell."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from pytest_dvp.log import Log
from pytest_dvp.reality_gap.algebra import square
from pytest_dvp.reality_gap.candidates import Candidate
from pytest_dvp.reality_gap.experiment import Campaign, Values, campaign
from pytest_dvp.reality_gap.fit import fit
from pytest_dvp.reality_gap.manoeuvres.choose import Choice, PlanError, decide, excite, tried_on
from pytest_dvp.reality_gap.manoeuvres.envelope import Envelope

if TYPE_CHECKING:
    from pytest_dvp.reality_gap.diagnosis import Diagnosis
    from vehicle.model.effect import Effect
    from vehicle.model.model import VehicleModel

MOST_RIVALS = 4  # of one effect that a manoeuvre is to tell apart: the best


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Advice:
    """deciding: by the name of each effect that has rivals; exciting: for what the data could not show; refused: why
    there is no manoeuvre for something, in a line each."""

    deciding: Mapping[str, Choice]
    exciting: tuple[Choice, ...]
    refused: tuple[str, ...]

    @property
    def choices(self) -> tuple[Choice, ...]:
        """All of them, what decides first."""
        return (*self.deciding.values(), *self.exciting)


def advise(found: Diagnosis, logs: Mapping[str, Log], model: VehicleModel, envelope: Envelope, *,
           effects: Sequence[Effect] = (), exciting: bool = True) -> Advice:  # fmt: skip
    """Manoeuvres for the rivals and, with `exciting`, for the effects that `logs` could not show.

    Raises CompareError or ModelError as `diagnose` does.
    """
    target = campaign(logs, model, extra=effects)
    noise, values = dict(found.noise_floor), dict(found.values)
    deciding: dict[str, Choice] = {}
    refused: list[str] = []
    told: set[frozenset[str]] = set()
    for effect in found.effects:
        if not effect.rivals or effect.action == "remove":
            continue
        names = (effect.name, *effect.rivals[:MOST_RIVALS])
        known = hypotheses(target, model, names, values, effects=effects)
        mine = {key for name in names for key in known[name]}
        shared = {key: value for key, value in values.items() if key not in mine}
        try:
            deciding[effect.name] = decide(
                model, known, noise, envelope, shared=shared, effects=effects, beside=target.count
            )
        except PlanError as error:
            refused.append(f"{' or '.join(names)}: {error}")
        told.add(frozenset(names))
    chosen: tuple[Choice, ...] = ()
    if exciting and found.not_excited:
        try:
            chosen = excite(
                model, found.not_excited, noise, envelope, shared=values, effects=effects, beside=target.count
            )
        except PlanError as error:
            refused.append(str(error))
    return Advice(deciding, chosen, tuple(refused))


def hypotheses(target: Campaign, model: VehicleModel, names: Sequence[str], values: Values, *,
               effects: Sequence[Effect] = ()) -> dict[str, Values]:  # fmt: skip
    """The first name with its fitted values, each other one fitted to the same logs in its place."""
    known = tried_on(model, names, effects)
    first = {key: value for key, value in values.items() if key[0] == names[0]}
    rest = {key: value for key, value in values.items() if key[0] != names[0]}
    found: dict[str, Values] = {names[0]: first}
    for name in names[1:]:
        found[name] = _fitted(target, known[name], rest)
    return found


def _fitted(target: Campaign, candidate: Candidate, rest: Values) -> dict[tuple[str, str], float]:
    begin = min(candidate.points, key=lambda point: square(target.whitened({**rest, **point})))
    return fit(target, candidate.coordinates, begin, fixed=rest).values


def between(names: Sequence[str], logs: Mapping[str, Log], model: VehicleModel, envelope: Envelope, *,
            effects: Sequence[Effect] = ()) -> Choice:  # fmt: skip
    """The manoeuvre that tells these effects apart; fitted to `logs` each, or, without any, of typical size.

    One that the model has is taken out of it, and counts with the model's values. Raises PlanError, CompareError,
    ModelError.
    """
    own = {a.name: {(a.name, key): value for key, value in a.values.items()} for a in model.effects if a.name in names}
    for name in own:
        model = model.without_effect(name)
    known: dict[str, Values] = {name: own.get(name, {}) for name in names}
    if not logs or len(set(names)) < 2:
        return decide(model, known, None, envelope, effects=effects)
    target = campaign(logs, model, extra=effects)
    tried = tried_on(model, names, effects)
    known = {name: _fitted(target, tried[name], {}) for name in names}
    return decide(model, known, target.noise(), envelope, effects=effects, beside=target.count)
