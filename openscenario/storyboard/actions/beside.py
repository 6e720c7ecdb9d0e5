"""LateralDistanceAction in entity coordinates: to a line beside another entity, by steering.

The line runs beside the referenced entity at the distance wanted, the way that entity heads (class
LateralDistanceAction, `coordinateSystem` "entity": its lateral axis). The standard names no law by which to get there.
Here, as in the field's tools: who has a limit of lateral acceleration steers for the nearest point of the line and,
within a turning radius of it, into its direction; its speed is its own. So it draws an S, whose peak acceleration is
1.5 times that of an even turn, and the radius is 1.5 v^2 / a. Who has none is there at once.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from openscenario import model
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.motion import way
from openscenario.storyboard.places import wrap
from openscenario.storyboard.registry import entity_called

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board

REACHED = 0.01  # m
ALIGNED = 0.01  # rad
SHARPEST = 0.5  # m, turning radius
PEAK = 1.5  # of an S against an even turn
HARDEST = 1000.0  # m/s^2
NEAR = 1e-6  # m


def steer(h: float, to_line: float, aside: float, along: float, radius: float, step: float) -> float:
    """The heading [rad] after a step of `step` [m] of who heads `h` and is `to_line` >= 0 [m] from its line.

    `aside` is the direction to the nearest point of the line, `along` the one of the line [rad]. Beyond `radius` [m] it
    turns to `aside`; nearer it weighs the two by the angle that is left of an even turn into the line, eased at both
    ends; never harder than 1.5 times the radius' turn.
    """
    hardest = min(PEAK * step / radius, math.pi)
    if to_line < NEAR:
        return along
    if to_line > radius:
        turn = wrap(aside - h)
    else:
        piece = step / radius
        left = max(math.acos(1.0 - to_line / radius), 0.5 * piece)
        weight = min((2.0 * left - 0.5 * piece) / math.pi, 1.0)
        weight = weight * weight * (3.0 - 2.0 * weight)
        turn = weight * wrap(aside - h) + (1.0 - weight) * wrap(along - h)
    return wrap(h + min(max(turn, -hardest), hardest))


def side_of(element: model.LateralDistanceAction, left: float) -> float:
    """1 to the left of the other, -1 to its right; where any will do, the side on which one is: `left` of it [m]."""
    if element.displacement == "any":
        return 1.0 if left >= 0.0 else -1.0
    return 1.0 if element.displacement == "leftToReferencedEntity" else -1.0


class Beside:
    """Moves the entity to the line beside the other one and along it, over whatever ground.

    Not `continuous`, it is over when the entity has been on the line, the way it runs, for a step.
    """

    __slots__ = ("_board", "_element", "_entity", "_other", "_side", "_there")
    domains: tuple[str, ...] = ("lateral",)

    def __init__(self, element: model.LateralDistanceAction, entity: Entity, board: Board) -> None:
        self._element = element
        self._entity = entity
        self._board = board
        self._other = entity_called(element.entity_ref, board)
        self._side = 1.0
        self._there = False

    def start(self) -> bool:
        """Choose the side; without limits an entity that begins like this stands there at once. Never over yet."""
        self._side = side_of(self._element, self._apart())
        limits = self._element.dynamic_constraints
        if limits is not None and (limits.max_acceleration_rate, limits.max_deceleration_rate) != (None, None):
            text = "limits of jerk do not count for a lateral distance in the coordinates of an entity"
            self._board.warn(limits, "no-limit-of-jerk", text)
        if self._limit() is None and self._top() == math.inf and not self._board.running:
            self._put(0.0, self._other.h, self._to_go())  # stands there from the start
        return False

    def _apart(self) -> float:
        """How far to the left of the other [m]."""
        entity, other = self._entity, self._other
        return (entity.y - other.y) * math.cos(other.h) - (entity.x - other.x) * math.sin(other.h)

    def _to_go(self) -> float:
        """Way [m] to the line, to the left of the other."""
        other, entity = self._other, self._entity
        wanted = self._element.distance or 0.0
        if self._element.freespace:
            wanted += self._side * (other.center_y - entity.center_y) + 0.5 * (entity.width + other.width)
        return self._side * wanted - self._apart()

    def _limit(self) -> float | None:
        """The limit of lateral acceleration [m/s^2], if there is one."""
        limits = self._element.dynamic_constraints
        if limits is None:
            return None
        both = [each for each in (limits.max_acceleration, limits.max_deceleration) if each is not None]
        return min(min(both), HARDEST) if both else None

    def _top(self) -> float:
        """The highest speed [m/s] to the side."""
        limits = self._element.dynamic_constraints
        return math.inf if limits is None or limits.max_speed is None else limits.max_speed

    def step(self, dt: float) -> bool:
        """Move towards the line for `dt` [s]; True after a step on it, unless `continuous` is asked for."""
        entity, other = self._entity, self._other
        to_go = self._to_go()
        there = abs(to_go) < REACHED and abs(wrap(entity.h - other.h)) < ALIGNED
        if not self._element.continuous and there and self._there:
            self._put(0.0, other.h, to_go)  # no rest of a turn is left
            return True
        self._there = there
        entity.ax = (entity.speed - entity.speed_before) / dt
        entity.late = entity.lateral_order < entity.longitudinal_order
        ahead = way(entity, dt)
        limit, top = self._limit(), self._top()
        if limit is not None:
            radius = max(PEAK * entity.speed * entity.speed / max(limit, NEAR), SHARPEST)
            aside = other.h + math.copysign(0.5 * math.pi, to_go)
            h = steer(entity.h, abs(to_go), aside, other.h, radius, abs(ahead))
        elif top < math.inf:
            h = other.h + math.asin(min(max(to_go / ahead, -1.0), 1.0)) if ahead != 0.0 else entity.h
        else:
            self._put(max(ahead - abs(to_go), 0.0), other.h, to_go, dt)
            return False
        if abs(ahead) > 0.0 and top < math.inf:
            widest = math.asin(min(top * dt / abs(ahead), 1.0))
            h = other.h + min(max(wrap(h - other.h), -widest), widest)
        self._put(ahead, h, 0.0, dt)
        return False

    def _put(self, ahead: float, h: float, aside: float, dt: float = 0.0) -> None:
        """Move `aside` [m] to the left of the other and `ahead` the way of `h` [rad], which the entity then heads."""
        entity, ground, across = self._entity, self._board.ground, self._other.h
        x, y = entity.x, entity.y
        entity.put(
            x - aside * math.sin(across) + ahead * math.cos(h),
            y + aside * math.cos(across) + ahead * math.sin(h),
            entity.z,
            h,
        )
        ground.stand(entity)
        entity.moved = dt > 0.0
        entity.travelled += abs(ahead)
        if dt > 0.0:
            entity.vx, entity.vy = (entity.x - x) / dt, (entity.y - y) / dt

    def stop(self) -> None:
        """Do nothing: the entity keeps its place and speed."""

    def ask(self) -> tuple[str, dict[str, Any], float]:
        """A request "lateral_distance" with the other's name and the distance [m]; over at once."""
        return "lateral_distance", {"to": self._other.name, "distance": self._element.distance}, 0.0
