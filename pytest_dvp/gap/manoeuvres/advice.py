"""What to drive next, from what a diagnosis could not tell."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from pytest_dvp.gap.diagnose.candidates import Candidate, candidates
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, Values, experiment_set
from pytest_dvp.gap.diagnose.least_squares import Fit, fit
from pytest_dvp.gap.diagnose.linear_algebra import square
from pytest_dvp.gap.manoeuvres.catalogue import MANOEUVRES, Manoeuvre
from pytest_dvp.gap.manoeuvres.choice import Choice, PlanError, candidates_by_name
from pytest_dvp.gap.manoeuvres.discrimination import Evidence, decide
from pytest_dvp.gap.manoeuvres.driving_limits import Envelope
from pytest_dvp.gap.manoeuvres.exciting_manoeuvres import excite
from pytest_dvp.logs.log import Log

if TYPE_CHECKING:
    from pytest_dvp.gap.diagnose.diagnosis import Diagnosis
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel

MOST_RIVALS = 4  # of one effect that a manoeuvre is to tell apart: the best
_NEAR = 0.25  # of max(1, chi^2/N): an effect that is behind by less may come back when other data are added
_SCANNED, _MOST_NEAR = 8, 4


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
           effects: Sequence[Effect] = (), exciting: bool = True,
           manoeuvres: Sequence[Manoeuvre] = MANOEUVRES) -> Advice:  # fmt: skip
    """Manoeuvres for the rivals and, with `exciting`, for the effects that `logs` could not show.

    Raises CompareError or ModelError as `diagnose` does.
    """
    target = experiment_set(logs, model, extra=effects)
    noise, values = dict(found.noise_floor), dict(found.values)
    deciding: dict[str, Choice] = {}
    refused: list[str] = []
    for effect in found.effects:
        if not effect.rivals or effect.action == "remove":
            continue
        names = (effect.name, *effect.rivals[:MOST_RIVALS])
        rest = {key: value for key, value in values.items() if key[0] != effect.name}
        first = {key: value for key, value in values.items() if key[0] == effect.name}
        known, evidence = _hypotheses(target, model, names, first, rest, effects)
        try:
            deciding[effect.name] = decide(
                model,
                known,
                noise,
                envelope,
                evidence=evidence,
                shared=rest,
                effects=effects,
                manoeuvres=manoeuvres,
            )
        except PlanError as error:
            refused.append(f"{' or '.join(names)}: {error}")
    chosen: tuple[Choice, ...] = ()
    if exciting and found.not_excited:
        try:
            chosen = excite(
                model,
                found.not_excited,
                noise,
                envelope,
                shared=values,
                effects=effects,
                beside=target.count,
                manoeuvres=manoeuvres,
            )
        except PlanError as error:
            refused.append(str(error))
    return Advice(deciding, chosen, tuple(refused))


def _hypotheses(target: ExperimentSet, model: VehicleModel, names: Sequence[str], first: Values, rest: Values,
                effects: Sequence[Effect]) -> tuple[dict[str, Values], Evidence]:  # fmt: skip
    """Every name fitted to the logs (the first as given), and how well they and those hardly ruled out do."""
    from vehicle.model.effect_catalogue import catalogue

    every = candidates(model, [*catalogue().values(), *effects])
    known = candidates_by_name(model, names, effects) | {c.name: c for c in every}
    fits = {name: _fitted(target, known[name], rest) for name in names[1:]}
    left = {name: found.chi2 for name, found in fits.items()} | {names[0]: square(target.whitened({**rest, **first}))}
    worth = target.count * max(1.0, left[names[0]] / max(target.count, 1))
    scanned = sorted(
        (min(square(target.whitened({**rest, **point})) for point in c.points), c.name) for c in every
        if c.name not in names and (c.name, c.coordinates[0].key.name) not in rest
    )  # fmt: skip
    near: dict[str, Values] = {}
    for _, name in scanned[:_SCANNED]:
        found = _fitted(target, known[name], rest)
        if found.chi2 - left[names[0]] < _NEAR * worth and len(near) < _MOST_NEAR:
            near[name], left[name] = found.values, found.chi2
    return {names[0]: first, **{name: f.values for name, f in fits.items()}}, Evidence(target.count, left, near)


def _fitted(target: ExperimentSet, candidate: Candidate, rest: Values) -> Fit:
    begin = min(candidate.points, key=lambda point: square(target.whitened({**rest, **point})))
    return fit(target, candidate.coordinates, begin, fixed=rest)


def between(names: Sequence[str], logs: Mapping[str, Log], model: VehicleModel, envelope: Envelope, *,
            effects: Sequence[Effect] = (), manoeuvres: Sequence[Manoeuvre] = MANOEUVRES) -> Choice:  # fmt: skip
    """The manoeuvre that tells these effects apart; fitted to `logs` each, or, without any, of typical size.

    One that the model has is taken out of it, and counts with the model's values. Raises PlanError, CompareError,
    ModelError.
    """
    own = {a.name: {(a.name, key): value for key, value in a.values.items()} for a in model.effects if a.name in names}
    for name in own:
        model = model.without_effect(name)
    known: dict[str, Values] = {name: own.get(name, {}) for name in names}
    if not logs or len(set(names)) < 2:
        return decide(model, known, None, envelope, effects=effects, manoeuvres=manoeuvres)
    target = experiment_set(logs, model, extra=effects)
    tried = candidates_by_name(model, names, effects)
    fits = {name: _fitted(target, tried[name], {}) for name in names}
    known = {name: found.values for name, found in fits.items()}
    evidence = Evidence(target.count, {name: found.chi2 for name, found in fits.items()})
    return decide(model, known, target.noise(), envelope, evidence=evidence, effects=effects, manoeuvres=manoeuvres)


def showing(
    names: Sequence[str],
    logs: Mapping[str, Log],
    model: VehicleModel,
    envelope: Envelope,
    *,
    effects: Sequence[Effect] = (),
    manoeuvres: Sequence[Manoeuvre] = MANOEUVRES,
) -> tuple[Choice, ...]:
    """The manoeuvres that show these effects: in logs with the noise of `logs` and beside their samples, or, without
    any, alone. Raises PlanError, CompareError, ModelError."""
    if not logs:
        return excite(model, names, None, envelope, effects=effects, manoeuvres=manoeuvres)
    target = experiment_set(logs, model, extra=effects)
    return excite(
        model, names, target.noise(), envelope, effects=effects, beside=target.count, manoeuvres=manoeuvres
    )  # fmt: skip
