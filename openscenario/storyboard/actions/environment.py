"""EnvironmentAction: the weather and the state of the road."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from openscenario import model
from openscenario.storyboard.registry import action
from openscenario.storyboard.runner import Instant, Runner

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board


@action(model.EnvironmentAction)
def environment(element: model.EnvironmentAction, entity: None, board: Board) -> Runner:
    """A friction scale below 1 limits the vehicles; fog, precipitation and the light limit the twin's sensors, and the
    wind acts on its body; see below."""

    def change() -> None:
        board.world.environment = element.environment
        if element.environment.time_of_day is not None:  # what an action leaves out stays as it was
            board.world.clock = element.environment.time_of_day
            board.world.clock_since = board.time
        road = element.environment.road_condition
        if road is not None:
            board.world.friction = road.friction_scale_factor if road.friction_scale_factor < 1.0 else math.inf
            for entity in board.entities.values():
                if entity.kind == "vehicle":
                    entity.limit_friction(board.world.friction)

    return Instant(change)
