"""A model with the values that a fit gave its effects, each with its interval and where it comes from."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any

from pytest_dvp.gap.diagnose.diagnosis import Estimate
from pytest_dvp.gap.diagnose.fitted_values import rounded
from pytest_dvp.gap.diagnose.trial import Trial

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel


def values_of(model: VehicleModel) -> dict[tuple[str, str], float]:
    """What the model's effects are set to, where a fit can begin."""
    return {
        (a.name, key.name): a.values[key.name] for a in model.effects for key in a.effect.parameters
        if isfinite(a.values[key.name])
    }  # fmt: skip


def fitted_model(
    model: VehicleModel, final: Trial, sure: Mapping[tuple[str, str], Estimate], remove: Sequence[str],
    added: Sequence[Effect], fitted_on: tuple[str, ...],
) -> VehicleModel:  # fmt: skip
    """The model without the effects `remove`, with those `added`, and the values of a fit (`sure`; of the car what
    `final` says). fitted_on: what the file says of the logs, beside each value."""
    from vehicle.model.vehicle_model import AppliedEffect, Interval

    for name in remove:
        model = model.without_effect(name)
    scales: dict[str, Any] = {key: value.value for (effect, key), value in sure.items() if effect == "inputs"}
    car = {key: rounded(value) for (effect, key), value in final.values.items() if effect == "parameters"}
    model = dataclasses.replace(model, inputs=dataclasses.replace(model.inputs, **scales)).with_car(car)
    present = {a.name: a for a in model.effects}
    for effect in [*(a.effect for a in model.effects), *(e for e in added if e.name not in present)]:
        fits = {key: value for (name, key), value in sure.items() if name == effect.name}
        if fits:
            old = dict(present[effect.name].values) if effect.name in present else {}
            present[effect.name] = AppliedEffect(
                effect,
                effect.complete({**old, **{key: value.value for key, value in fits.items()}}),
                {key: Interval(value.low, value.high) for key, value in fits.items()},
                fitted_on,
            )
    return dataclasses.replace(model, effects=tuple(present.values()))


def edges(final: Trial) -> Iterator[str]:
    """A line for each value that stands where its search ends."""
    for c in final.fit.coordinates:
        if c.is_at_limit(final.values[c.name]):
            value = f"{c.effect}.{c.key.name} = {final.values[c.name]:.4g} {c.key.unit}"
            yield f"{value} stands where the search ends: no estimate; something else may be missing"


def assumed(final: Trial, model: VehicleModel) -> Iterator[str]:
    """A line for each number of the car itself that a fit has changed."""
    given = model.car.values()
    for (effect, key), value in final.values.items():
        if effect == "parameters" and abs(value - given[key]) > 1e-9:
            yield f"[parameters] {key} is {rounded(value):g} in the new model instead of {given[key]:g}: fits better"
