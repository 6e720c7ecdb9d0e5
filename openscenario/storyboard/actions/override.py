"""OverrideControllerValueAction: the scenario moves pedals, steering wheel and gear of a vehicle itself."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from openscenario import model
from openscenario.storyboard.controls import NEUTRAL, Controls, Setting

if TYPE_CHECKING:
    from openscenario.storyboard.entity import Entity

AUTOMATIC = {"n": NEUTRAL, "p": "park", "r": "reverse", "d": "drive"}
Braking = model.OverrideBrakeAction | model.OverrideParkingBrakeAction


def take(element: model.OverrideControllerValueAction, entity: Entity) -> None:
    """Set the levers that the action names; those that are not active are let go."""
    settings: dict[str, Setting | None] = {}
    for name in ("throttle", "clutch", "steering_wheel"):
        lever = getattr(element, name)
        if lever is not None:
            value = lever.value if name == "steering_wheel" else min(max(lever.value, 0.0), 1.0)
            settings[name] = Setting(value, _rate(lever.max_rate)) if lever.active else None
    for name, braking in (("brake", element.brake), ("parking_brake", element.parking_brake)):
        if braking is not None:
            settings[name] = _brake(braking, entity) if braking.active else None
    if entity.controls is None:
        entity.controls = Controls()
    entity.controls.set(settings, None if element.gear is None else _gear(element.gear))


def _rate(rate: float | None) -> float:
    return math.inf if rate is None else rate


def _brake(element: Braking, entity: Entity) -> Setting:
    """A brake in parts of the full one, of whichever kind the file states it."""
    given = element.brake_input
    if isinstance(given, model.BrakeForce):  # newtons; the full brake makes maxDeceleration of the mass
        full = entity.mass * entity.able[1]
        share = 1.0 / full if 0.0 < full < math.inf else 0.0
        return Setting(min(max(given.value * share, 0.0), 1.0), _rate(given.max_rate) * share)
    value = element.value if given is None else given.value
    return Setting(min(max(value or 0.0, 0.0), 1.0), _rate(None if given is None else given.max_rate))


def _gear(element: model.OverrideGearAction) -> str:
    if not element.active:
        return ""
    if isinstance(element.gear, model.AutomaticGear):
        return AUTOMATIC[element.gear.gear]
    number = element.gear.number if isinstance(element.gear, model.ManualGear) else int(element.number or 0)
    return "drive" if number > 0 else "reverse" if number < 0 else NEUTRAL
