"""AppearanceAction: lights and animations. Nothing here sees them, but an action takes its time."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from openscenario import model
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.registry import action
from openscenario.storyboard.runner import Instant, Runner

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board


class Wait:
    """Over after `duration` [s]."""

    __slots__ = ("_left", "domains")

    def __init__(self, duration: float, domains: tuple[str, ...] = ()) -> None:
        self._left = duration
        self.domains = domains

    def start(self) -> bool:
        """Begin to wait; True if the duration is 0."""
        return self._left <= 0.0

    def step(self, dt: float) -> bool:
        """Wait for another `dt` [s]; True when the duration is over."""
        self._left -= dt
        return self._left <= 1e-9

    def stop(self) -> None:
        """Do nothing: nothing is held."""


class Flash:
    """A light that flashes until another action takes it (annex A has the like: an animation in a loop has no regular
    ending)."""

    __slots__ = ("domains",)

    def __init__(self, light: str) -> None:
        self.domains: tuple[str, ...] = (light,)

    def start(self) -> bool:
        """Take the light; False, as flashing does not end."""
        return False

    def step(self, dt: float) -> bool:
        """Flash for another `dt` [s]; always False."""
        return False

    def stop(self) -> None:
        """Do nothing: the action that takes the light sets it."""


@action(model.AppearanceAction)
def appearance(element: model.AppearanceAction, entity: Entity, board: Board) -> Runner:
    """No sensor model here sees lights and animations. A change of lights lasts its transition time, flashing until
    another action takes the same light, an animation its duration, one in a loop until it is stopped."""
    light, animation = element.light_state_action, element.animation_action
    if light is not None:
        kind = light.light_type
        name = kind.vehicle_light_type if isinstance(kind, model.VehicleLight) else kind.user_defined_light_type
        if light.light_state.mode == "flashing":
            return Flash(name)
        return Wait(light.transition_time, (name,))
    if animation is not None:
        return Wait(math.inf if animation.loop else animation.animation_duration or 0.0)
    return Instant()
