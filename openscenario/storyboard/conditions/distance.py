"""Conditions on distances: to an entity, to a position, and in time (headway, time to collision)."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from openscenario import model
from openscenario.storyboard.actions.trajectory import FollowTrajectory
from openscenario.storyboard.distances import Measure, measure
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.places import Place
from openscenario.storyboard.positions import resolver
from openscenario.storyboard.registry import Scope, condition, entity_called
from openscenario.storyboard.triggers import Test
from openscenario.storyboard.unsupported import Unsupported
from openscenario.storyboard.values import COMPARISONS

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board
    from openscenario.storyboard.ground import Ground

SLOW = 1e-6  # m/s: no time to anything at this speed
NONE = 1e-6  # m: no distance


def _dimension(kind: str | None, system: str | None, along_route: bool | None) -> tuple[str, str | None]:
    """What to measure, in which system. `alongRoute` (deprecated since 1.1), if nothing else is said: whether the turns
    of the road lengthen what is else the straight line."""
    if along_route is not None and kind is None and system is None:
        return ("alongRoute", "road") if along_route else ("euclidianDistance", None)
    return kind or "euclidianDistance", system


def _compare(distance: Measure, other: Entity | None, rule: str, value: float) -> Test:
    """Who cannot be reached is infinitely far away; who has been deleted is at no distance."""
    holds = COMPARISONS[rule]

    def test() -> bool:
        if other is not None and not other.active:
            return False
        now = distance()
        return holds(math.inf if now is None else abs(now), value)

    return test


@condition(model.RelativeDistanceCondition)
def relative_distance(element: model.RelativeDistanceCondition, entity: Entity, scope: Scope) -> Test:
    """Compares the distance [m] between two entities with a value."""
    other = entity_called(element.entity_ref, scope.board)
    kind, system = element.relative_distance_type, element.coordinate_system
    distance = measure(scope.board, entity, other, kind=kind, system=system, free=element.freespace)
    return _compare(distance, other, element.rule, element.value)


@condition(model.DistanceCondition)
def distance_to(element: model.DistanceCondition, entity: Entity, scope: Scope) -> Test:
    """`alongRoute`: see below."""
    kind, system = _dimension(element.relative_distance_type, element.coordinate_system, element.along_route)
    where = resolver(element.position, scope.board)
    distance = measure(scope.board, entity, where, kind=kind, system=system, free=element.freespace)
    return _compare(distance, None, element.rule, element.value)


@condition(model.ReachPositionCondition)
def reach_position(element: model.ReachPositionCondition, entity: Entity, scope: Scope) -> Test:
    """True while the entity is within `tolerance` [m] of the position, measured in the plane."""
    where, tolerance = resolver(element.position, scope.board), element.tolerance

    def test() -> bool:
        there = where()
        dx, dy = there.x - entity.x, there.y - entity.y
        return dx * dx + dy * dy <= tolerance * tolerance

    return test


@condition(model.TimeHeadwayCondition)
def time_headway(element: model.TimeHeadwayCondition, entity: Entity, scope: Scope) -> Test:
    """Distance to the other over the own speed; along the way not defined if the other is behind, infinite while
    standing. `alongRoute`: see below."""
    kind, system = _dimension(element.relative_distance_type, element.coordinate_system, element.along_route)
    other = entity_called(element.entity_ref, scope.board)
    distance = measure(scope.board, entity, other, kind=kind, system=system, free=element.freespace)
    holds, value = COMPARISONS[element.rule], element.value
    ahead = kind != "lateral"

    def test() -> bool:
        if not other.active:
            return False
        apart = distance()
        if apart is None:
            apart = math.inf
        if apart < 0.0 and ahead:
            return False
        return holds(abs(apart) / entity.speed if entity.speed > SLOW else math.inf, value)

    return test


@condition(model.TimeToCollisionCondition)
def time_to_collision(element: model.TimeToCollisionCondition, entity: Entity, scope: Scope) -> Test:
    """Distance over closing speed; not defined while the two do not close in, or at no distance. `alongRoute`: see
    below.

    Raises Unsupported for a target that is neither an entity nor a position.
    """
    target = element.time_to_collision_condition_target
    other: Entity | Callable[[], Place]
    if target.entity_ref is not None:
        other = entity_called(target.entity_ref.entity_ref, scope.board)
    elif target.position is not None:
        other = resolver(target.position, scope.board)
    else:
        raise Unsupported("neither an entity nor a position to collide with")
    kind, system = _dimension(element.relative_distance_type, element.coordinate_system, element.along_route)
    distance = measure(scope.board, entity, other, kind=kind, system=system, free=element.freespace)
    closing = _closing(scope.board, entity, other, kind, system)
    holds, value = COMPARISONS[element.rule], element.value

    def test() -> bool:
        if isinstance(other, Entity) and not other.active:
            return False
        apart = distance()
        if apart is None:
            apart = math.inf
        if abs(apart) < NONE:
            return False
        speed = closing(apart)
        return speed > SLOW and holds(abs(apart) / speed, value)

    return test


def _closing(
    board: Board, entity: Entity, other: Entity | Callable[[], Place], kind: str, system: str | None
) -> Callable[[float], float]:
    """Rate [m/s] at which the distance shrinks, in the coordinates that it is measured in (1.3, class
    TimeToCollisionCondition: "the same coordinate system and relative distance type"); to something behind, that at
    which it catches up."""
    if kind in ("longitudinal", "lateral", "alongRoute"):
        turn = 0.5 * math.pi if kind == "lateral" else 0.0
        if system == "trajectory":
            return _closing_on_trajectory(entity, other, turn)
        if board.network is not None and (system in ("road", "lane") or kind == "alongRoute"):
            return _closing_on_road(board.ground, entity, other, turn)

        def along(apart: float) -> float:
            axis = (0.0 if system == "world" else entity.h) + turn
            c, s = math.cos(axis), math.sin(axis)
            vx, vy = (other.vx, other.vy) if isinstance(other, Entity) else (0.0, 0.0)
            rate = (entity.vx - vx) * c + (entity.vy - vy) * s
            return rate if apart >= 0.0 else -rate

        return along

    def straight(apart: float) -> float:
        there = other if isinstance(other, Entity) else other()
        dx, dy = there.x - entity.x, there.y - entity.y
        length = math.hypot(dx, dy)
        if length <= 0.0:
            return 0.0
        vx, vy = (other.vx, other.vy) if isinstance(other, Entity) else (0.0, 0.0)
        return ((entity.vx - vx) * dx + (entity.vy - vy) * dy) / length

    return straight


def _closing_on_road(
    ground: Ground, entity: Entity, other: Entity | Callable[[], Place], turn: float
) -> Callable[[float], float]:
    """The same on a road that may bend between the two: each has its speed along (turn 0) or across the road there."""

    def rate(apart: float) -> float:
        here = ground.position(entity)
        axis = here.h_road + turn
        speed = entity.vx * math.cos(axis) + entity.vy * math.sin(axis)
        if isinstance(other, Entity):
            there = ground.position(other)
            axis = there.h_road + turn
            speed -= ground.turned(here, there) * (other.vx * math.cos(axis) + other.vy * math.sin(axis))
        speed *= entity.sense
        return speed if apart >= 0.0 else -speed

    return rate


def _closing_on_trajectory(
    entity: Entity, other: Entity | Callable[[], Place], turn: float
) -> Callable[[float], float]:
    """The same along (turn 0) or across the trajectory that the entity follows, by its direction at either place."""

    def rate(apart: float) -> float:
        follower = entity.lateral
        if not isinstance(follower, FollowTrajectory):
            return 0.0
        here = follower.axis()[0]
        speed = entity.vx * math.cos(here + turn) + entity.vy * math.sin(here + turn)
        if isinstance(other, Entity):
            axis = follower.beside(other.x, other.y)[2] + turn
            speed -= other.vx * math.cos(axis) + other.vy * math.sin(axis)
        if math.cos(entity.h - here) < 0.0:
            speed = -speed
        return speed if apart >= 0.0 else -speed

    return rate
