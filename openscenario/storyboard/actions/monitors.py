"""SetMonitorAction: a flag that a scenario raises or lowers for whoever watches."""

from __future__ import annotations

from typing import TYPE_CHECKING

from openscenario import model
from openscenario.storyboard.registry import action
from openscenario.storyboard.runner import Instant, Runner

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board


@action(model.SetMonitorAction)
def monitor(element: model.SetMonitorAction, entity: None, board: Board) -> Runner:
    """Each change is an event `monitor` of the log; `dvp play --json` and the notes of a run tell the last values."""
    return Instant(lambda: board.world.monitors.update({element.monitor_ref: element.value}))
