"""Conditions on how one entity moves: speed, acceleration, standing still, distance travelled."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from openscenario import model
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.registry import Scope, condition, entity_called
from openscenario.storyboard.triggers import Test
from openscenario.storyboard.values import COMPARISONS

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board

RESOLUTION = 1e-9  # s


@condition(model.SpeedCondition)
def speed(element: model.SpeedCondition, entity: Entity, scope: Scope) -> Test:
    """Compares the entity's speed [m/s], in all or in one direction, with a value."""
    holds, value = COMPARISONS[element.rule], element.value
    of = _speed(element.direction)
    return lambda: holds(of(entity), value)


@condition(model.RelativeSpeedCondition)
def relative_speed(element: model.RelativeSpeedCondition, entity: Entity, scope: Scope) -> Test:
    """Speed of the triggering entity minus that of the other; with a direction, in the triggering entity's frame."""
    other = entity_called(element.entity_ref, scope.board)
    holds, value, direction = COMPARISONS[element.rule], element.value, element.direction
    if direction is None:
        return lambda: other.active and holds(entity.speed - other.speed, value)
    if direction == "vertical":
        return lambda: other.active and holds(0.0, value)
    turn = 0.0 if direction == "longitudinal" else 0.5 * math.pi

    def test() -> bool:
        if not other.active:
            return False
        axis = entity.h + turn
        c, s = math.cos(axis), math.sin(axis)
        return holds((entity.vx - other.vx) * c + (entity.vy - other.vy) * s, value)

    return test


@condition(model.AccelerationCondition)
def acceleration(element: model.AccelerationCondition, entity: Entity, scope: Scope) -> Test:
    """Without a direction the magnitude (1.2 and later: "absolute value"); the lateral one is what the velocity changed
    to the left since the last evaluation."""
    holds, value, direction = COMPARISONS[element.rule], element.value, element.direction
    if direction == "longitudinal":
        return lambda: holds(entity.ax, value)
    if direction == "vertical":
        return lambda: holds(0.0, value)
    lateral = _lateral(entity, scope.board)
    if direction == "lateral":
        return lambda: holds(lateral(), value)
    return lambda: holds(math.hypot(entity.ax, lateral()), value)


def _lateral(entity: Entity, board: Board) -> Callable[[], float]:
    """Acceleration [m/s^2] to the left of an entity, from how its velocity changes; 0 at the first evaluation."""
    before, vx, vy = math.inf, entity.vx, entity.vy

    def now() -> float:
        nonlocal before, vx, vy
        dt, ax, ay = board.time - before, entity.vx - vx, entity.vy - vy
        before, vx, vy = board.time, entity.vx, entity.vy
        if dt <= 0.0:
            return 0.0
        return (ay * math.cos(entity.h) - ax * math.sin(entity.h)) / dt

    return now


def _speed(direction: str | None) -> Callable[[Entity], float]:
    if direction is None or direction == "longitudinal":
        return lambda entity: entity.speed
    if direction == "lateral":
        return lambda entity: entity.vy * math.cos(entity.h) - entity.vx * math.sin(entity.h)
    return lambda entity: 0.0


@condition(model.StandStillCondition)
def stand_still(element: model.StandStillCondition, entity: Entity, scope: Scope) -> Test:
    """True once the entity has stood for the duration [s]. The ego stands below 0.1 m/s: its speed may be measured."""
    duration, board = element.duration, scope.board
    return lambda: board.time - entity.still_since >= duration - RESOLUTION


@condition(model.TraveledDistanceCondition)
def travelled(element: model.TraveledDistanceCondition, entity: Entity, scope: Scope) -> Test:
    """True once the entity has gone so far [m] since it came."""
    value = element.value
    return lambda: entity.travelled >= value - 1e-6
