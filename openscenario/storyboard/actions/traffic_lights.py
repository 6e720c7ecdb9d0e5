"""Actions on traffic lights: the state of one, the phase of a controller."""

from __future__ import annotations

from typing import TYPE_CHECKING

from openscenario import model
from openscenario.storyboard.registry import Instant, Runner, Unsupported, action

if TYPE_CHECKING:
    from openscenario.storyboard.engine import Storyboard


@action(model.TrafficSignalStateAction)
def signal_state(element: model.TrafficSignalStateAction, entity: None, board: Storyboard) -> Runner:
    """Holds until another action or the next phase of a controller sets it."""
    return Instant(lambda: board.world.signals.__setitem__(element.name, element.state))


@action(model.TrafficSignalControllerAction)
def signal_controller(element: model.TrafficSignalControllerAction, entity: None, board: Storyboard) -> Runner:
    """The controller goes on from the beginning of that phase."""
    program = board.programs.get(element.traffic_signal_controller_ref)
    if program is None:
        name = element.traffic_signal_controller_ref
        raise Unsupported("no traffic signal controller of this name", name, ", ".join(board.programs))
    if element.phase not in program.names():
        raise Unsupported("the controller has no such phase", element.phase, ", ".join(program.names()))

    def begin() -> None:
        program.begin(element.phase, board.time)
        program.show(board.time, board.world)

    return Instant(begin)
