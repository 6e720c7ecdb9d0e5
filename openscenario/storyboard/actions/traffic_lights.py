"""Actions on traffic lights: the state of one, the phase of a controller."""

from __future__ import annotations

from typing import TYPE_CHECKING

from openscenario import model
from openscenario.storyboard.registry import action
from openscenario.storyboard.runner import Instant, Runner
from openscenario.storyboard.signals import program_with

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board


@action(model.TrafficSignalStateAction)
def signal_state(element: model.TrafficSignalStateAction, entity: None, board: Board) -> Runner:
    """Holds until another action or the next phase of a controller sets it. The road may call the light by its id or
    by its name."""
    return Instant(lambda: board.world.show(element.name, element.state))


@action(model.TrafficSignalControllerAction)
def signal_controller(element: model.TrafficSignalControllerAction, entity: None, board: Board) -> Runner:
    """The controller goes on from the beginning of that phase."""
    program = program_with(board.programs, element.traffic_signal_controller_ref, element.phase)

    def begin() -> None:
        program.begin(element.phase, board.time)
        program.show(board.time, board.world)

    return Instant(begin)
