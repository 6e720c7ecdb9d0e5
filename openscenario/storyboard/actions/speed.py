"""SpeedAction: absolute or relative target, reached once or kept continuously."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from openscenario import model
from openscenario.storyboard.dynamics import AREAS, SAME, Transition, span
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.registry import action, entity_called
from openscenario.storyboard.runner import Runner

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board

FASTEST = 1e4  # m/s, the largest speed that is read from a file: who has no performance is not infinitely fast


class Speed:
    """Brings the speed to its target along the shape, and keeps it there if the target is continuous.

    A vehicle goes no faster than its performance says, and changes its speed no faster: upwards with its acceleration,
    downwards, be it to go backwards, with its deceleration. Only a step sets the speed at once, and only at its start.

    A target relative to another entity moves with it until it is reached, and for as long as the action runs if it is
    continuous; one relative to the own speed is that of the start. For a target that moves

    - `time` is the time after which the present target is reached,
    - `rate` the (peak) rate at which the speed goes there,
    - `distance` the whole way on which it gets there.

    `distance` is taken as the time in which a symmetric shape covers it, T = 2 d / (v0 + v1): a start from
    standstill has a solution too. Who is slower than the shape because of the vehicle's limits goes on with it later.
    """

    __slots__ = ("_began", "_change", "_continuous", "_dynamics", "_entity", "_follows", "_reached", "_wanted")
    domains: tuple[str, ...] = ("longitudinal",)

    def __init__(self, element: model.SpeedAction, entity: Entity, board: Board) -> None:
        self._entity = entity
        self._dynamics = element.speed_action_dynamics
        self._wanted, self._follows, self._continuous = _target(element.speed_action_target, entity, board)
        self._change = Transition("step", 0.0, 0.0, 0.0)
        self._began = 0.0
        self._reached = False

    def _target(self) -> float:
        top = min(self._entity.max_speed, FASTEST)
        return min(max(self._wanted(), -top), top)

    def start(self) -> bool:
        """Begin the change; a step sets the speed at once. True if that was all."""
        entity = self._entity
        target = self._target()
        entity.set_speed = target
        duration = self._duration(entity.speed, target)
        shape = self._dynamics.dynamics_shape
        self._began = entity.travelled
        self._change = Transition(shape, duration, entity.speed, target)
        if self._change.span <= 0.0:
            self._change.advance(0.0)
            self._reached = True
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
        """Go on along the shape for `dt` [s]; True at the target unless it is continuous."""
        entity, change = self._entity, self._change
        target = change.target
        if self._follows:
            target = entity.set_speed = self._target()
            if target != change.target:
                self._retarget(target)
                change = self._change
        elapsed = change.elapsed
        wanted = change.advance(dt)
        most = self._most(wanted) * dt
        required = abs(wanted - entity.speed)
        if required > most + SAME:
            # slower than the shape: it waits for the vehicle, which friction may have slowed down
            if change.elapsed < change.span:
                change.elapsed = elapsed + dt * most / required
                change.done = False
            wanted = entity.speed + math.copysign(most, wanted - entity.speed)
        entity.speed = wanted
        self._reached = self._reached or (change.done and abs(wanted - target) < SAME)
        return self._reached and not self._continuous

    def _most(self, wanted: float) -> float:
        """How fast the speed may change towards `wanted` [m/s^2]; a rate is how the target is reached, not kept."""
        entity, dynamics = self._entity, self._dynamics
        most = entity.max_acceleration if wanted > entity.speed else entity.max_deceleration
        by_rate = dynamics.dynamics_dimension == "rate" and dynamics.dynamics_shape != "step"
        if self._follows and by_rate and not self._reached:
            return min(most, abs(dynamics.value))
        return most

    def _retarget(self, target: float) -> None:
        """Go on to a target that has moved."""
        change, dynamics = self._change, self._dynamics
        change.target = target
        if change.done or math.isinf(change.span):
            return
        shape, part = dynamics.dynamics_shape, change.elapsed / change.span
        if dynamics.dynamics_dimension == "rate" and shape == "linear":
            speed = self._entity.speed
            self._change = Transition(shape, self._duration(speed, target), speed, target)
        elif dynamics.dynamics_dimension == "rate":
            change.span = self._duration(change.start, target)
            change.elapsed = part * change.span
        elif dynamics.dynamics_dimension == "distance":
            left = abs(dynamics.value) - (self._entity.travelled - self._began)
            # way per second of the whole transition that is still to come
            rest = (1.0 - part) * change.start + (target - change.start) * (0.5 - AREAS[shape](part))
            if change.start * target >= 0.0 and rest != 0.0 and left > 0.0:
                change.span = left / abs(rest)
                change.elapsed = part * change.span

    def stop(self) -> None:
        """Do nothing: the entity keeps its speed."""

    def ask(self) -> tuple[str, dict[str, Any], float]:
        """A request "speed" with target [m/s], shape and duration [s]; it lasts as long as the change would."""
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


def _target(target: model.SpeedActionTarget, entity: Entity, board: Board) -> tuple[Callable[[], float], bool, bool]:
    """A function that gives the wanted speed [m/s] now, whether that moves, and whether it is kept once reached."""
    if isinstance(target, model.AbsoluteTargetSpeed):
        value = target.value
        return (lambda: value), False, False
    other, amount = entity_called(target.entity_ref, board, target), target.value
    delta = target.speed_target_value_type == "delta"
    if other is entity:
        once = other.speed + amount if delta else other.speed * amount
        return (lambda: once), False, target.continuous
    if delta:
        return (lambda: other.speed + amount), True, target.continuous
    return (lambda: other.speed * amount), True, target.continuous


@action(model.SpeedAction)
def speed(element: model.SpeedAction, entity: Entity, board: Board) -> Runner:
    """Bring the speed to a target, of the entity's own or relative to another's."""
    return Speed(element, entity, board)
