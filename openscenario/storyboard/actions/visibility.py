"""VisibilityAction: who can see an entity. It is still there: conditions, collisions and metrics know of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from openscenario import model
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.registry import action
from openscenario.storyboard.runner import Runner

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board


class Show:
    """Shows or hides an entity at once, until another such action; also one that something else moves."""

    __slots__ = ("_element", "_entity")
    domains: tuple[str, ...] = ()

    def __init__(self, element: model.VisibilityAction, entity: Entity) -> None:
        self._element = element
        self._entity = entity

    def start(self) -> bool:
        """Set who sees the entity: traffic, and all sensors or those that are named. True, as that was all."""
        element, visible = self._element, self._entity.visible
        visible.traffic = element.traffic
        if not element.sensor_references:
            visible.sensors, visible.named = element.sensors, {}
        for reference in element.sensor_references:
            visible.named[reference.name.lower()] = element.sensors
        return True

    def step(self, dt: float) -> bool:
        """Do nothing in a step of `dt` [s]; True, as it is over."""
        return True

    def stop(self) -> None:
        """Do nothing: nothing is held."""

    def ask(self) -> tuple[str, dict[str, Any], float]:
        """A request "visibility" with what sensors and traffic see; over at once."""
        self.start()
        return "visibility", {"sensors": self._element.sensors, "traffic": self._element.traffic}, 0.0


@action(model.VisibilityAction)
def visibility(element: model.VisibilityAction, entity: Entity, board: Board) -> Runner:
    """Until the next one. `sensors`: those of the driven car, all or the named ones (lidar, camera); `traffic`: who
    comes from a TrafficAction or from SUMO; `graphics`: nothing is drawn."""
    return Show(element, entity)
