"""SpeedAction: absolute or relative target, once or continuously."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from openscenario import model
from openscenario.storyboard.dynamics import Transition, span
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.registry import Runner, action, entity_called

if TYPE_CHECKING:
    from openscenario.storyboard.engine import Storyboard


class Speed:
    """Brings the speed to its target along the shape, and keeps it there if the target is continuous.

    A vehicle goes no faster than its performance says, and changes its speed no faster: upwards with its acceleration,
    downwards, be it to go backwards, with its deceleration.

    `distance` is taken as the time in which a symmetric shape covers it, T = 2 d / (v0 + v1): a start from
    standstill has a solution too. A continuous relative target moves along while it is approached; such an action
    ends only when another one takes over.
    """

    __slots__ = ("_change", "_continuous", "_dynamics", "_entity", "_wanted")
    domains: tuple[str, ...] = ("longitudinal",)

    def __init__(self, element: model.SpeedAction, entity: Entity, board: Storyboard) -> None:
        self._entity = entity
        self._dynamics = element.speed_action_dynamics
        self._wanted, self._continuous = _target(element.speed_action_target, board)
        self._change = Transition("step", 0.0, 0.0, 0.0)

    def _target(self) -> float:
        top = self._entity.max_speed
        return min(max(self._wanted(), -top), top)

    def start(self) -> bool:
        entity = self._entity
        target = self._target()
        entity.set_speed = target
        duration = self._duration(entity.speed, target)
        shape = self._dynamics.dynamics_shape
        self._change = Transition(shape, duration, entity.speed, target)
        if self._change.span <= 0.0:
            self._change.advance(0.0)
            entity.jump_to_speed(target)
            return not self._continuous
        return False

    def _duration(self, speed: float, target: float) -> float:
        dynamics = self._dynamics
        duration = span(dynamics.dynamics_shape, dynamics.dynamics_dimension, dynamics.value, target - speed)
        if dynamics.dynamics_dimension == "distance":
            duration = _time_over(duration, speed, target)
        if duration == 0.0:
            return 0.0
        # no faster than the vehicle can
        entity = self._entity
        limit = entity.max_acceleration if target > speed else entity.max_deceleration
        return max(duration, span(dynamics.dynamics_shape, "rate", limit, target - speed) if limit > 0.0 else 0.0)

    def step(self, dt: float) -> bool:
        entity = self._entity
        change = self._change
        if self._continuous:
            change.target = entity.set_speed = self._target()
            elapsed = change.elapsed
            wanted = change.advance(dt)
            if self._dynamics.dynamics_shape != "step":
                most = entity.max_acceleration if wanted > entity.speed else entity.max_deceleration
                required = abs(wanted - entity.speed)
                if required > most * dt:
                    # slower than the shape: it waits for the vehicle
                    if change.elapsed < change.span:
                        change.elapsed = elapsed + dt * most * dt / required
                        change.done = False
                    wanted = entity.speed + math.copysign(most * dt, wanted - entity.speed)
            entity.speed = wanted
            return False
        entity.speed = change.advance(dt)
        return change.done

    def stop(self) -> None:
        return None

    def ask(self) -> tuple[str, dict[str, Any], float]:
        target = self._target()
        self._entity.set_speed = target
        dynamics = self._dynamics
        duration = self._duration(self._entity.speed, target)
        if not math.isfinite(duration) or dynamics.dynamics_shape == "step":
            duration = 0.0
        return "speed", {"target": target, "shape": dynamics.dynamics_shape, "duration": duration}, duration


def _time_over(distance: float, speed: float, target: float) -> float:
    """Time [s] in which a change of speed covers `distance` [m].

    Where the speed changes its sign both parts count, each with its share v^2 / (v0^2 + v1^2) of the distance.
    """
    if speed * target < 0.0:
        share = speed * speed / (speed * speed + target * target)
        return 2.0 * distance * (share / abs(speed) + (1.0 - share) / abs(target))
    both = abs(speed + target)
    return 2.0 * distance / both if both > 0.0 else 0.0


def _target(target: model.SpeedActionTarget, board: Storyboard) -> tuple[Callable[[], float], bool]:
    """A function that gives the wanted speed [m/s] now, and whether it is to be followed continuously."""
    if isinstance(target, model.AbsoluteTargetSpeed):
        value = target.value
        return (lambda: value), False
    other, amount = entity_called(target.entity_ref, board, target), target.value
    if target.speed_target_value_type == "delta":
        return (lambda: other.speed + amount), target.continuous
    return (lambda: other.speed * amount), target.continuous


@action(model.SpeedAction)
def speed(element: model.SpeedAction, entity: Entity, board: Storyboard) -> Runner:
    return Speed(element, entity, board)
