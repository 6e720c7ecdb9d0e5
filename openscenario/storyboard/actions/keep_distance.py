"""LongitudinalDistanceAction: a distance or a time gap to another entity, once or continuously."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from openscenario import model
from openscenario.storyboard.distances import Measure, measure
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.limits import Limits, both, given, performance
from openscenario.storyboard.registry import action, entity_called
from openscenario.storyboard.runner import Runner

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board

STIFFNESS = 0.4  # 1/m per m/s^2 of the limit: how hard the distance is drawn in
REACHED = 0.1  # m


class KeepDistance:
    """Without limits the entity is moved to its place and takes over the other's speed; with them it is controlled.

    The standard names no control law. Here: a critically damped spring between the entity and its place,
    a = k e - 2 sqrt(k) (v - v_other), e the distance still to go, k = STIFFNESS x limit, a within the limits; where
    jerk has limits a changes no faster. It comes no faster than it can still brake before its place, and falls back no
    faster than it can still accelerate there. Limits are the narrower of the action's and the vehicle's. Without
    limits the entity moves at most at the vehicle's top speed, except at the start and after the other entity was
    teleported.
    """

    __slots__ = ("_acceleration", "_board", "_distance", "_element", "_entity", "_limits", "_other", "_side")
    domains: tuple[str, ...] = ("longitudinal",)

    def __init__(self, element: model.LongitudinalDistanceAction, entity: Entity, board: Board) -> None:
        self._element = element
        self._entity = entity
        self._board = board
        self._other = entity_called(element.entity_ref, board)
        self._side = -1.0 if element.displacement == "leadingReferencedEntity" else 1.0
        self._distance = self._measure(0.0 if element.displacement == "any" else self._side)
        self._acceleration = 0.0
        self._limits = both(given(element.dynamic_constraints), performance(entity))

    def _measure(self, side: float) -> Measure:
        """Of free distances, those between the ends that face each other with the entity in its place."""
        element = self._element
        return measure(
            self._board,
            self._entity,
            self._other,
            kind="longitudinal",
            system=element.coordinate_system,
            free=element.freespace,
            side=side,
        )

    def start(self) -> bool:
        """Choose the side; without limits put the entity in its place. True if that was all."""
        if self._element.displacement == "any":
            apart = self._distance()
            self._side = -1.0 if apart is not None and apart < 0.0 else 1.0
            self._distance = self._measure(self._side)
        if self._limited():
            return False
        self._place(math.inf)
        return not self._element.continuous

    def _limited(self) -> bool:
        return given(self._element.dynamic_constraints) != Limits()

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

    def _place(self, most: float) -> None:
        """Move to where the distance asks for, by no more than `most` [m], with the other's speed."""
        entity, ground, top = self._entity, self._board.ground, self._limits.speed
        entity.jump_to_speed(min(max(self._other.speed, -top), top))
        way = min(max(self._to_go(), -most), most)
        if ground.track(entity):
            ground.drive(entity, way)
        else:
            entity.put(entity.x + way * math.cos(entity.h), entity.y + way * math.sin(entity.h), entity.z, entity.h)

    def step(self, dt: float) -> bool:
        """Control the speed for `dt` [s]; True when the entity is in its place and `continuous` is not asked for."""
        entity, limits = self._entity, self._limits
        if not self._limited():
            self._place(math.inf if self._other.placed else limits.speed * dt)
            return False
        to_go = self._to_go()
        limit = min(limits.up if to_go < 0.0 else limits.down, 100.0)
        stiffness = STIFFNESS * limit
        closing = entity.speed - self._other.speed
        wanted = stiffness * to_go - 2.0 * math.sqrt(stiffness) * closing
        if to_go > 0.0:
            wanted = min(wanted, _approach(to_go, closing, self._acceleration, limits.down, limits.fall, dt))
        elif to_go < 0.0:
            wanted = max(wanted, -_approach(-to_go, -closing, -self._acceleration, limits.up, limits.rise, dt))
        wanted = min(max(wanted, -limits.down), limits.up)
        self._acceleration = limits.eased(self._acceleration, wanted, dt)
        top = max(limits.speed, abs(entity.speed) - limits.down * dt)  # who is too fast at first brakes within limits
        entity.speed = min(max(entity.speed + self._acceleration * dt, -top), top)
        return not self._element.continuous and abs(to_go) < REACHED

    def stop(self) -> None:
        """Do nothing: the entity keeps its speed."""

    def ask(self) -> tuple[str, dict[str, Any], float]:
        """A request "distance" with the other's name, distance [m] and time gap [s], one of them None; over at once."""
        element = self._element
        return "distance", {"to": self._other.name, "distance": element.distance, "time_gap": element.time_gap}, 0.0


def _approach(way: float, speed: float, acceleration: float, limit: float, rate: float, dt: float) -> float:
    """Greatest acceleration [m/s^2] in this step [s] after which the entity can still stop closing within `way` [m].

    It closes at `speed` [m/s] with `acceleration` [m/s^2], and stops by `limit` [m/s^2], which builds up at `rate`
    [m/s^3].
    The speed v may be as great as v²/(2 a) + v a/(2 j) + v dt = way allows: the second term is the way during the
    build-up, at most. An acceleration that is still there ends at the same rate before, with its way and its gain.
    """
    if math.isinf(limit) or rate <= 0.0:
        return math.inf
    gaining = max(acceleration, 0.0)
    way -= speed * gaining / rate + gaining**3 / (3.0 * rate * rate)
    build_up = 0.5 * limit * limit / rate + limit * dt
    most = math.sqrt(build_up * build_up + 2.0 * limit * max(way, 0.0)) - build_up
    return (most - 0.5 * gaining * gaining / rate - speed) / dt


@action(model.LongitudinalDistanceAction)
def keep_distance(element: model.LongitudinalDistanceAction, entity: Entity, board: Board) -> Runner:
    """Go to a distance or a time gap ahead of or behind another entity, and stay there if `continuous`."""
    return KeepDistance(element, entity, board)
