"""LateralDistanceAction: a distance to the side of another entity, once or continuously."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from openscenario import model
from openscenario.storyboard.actions.beside import Beside, side_of
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.limits import Limits, given
from openscenario.storyboard.motion import lean
from openscenario.storyboard.registry import action, entity_called
from openscenario.storyboard.runner import Runner
from openscenario.storyboard.unsupported import Unsupported

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board

REACHED = 0.01  # m
STIFFNESS = 0.4  # 1/m per m/s^2 of the limit, as along the road
HARDEST = 100.0  # m/s^2, where the acceleration has no limit and its change has


class LateralDistance:
    """Without limits the entity is put beside the other one; with them it moves over as fast as they allow.

    The standard names no control law. Here: with a limit of speed alone the entity moves at it; with one of
    acceleration a critically damped spring, a = k e - 2 sqrt(k) v with e the way still to go and k = STIFFNESS x limit,
    both within the limits; where jerk has limits a changes no faster. One that is not continuous is over when it has
    been there for a step. Distances are measured across the road; in the coordinates of an entity see `beside.py`.
    """

    __slots__ = ("_acceleration", "_board", "_element", "_entity", "_limits", "_other", "_rate", "_side", "_there")
    domains: tuple[str, ...] = ("lateral",)

    def __init__(self, element: model.LateralDistanceAction, entity: Entity, board: Board) -> None:
        if board.network is None:
            raise Unsupported("the scenario has no road network", element.coordinate_system, "entity")
        self._element = element
        self._entity = entity
        self._board = board
        self._other = entity_called(element.entity_ref, board)
        self._side = 0.0
        self._there = False
        self._rate = self._acceleration = 0.0
        self._limits = given(element.dynamic_constraints)  # a Performance says nothing about moving to the side

    def start(self) -> bool:
        """Choose the side; without limits an entity that begins like this stands there at once. Never over yet."""
        self._side = side_of(self._element, self._apart() * self._left())
        if self._free() and not self._board.running:  # stands there from the start
            self._step_once()
        return False

    def _turned(self) -> float:
        """-1 if the other is on a road that runs against the one of this entity, else 1."""
        ground = self._board.ground
        return ground.turned(ground.position(self._entity), ground.position(self._other))

    def _left(self) -> float:
        """Which way is left of the other: 1 along t of this entity's road, -1 against it."""
        self._board.ground.track(self._entity)
        self._board.ground.track(self._other)
        return self._other.sense * self._turned()

    def _apart(self) -> float:
        """How far beside the other [m], along t of this entity's road."""
        ground = self._board.ground
        return ground.position(self._entity).t - self._turned() * ground.position(self._other).t

    def _free(self) -> bool:
        return self._limits == Limits()

    def _to_go(self) -> float:
        """Way [m] along t of the entity's road to where the distance asks for."""
        other, left = self._other, self._left()
        side = self._side * left
        wanted = self._element.distance or 0.0
        if self._element.freespace:
            # sides of the boxes as they are along the road: a body that turns a little does not change the wish
            mine, its = self._entity.center_y * self._entity.sense, other.center_y * left
            wanted += side * (its - mine) + 0.5 * (self._entity.width + other.width)
        return side * wanted - self._apart()

    def _step_once(self) -> None:
        entity = self._entity
        entity.offset += self._to_go()
        entity.drift = 0.0
        self._board.ground.drive(entity, 0.0)

    def step(self, dt: float) -> bool:
        """Move sideways for `dt` [s]; True after a step at the distance, unless `continuous` is asked for."""
        entity, element, limits = self._entity, self._element, self._limits
        self._board.ground.track(entity)
        there = not element.continuous and abs(self._to_go()) < REACHED
        if there and self._there:
            entity.drift = 0.0
            return True
        self._there = there
        if self._free():
            self._step_once()
            return False
        to_go = self._to_go() * entity.sense  # to its left: a road that runs the other way changes nothing
        top = limits.speed
        if limits.up == limits.down == math.inf and not limits.smooth:
            rate = self._rate = min(max(to_go / dt, -top), top)
        else:
            rate = self._rate  # what it moves with in this step; what it wants to is for the next one
            # speeding up is what goes the way it already moves, or starts
            stiffness = STIFFNESS * min(limits.up, limits.down, HARDEST)
            wanted = stiffness * to_go - 2.0 * math.sqrt(stiffness) * self._rate
            limit = limits.up if wanted * self._rate >= 0.0 else limits.down
            self._acceleration = limits.eased(self._acceleration, min(max(wanted, -limit), limit), dt)
            self._rate = min(max(self._rate + self._acceleration * dt, -top), top)
        entity.offset += rate * entity.sense * dt
        lean(entity, rate, dt)
        return False

    def stop(self) -> None:
        """End the sideways motion."""
        self._entity.drift = 0.0

    def ask(self) -> tuple[str, dict[str, Any], float]:
        """A request "lateral_distance" with the other's name and the distance [m]; over at once."""
        return "lateral_distance", {"to": self._other.name, "distance": self._element.distance}, 0.0


@action(model.LateralDistanceAction)
def lateral_distance(element: model.LateralDistanceAction, entity: Entity, board: Board) -> Runner:
    """Across the road; in the coordinates of an entity by steering for a line beside it, see below."""
    if element.coordinate_system == "entity":
        return Beside(element, entity, board)
    return LateralDistance(element, entity, board)
