"""Conditions on how one entity moves: speed, acceleration, standing still, distance travelled."""

from __future__ import annotations

import math
from collections.abc import Callable

from openscenario import model
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.registry import Scope, Unsupported, condition
from openscenario.storyboard.triggers import Test
from openscenario.storyboard.values import COMPARISONS

RESOLUTION = 1e-9  # s


@condition(model.SpeedCondition)
def speed(element: model.SpeedCondition, entity: Entity, scope: Scope) -> Test:
    holds, value = COMPARISONS[element.rule], element.value
    of = _speed(element.direction)
    return lambda: holds(of(entity), value)


@condition(model.RelativeSpeedCondition)
def relative_speed(element: model.RelativeSpeedCondition, entity: Entity, scope: Scope) -> Test:
    """Speed of the triggering entity minus that of the other; with a direction, in the triggering entity's frame."""
    entities = scope.board.entities
    if element.entity_ref not in entities:
        raise Unsupported("no entity of this name", element.entity_ref, ", ".join(entities))
    other = entities[element.entity_ref]
    holds, value, direction = COMPARISONS[element.rule], element.value, element.direction
    if direction is None:
        return lambda: holds(entity.speed - other.speed, value)
    if direction == "vertical":
        return lambda: holds(0.0, value)
    turn = 0.0 if direction == "longitudinal" else 0.5 * math.pi

    def test() -> bool:
        axis = entity.h + turn
        c, s = math.cos(axis), math.sin(axis)
        return holds((entity.vx - other.vx) * c + (entity.vy - other.vy) * s, value)

    return test


@condition(model.AccelerationCondition)
def acceleration(element: model.AccelerationCondition, entity: Entity, scope: Scope) -> Test:
    """Without a direction the magnitude (1.2 and later: "absolute value"); the lateral one is speed times yaw rate."""
    holds, value, direction = COMPARISONS[element.rule], element.value, element.direction
    if direction == "longitudinal":
        return lambda: holds(entity.ax, value)
    if direction == "vertical":
        return lambda: holds(0.0, value)
    if direction == "lateral":
        raise Unsupported("lateral acceleration is not known", "lateral", "longitudinal, vertical or none")
    return lambda: holds(abs(entity.ax), value)


def _speed(direction: str | None) -> Callable[[Entity], float]:
    if direction is None or direction == "longitudinal":
        return lambda entity: entity.speed
    if direction == "lateral":
        return lambda entity: entity.vy * math.cos(entity.h) - entity.vx * math.sin(entity.h)
    return lambda entity: 0.0


@condition(model.StandStillCondition)
def stand_still(element: model.StandStillCondition, entity: Entity, scope: Scope) -> Test:
    duration, board = element.duration, scope.board
    return lambda: board.time - entity.still_since >= duration - RESOLUTION


@condition(model.TraveledDistanceCondition)
def travelled(element: model.TraveledDistanceCondition, entity: Entity, scope: Scope) -> Test:
    value = element.value
    return lambda: entity.travelled >= value - 1e-6
