"""LongitudinalDistanceAction: a distance or a time gap to another entity, once or continuously."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from openscenario import model
from openscenario.storyboard.distances import Measure, measure
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.registry import Runner, action, entity_called

if TYPE_CHECKING:
    from openscenario.storyboard.engine import Storyboard

STIFFNESS = 0.4  # 1/m per m/s^2 of the limit: how hard the distance is drawn in
REACHED = 0.1  # m


class KeepDistance:
    """Without limits the entity is moved to its place and takes over the other's speed; with them it is controlled.

    The standard names no control law. Here: a critically damped spring between the entity and its place,
    a = k e - 2 sqrt(k) (v - v_other), e the distance still to go, k = STIFFNESS x limit, a within the limits; where
    jerk has limits a changes no faster.
    """

    __slots__ = ("_acceleration", "_board", "_distance", "_element", "_entity", "_other", "_side")
    domains: tuple[str, ...] = ("longitudinal",)

    def __init__(self, element: model.LongitudinalDistanceAction, entity: Entity, board: Storyboard) -> None:
        self._element = element
        self._entity = entity
        self._board = board
        self._other = entity_called(element.entity_ref, board)
        self._distance: Measure = measure(
            board, entity, self._other, kind="longitudinal", system=element.coordinate_system, free=element.freespace
        )
        self._side = -1.0 if element.displacement == "leadingReferencedEntity" else 1.0
        self._acceleration = 0.0

    def start(self) -> bool:
        if self._element.displacement == "any":
            apart = self._distance()
            self._side = -1.0 if apart is not None and apart < 0.0 else 1.0
        if self._limited():
            return False
        self._place()
        return not self._element.continuous

    def _limited(self) -> bool:
        limits = self._element.dynamic_constraints
        return limits is not None and (limits.max_acceleration is not None or limits.max_deceleration is not None)

    def _to_go(self) -> float:
        """Way ahead [m] to the place that the distance asks for."""
        apart = self._distance()
        if apart is None:
            return 0.0
        element = self._element
        wanted = (
            element.distance if element.distance is not None else abs(self._other.speed) * (element.time_gap or 0.0)
        )
        return apart - self._side * wanted

    def _place(self) -> None:
        entity, ground = self._entity, self._board.ground
        entity.jump_to_speed(self._other.speed)
        way = self._to_go()
        if ground.track(entity):
            ground.drive(entity, way)
        else:
            entity.put(entity.x + way * math.cos(entity.h), entity.y + way * math.sin(entity.h), entity.z, entity.h)

    def step(self, dt: float) -> bool:
        entity, limits = self._entity, self._element.dynamic_constraints
        if not self._limited() or limits is None:
            self._place()
            return False
        to_go = self._to_go()
        # what the vehicle can do limits it too
        up = min(entity.max_acceleration, _or_infinite(limits.max_acceleration))
        down = min(entity.max_deceleration, _or_infinite(limits.max_deceleration))
        limit = min(up if to_go < 0.0 else down, 100.0)
        stiffness = STIFFNESS * limit
        wanted = stiffness * to_go - 2.0 * math.sqrt(stiffness) * (entity.speed - self._other.speed)
        top = min(entity.max_speed, _or_infinite(limits.max_speed))
        self._acceleration = eased(self._acceleration, min(max(wanted, -down), up), limits, dt)
        entity.speed = min(max(entity.speed + self._acceleration * dt, -top), top)
        return not self._element.continuous and abs(to_go) < REACHED

    def stop(self) -> None:
        return None

    def ask(self) -> tuple[str, dict[str, Any], float]:
        element = self._element
        return "distance", {"to": self._other.name, "distance": element.distance, "time_gap": element.time_gap}, 0.0


def eased(now: float, wanted: float, limits: model.DynamicConstraints, dt: float) -> float:
    """The wanted acceleration, or as near to it as the limits of its change let it come in a step [m/s^2].

    Braking and going back from it count as deceleration.
    """
    if wanted < min(now, 0.0):
        return max(wanted, now - _or_infinite(limits.max_deceleration_rate) * dt)
    if wanted >= 0.0 and wanted > now:
        return min(wanted, now + _or_infinite(limits.max_acceleration_rate) * dt)
    return wanted


def _or_infinite(limit: float | None) -> float:
    return math.inf if limit is None else limit


@action(model.LongitudinalDistanceAction)
def keep_distance(element: model.LongitudinalDistanceAction, entity: Entity, board: Storyboard) -> Runner:
    return KeepDistance(element, entity, board)
