"""Scales of a model's inputs that are no physical quantity: pedals, motor current, normalised steering."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING

from pytest_dvp.gap.diagnose.least_squares import Coordinate

USUAL = {"full_throttle": (0.5, 15.0), "full_brake": (1.0, 15.0)}
"""m/s^2 that a full pedal gives on a road car: below a truck uphill, above a racing car on slicks."""
FULL = {
    "brake_pressure": (6e5, 2e7),  # Pa; chosen: a worn air brake (8.5e5 and more when full), an ESC pump at its limit
    "motor_current": (20.0, 1000.0),  # A; chosen: a small robot at 48 V, a sports car
}
"""Where no pedal is logged: what the strongest command of a vehicle is."""


if TYPE_CHECKING:
    from vehicle.model.command_inputs import Inputs
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


def implausible_scales(values: Mapping[str, float], inputs: Inputs) -> list[str]:
    """A line for each fitted scale that no pedal of a car has, by key; the other values of such a fit mean little.

    A pressure or a current that counts as full is a convention of the model file and no pedal, so with these the range
    is that of all vehicles: air brakes give their most at a fifth of the pressure of hydraulic ones.
    """
    lines = []
    for key, value in values.items():
        low, high = USUAL.get(key, (-inf, inf))
        what = "a full pedal does"
        if key in USUAL and (column := _not_a_pedal(key, inputs)):
            full, (least, most) = getattr(inputs, f"full_{column.partition('_')[2]}"), FULL[column]
            low, high = low * full / most, high * full / least
            what = f"{full:g} {'Pa' if column == 'brake_pressure' else 'A'} do"
        if not low <= value <= high:
            lines.append(f"{key} = {value:.3g} m/s^2 is not what {what}, {low:.3g} to {high:.3g}")
    return lines


def _not_a_pedal(key: str, inputs: Inputs) -> str:
    """The column in place of this pedal; "" if it is one."""
    if "motor_current" in inputs.longitudinal:
        return "motor_current"
    return "brake_pressure" if key == "full_brake" and "brake_pressure" in inputs.longitudinal else ""
