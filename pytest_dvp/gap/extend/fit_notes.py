"""What is to be known of the values of a fit, a line each."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from pytest_dvp.gap.diagnose.fitted_values import rounded
from pytest_dvp.gap.diagnose.trial import Trial

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import VehicleModel


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
