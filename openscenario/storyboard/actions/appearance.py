"""AppearanceAction: lights and animations. Nothing here sees them, but an action takes its time."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from openscenario import model
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.registry import Instant, Runner, action

if TYPE_CHECKING:
    from openscenario.storyboard.engine import Storyboard


class Wait:
    """Over after `duration` [s]."""

    __slots__ = ("_left",)
    domains: tuple[str, ...] = ()

    def __init__(self, duration: float) -> None:
        self._left = duration

    def start(self) -> bool:
        return self._left <= 0.0

    def step(self, dt: float) -> bool:
        self._left -= dt
        return self._left <= 1e-9

    def stop(self) -> None:
        return None


@action(model.AppearanceAction)
def appearance(element: model.AppearanceAction, entity: Entity, board: Storyboard) -> Runner:
    """No sensor model here sees lights and animations. A change of lights lasts its transition time (flashing begins
    when it is over), an animation its duration, one in a loop until it is stopped."""
    light, animation = element.light_state_action, element.animation_action
    if light is not None:
        return Wait(light.transition_time)
    if animation is not None:
        return Wait(math.inf if animation.loop else animation.animation_duration or 0.0)
    return Instant()
