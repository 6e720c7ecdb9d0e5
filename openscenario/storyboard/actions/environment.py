"""EnvironmentAction: the weather and the state of the road."""

from __future__ import annotations

from typing import TYPE_CHECKING

from openscenario import model
from openscenario.storyboard.registry import action
from openscenario.storyboard.runner import Instant, Runner

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board


@action(model.EnvironmentAction)
def environment(element: model.EnvironmentAction, entity: None, board: Board) -> Runner:
    """A friction scale below 1 limits the tyres of the twin; fog and precipitation shorten the range of its sensors."""

    def change() -> None:
        board.world.environment = element.environment
        board.world.environment_since = board.time

    return Instant(change)
