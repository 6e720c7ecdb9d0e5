"""Actions that are accepted and change no motion here; each says what it means to us."""

from __future__ import annotations

from typing import TYPE_CHECKING

from openscenario import model
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.registry import action
from openscenario.storyboard.runner import Instant, Runner

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board


@action(model.ControllerAction)
@action(model.ActivateControllerAction)
def controller(element: object, entity: Entity, board: Board) -> Runner:
    """The entity stays with the default controller; the ego's controller is the driving stack under test."""
    return Instant()


@action(model.CustomCommandAction)
def command(element: model.CustomCommandAction, entity: None, board: Board) -> Runner:
    """Kept in `board.world.commands`; never carried out: a scenario must not run programs."""
    return Instant(lambda: board.world.commands.append((board.time, element.type, element.content)))


@action(model.SetMonitorAction)
def monitor(element: model.SetMonitorAction, entity: None, board: Board) -> Runner:
    """Monitors are for whoever watches the simulation."""
    return Instant()
