"""LateralDistanceAction: a distance to the side of another entity, once or continuously."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from openscenario import model
from openscenario.storyboard.actions.keep_distance import eased
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.motion import lean
from openscenario.storyboard.places import wrap
from openscenario.storyboard.registry import Runner, Unsupported, action, entity_called

if TYPE_CHECKING:
    from openscenario.storyboard.engine import Storyboard

REACHED = 0.01  # m
STIFFNESS = 0.4  # 1/m per m/s^2 of the limit, as along the road


class LateralDistance:
    """Without limits the entity is put beside the other one; with them it moves over as fast as they allow.

    The standard names no control law. Here: with a limit of speed alone the entity moves at it; with one of
    acceleration a critically damped spring, a = k e - 2 sqrt(k) v with e the way still to go and k = STIFFNESS x limit,
    both within the limits; where jerk has limits a changes no faster. Distances are measured across the road in any
    coordinate system; where there is no road, across the referenced entity.
    """

    __slots__ = ("_acceleration", "_board", "_element", "_entity", "_other", "_rate", "_side")
    domains: tuple[str, ...] = ("lateral",)

    def __init__(self, element: model.LateralDistanceAction, entity: Entity, board: Storyboard) -> None:
        if board.network is None and element.coordinate_system != "entity":
            raise Unsupported("the scenario has no road network", element.coordinate_system, "entity")
        self._element = element
        self._entity = entity
        self._board = board
        self._other = entity_called(element.entity_ref, board)
        self._side = 0.0
        self._rate = self._acceleration = 0.0

    def start(self) -> bool:
        entity, element, other, ground = self._entity, self._element, self._other, self._board.ground
        left = other.sense if ground.track(entity) and ground.track(other) else 1.0
        if element.displacement == "any":
            self._side = 1.0 if self._apart() >= 0.0 else -1.0
        else:
            self._side = left if element.displacement == "leftToReferencedEntity" else -left
        if ground.network is None:  # where it heads is where it moves
            self._rate = entity.speed * math.sin(entity.h - other.h)
        return self._free() and self._step_once() and not element.continuous

    def _apart(self) -> float:
        """How far to the left of the other [m]: along t of the road, or across the other where there is none."""
        entity, other, ground = self._entity, self._other, self._board.ground
        if ground.network is None:
            return (entity.y - other.y) * math.cos(other.h) - (entity.x - other.x) * math.sin(other.h)
        return ground.position(entity).t - ground.position(other).t

    def _free(self) -> bool:
        limits = self._element.dynamic_constraints
        return limits is None or (
            limits.max_acceleration is None and limits.max_deceleration is None and limits.max_speed is None
        )

    def _to_go(self) -> float:
        """Way [m] to the left of the reference line to where the distance asks for."""
        other, side = self._other, self._side
        wanted = self._element.distance or 0.0
        if self._element.freespace:
            # sides of the boxes as they are along the road: a body that turns a little does not change the wish
            mine, its = self._entity.center_y * self._entity.sense, other.center_y * other.sense
            wanted += side * (its - mine) + 0.5 * (self._entity.width + other.width)
        return side * wanted - self._apart()

    def _step_once(self) -> bool:
        entity, other, to_go = self._entity, self._other, self._to_go()
        if self._board.network is None:
            entity.put(entity.x - to_go * math.sin(other.h), entity.y + to_go * math.cos(other.h), entity.z, entity.h)
            return True
        entity.offset += to_go
        entity.drift = 0.0
        self._board.ground.drive(entity, 0.0)
        return True

    def step(self, dt: float) -> bool:
        entity, element, limits = self._entity, self._element, self._element.dynamic_constraints
        self._board.ground.track(entity)
        if self._free() or limits is None:
            self._step_once()
            return not element.continuous
        to_go = self._to_go()
        top = limits.max_speed if limits.max_speed is not None else math.inf
        up, down = limits.max_acceleration, limits.max_deceleration
        if up is None and down is None:
            rate = self._rate = min(max(to_go / dt, -top), top)
        else:
            rate = self._rate  # what it moves with in this step; what it wants to is for the next one
            up, down = (math.inf if limit is None else limit for limit in (up, down))
            # speeding up is what goes the way it already moves, or starts
            stiffness = STIFFNESS * min(up, down)
            wanted = stiffness * to_go - 2.0 * math.sqrt(stiffness) * self._rate
            limit = up if wanted * self._rate >= 0.0 else down
            self._acceleration = eased(self._acceleration, min(max(wanted, -limit), limit), limits, dt)
            self._rate = min(max(self._rate + self._acceleration * dt, -top), top)
        done = not element.continuous and abs(to_go - rate * dt) < REACHED
        if self._board.network is None:
            self._head(0.0 if done else rate)
            return done
        entity.offset += rate * dt
        lean(entity, rate * entity.sense, dt)
        if done:
            entity.drift = 0.0
        return done

    def _head(self, rate: float) -> None:
        """Head on open ground so that `rate` [m/s] of the speed is across the other; it goes there by itself."""
        entity, other = self._entity, self._other
        if entity.speed != 0.0:
            turn = math.asin(min(max(rate / entity.speed, -1.0), 1.0))
            against = math.cos(entity.h - other.h) < 0.0
            entity.h = wrap(other.h + (math.pi - turn if against else turn))

    def stop(self) -> None:
        self._entity.drift = 0.0

    def ask(self) -> tuple[str, dict[str, Any], float]:
        return "lateral_distance", {"to": self._other.name, "distance": self._element.distance}, 0.0


@action(model.LateralDistanceAction)
def lateral_distance(element: model.LateralDistanceAction, entity: Entity, board: Storyboard) -> Runner:
    return LateralDistance(element, entity, board)
