"""A model with the values that a fit gave its effects, each with its interval and where it comes from."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from pytest_dvp.gap.diagnose.diagnosis import Estimate
from pytest_dvp.gap.diagnose.fitted_values import rounded
from pytest_dvp.gap.diagnose.trial import Trial

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel


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
