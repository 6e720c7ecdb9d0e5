"""ControllerAction and ActivateControllerAction: who drives an entity, and what the scenario takes from its hands."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from openscenario import model
from openscenario.storyboard import drivers
from openscenario.storyboard.actions.override import take
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.registry import action
from openscenario.storyboard.runner import Runner

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board


class Control:
    """Assigns, activates and overrides at once."""

    __slots__ = ("_board", "_element", "_entity")
    domains: tuple[str, ...] = ()

    def __init__(self, element: model.ControllerAction, entity: Entity, board: Board) -> None:
        self._element = element
        self._entity = entity
        self._board = board

    def start(self) -> bool:
        """Do all parts of the action; True, as that was all."""
        element, entity = self._element, self._entity
        assigned = element.assign_controller_action
        if assigned is not None:
            given = assigned.object_controller or model.ObjectController(assigned.controller)
            drivers.assign(entity, (given,), self._board)
            on = assigned.activate_longitudinal, assigned.activate_lateral
            drivers.activate(entity, longitudinal=on[0], lateral=on[1])
        if element.override_controller_value_action is not None:
            take(element.override_controller_value_action, entity)
        active = element.activate_controller_action
        if active is not None:
            drivers.activate(entity, longitudinal=active.longitudinal, lateral=active.lateral)
        return True

    def step(self, dt: float) -> bool:
        """Do nothing in a step of `dt` [s]; True, as it is over."""
        return True

    def stop(self) -> None:
        """Do nothing: nothing is held."""

    def ask(self) -> tuple[str, dict[str, Any], float]:
        """A request "controller"; what it overrides is in the entity's `controls`; over at once."""
        self.start()
        return "controller", {}, 0.0


@action(model.ControllerAction)
def controller(element: model.ControllerAction, entity: Entity, board: Board) -> Runner:
    """Overrides pedals, wheel and gear of any vehicle; others with a controller that reacts to traffic; see below."""
    return Control(element, entity, board)


@action(model.ActivateControllerAction)
def activate(element: model.ActivateControllerAction, entity: Entity, board: Board) -> Runner:
    """Others with a controller that reacts to traffic are driven by it; see below."""
    return Control(model.ControllerAction(activate_controller_action=element, at=element.at), entity, board)
