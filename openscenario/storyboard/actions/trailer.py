"""ConnectTrailerAction and DisconnectTrailerAction."""

from __future__ import annotations

from typing import TYPE_CHECKING

from openscenario import model
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.registry import action, entity_called
from openscenario.storyboard.runner import Instant, Runner
from openscenario.storyboard.trailers import couple, train, uncouple
from openscenario.storyboard.unsupported import Unsupported

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board


@action(model.ConnectTrailerAction)
def connect(element: model.ConnectTrailerAction, entity: Entity, board: Board) -> Runner:
    """The named entity hangs on the actor from now on, wherever it was; its own actions no longer move it.

    Raises Unsupported for a vehicle that is to be its own trailer.
    """
    trailer = entity_called(element.trailer_ref, board)
    if trailer is entity:
        raise Unsupported("a vehicle cannot be its own trailer", element.trailer_ref)

    def hang() -> None:
        if entity in train(trailer):
            board.warn(element, "trailer-circle", f"{entity.name} hangs on {trailer.name} itself: not connected")
        else:
            couple(entity, trailer)

    return Instant(hang)


@action(model.DisconnectTrailerAction)
def disconnect(element: model.DisconnectTrailerAction, entity: Entity, board: Board) -> Runner:
    """The trailer of the actor stands where it is from now on."""
    return Instant(lambda: uncouple(entity))
