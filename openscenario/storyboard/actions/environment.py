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
    """A friction scale below 1 limits the vehicles; fog and precipitation shorten the range of the twin's sensors."""

    def change() -> None:
        board.world.environment = element.environment
        board.world.environment_since = board.time
        road = element.environment.road_condition
        if road is not None:
            friction = road.friction_scale_factor if road.friction_scale_factor < 1.0 else math.inf
            for entity in board.entities.values():
                if entity.kind == "vehicle":
                    entity.limit_friction(friction)

    return Instant(change)
