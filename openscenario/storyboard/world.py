"""What of the world belongs to no entity: weather, time of day, states of traffic lights."""

from __future__ import annotations

import math

from openscenario import model


class World:
    """Environment last set, states of traffic signals by id, commands for whoever listens.

    `clock`: time of day last set, at `clock_since` [s].

    `monitors`: values by name. `friction`: coefficient [-] of the road, infinite where nothing limits it.
    `values`: of user-defined value conditions, set by whoever knows them.
    """

    __slots__ = ("clock", "clock_since", "commands", "environment", "friction", "monitors", "signals", "values")

    def __init__(self) -> None:
        self.environment: model.Environment | None = None
        self.clock: model.TimeOfDay | None = None
        self.clock_since = 0.0
        self.friction = math.inf
        self.monitors: dict[str, bool] = {}
        self.signals: dict[str, str] = {}
        self.values: dict[str, str] = {}
        self.commands: list[tuple[float, str, str]] = []
