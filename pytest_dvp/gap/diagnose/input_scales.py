"""Scales of a model's inputs that are no physical quantity: pedals, motor current, normalised steering."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING

from pytest_dvp.gap.diagnose.least_squares import Coordinate

USUAL = {"full_throttle": (0.5, 15.0), "full_brake": (1.0, 15.0)}
"""m/s^2 that a full pedal gives on a road car: below a truck uphill, above a racing car on slicks."""

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel


def repeats(effect: Effect, scales: Iterable[Coordinate]) -> bool:
    """True if data cannot tell the effect from one of these scales of the input map, which are fitted anyway."""
    return any(c.key.name in effect.diagnosed.input_scales for c in scales)


def input_map(model: VehicleModel) -> tuple[tuple[Coordinate, ...], dict[tuple[str, str], float]]:
    """What is fitted along with every set of effects, as nobody knows it before, and where that begins."""
    from vehicle.model.command_inputs import INPUT_KEYS

    inputs, wanted = model.inputs, []
    if inputs.steer not in ("steer_cmd", "steer"):
        wanted.append("steer_scale")
    if inputs.longitudinal[0] in ("throttle_cmd", "motor_current"):
        wanted.append("full_throttle")
        if len(inputs.longitudinal) == 2 or inputs.longitudinal[0] == "motor_current":
            wanted.append("full_brake")
    keys = [k for k in INPUT_KEYS if k.name in wanted]
    return tuple(Coordinate("inputs", k) for k in keys), {("inputs", k.name): getattr(inputs, k.name) for k in keys}


def free_scales(
    model: VehicleModel, effects: Sequence[Effect]
) -> tuple[tuple[Coordinate, ...], dict[tuple[str, str], float]]:
    """What `input_map` says, without the scales that one of the effects repeats."""
    nuisance, start = input_map(model)
    return tuple(c for c in nuisance if not any(repeats(effect, [c]) for effect in effects)), start


def implausible_scales(values: Mapping[str, float]) -> list[str]:
    """A line for each fitted scale that no pedal of a car has, by key; the other values of such a fit mean little."""
    return [
        f"{key} = {value:.3g} m/s^2 is not what a full pedal does, {low:g} to {high:g}"
        for key, value in values.items()
        for low, high in (USUAL.get(key, (-inf, inf)),)
        if not low <= value <= high
    ]
