"""Actions that are accepted and change no motion here; each says what it means to us."""

from __future__ import annotations

from typing import TYPE_CHECKING

from openscenario import model
from openscenario.storyboard.registry import action
from openscenario.storyboard.runner import Instant, Runner

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board


@action(model.CustomCommandAction)
def command(element: model.CustomCommandAction, entity: None, board: Board) -> Runner:
    """Kept in `board.world.commands`; never carried out: a scenario must not run programs."""
    return Instant(lambda: board.world.commands.append((board.time, element.type, element.content)))
