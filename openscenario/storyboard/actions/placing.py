"""TeleportAction, and adding and deleting entities."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import TYPE_CHECKING, Any

from openscenario import model
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.nodes import Node
from openscenario.storyboard.positions import resolver
from openscenario.storyboard.registry import action, entity_called
from openscenario.storyboard.runner import Instant, Runner
from openscenario.storyboard.trailers import line_up, train

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board


class Teleport(Instant):
    """Put the entity at the position; speed stays as it is.

    The default controller takes it on from there 10 ms later, or after the step if that is shorter: being put somewhere
    takes a beat (`motion.BEAT`), as in other tools; the standard says nothing.
    """

    __slots__ = ("_board", "_entity", "_where")

    def __init__(self, element: model.TeleportAction, entity: Entity, board: Board) -> None:
        super().__init__()
        self._where = resolver(element.position, board, entity)
        self._entity = entity
        self._board = board

    def start(self) -> bool:
        """Put the entity and its trailers there; True, as that was all."""
        self._board.ground.set_place(self._entity, self._where())
        line_up(self._entity)
        self._entity.placed = self._board.running
        self._entity.teleports += 1
        return True

    def ask(self) -> tuple[str, dict[str, Any], float]:
        """A request "teleport" with x, y, z [m] and h [rad]; over at once."""
        where = self._where()
        return "teleport", {"x": where.x, "y": where.y, "z": where.z, "h": where.h}, 0.0


@action(model.TeleportAction)
def teleport(element: model.TeleportAction, entity: Entity, board: Board) -> Runner:
    """Put the entity at the position; its speed stays as it is."""
    return Teleport(element, entity, board)


def leave_out(nodes: Iterator[Node], entities: dict[str, Entity], placed: Collection[Entity | None]) -> None:
    """Make those inactive who are added later and have no Init actions: the standard names no place for them."""
    for node in nodes:
        element = node.element
        if isinstance(element, model.EntityAction) and isinstance(element.action, model.AddEntityAction):
            entity = entities.get(element.entity_ref)
            if entity is not None and not entity.external and entity not in placed:
                for each in train(entity):
                    each.active = False


@action(model.EntityAction)
def entity_action(element: model.EntityAction, entity: None, board: Board) -> Runner:
    """Who is there already is not added again; who is added later and has no Init actions is not there before."""
    target = entity_called(element.entity_ref, board)
    if isinstance(element.action, model.AddEntityAction):
        where = resolver(element.action.position, board, target)

        def add() -> None:
            if board.running and target.active:
                return
            board.ground.set_place(target, where())
            line_up(target)
            for each in train(target):
                each.active = True

        return Instant(add)

    def delete() -> None:
        for each in train(target):
            each.active = False

    return Instant(delete)
