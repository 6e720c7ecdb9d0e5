"""What the storyboard asks of an entity that something else moves."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board
    from openscenario.storyboard.entity import Entity
    from openscenario.storyboard.runner import Runner


class Request(NamedTuple):
    """time [s], entity, kind ("speed", "route", "lane_change", "trajectory", ...) and its values (SI)."""

    time: float
    entity: str
    kind: str
    values: dict[str, Any]


class Asked:
    """Stands for an action on an external entity: posts a request, and is over when the action would be.

    A runner that knows what it asks for has `ask() -> (kind, values, seconds)`; any other asks by its element's
    name and is over.
    """

    __slots__ = ("_board", "_element", "_entity", "_left", "_runner")
    domains: tuple[str, ...] = ()

    def __init__(self, runner: Runner, element: object, entity: Entity, board: Board) -> None:
        self._runner = runner
        self._element = element
        self._entity = entity
        self._board = board
        self._left = 0.0

    def start(self) -> bool:
        """Post the request; True if the action would be over at once."""
        ask = getattr(self._runner, "ask", None)
        kind: str
        values: dict[str, Any]
        if ask is None:
            kind, values, self._left = request_kind(self._element), {}, 0.0
        else:
            kind, values, self._left = ask()
        self._board.request(self._entity, kind, values)
        return self._left <= 0.0

    def step(self, dt: float) -> bool:
        """Wait for another `dt` [s]; True when the action would be over."""
        self._left -= dt
        return self._left <= 1e-9

    def stop(self) -> None:
        """Do nothing: what was asked for is the other side's."""


def request_kind(element: object) -> str:
    """LaneChangeAction -> lane_change."""
    name = type(element).__name__.removesuffix("Action")
    return re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()
