"""What of the world belongs to no entity: weather, time of day, states of traffic lights."""

from __future__ import annotations

import math
from collections.abc import Sequence

from openscenario import model
from openscenario.road.elements import Signal


class World:
    """Environment last set, states of traffic signals by id, commands for whoever listens.

    `lights`: the traffic signals of the road, which a scenario may call by their id or by their name.

    `clock`: time of day last set, at `clock_since` [s].

    `monitors`: values by name. `friction`: coefficient [-] of the road, infinite where nothing limits it.
    `values`: of user-defined value conditions, set by whoever knows them.
    """

    __slots__ = (
        "_named",
        "clock",
        "clock_since",
        "commands",
        "environment",
        "friction",
        "monitors",
        "signals",
        "values",
    )

    def __init__(self, lights: Sequence[Signal] = ()) -> None:
        self.environment: model.Environment | None = None
        self.clock: model.TimeOfDay | None = None
        self.clock_since = 0.0
        self.friction = math.inf
        self.monitors: dict[str, bool] = {}
        self.signals: dict[str, str] = {}
        self.values: dict[str, str] = {}
        self.commands: list[tuple[float, str, str]] = []
        self._named: dict[str, tuple[str, ...]] = {}  # name of a light -> the ids of all that have it
        for light in lights:
            self._named[light.name] = (*self._named.get(light.name, ()), light.id)
        self._named.update({light.id: (light.id,) for light in lights})  # an id comes before a name

    def show(self, name: str, state: str) -> None:
        """Set the state of the signal with this id, or else of all that have this name."""
        self.signals.update(dict.fromkeys(self._ids(name), state))

    def shows(self, name: str, state: str) -> bool:
        """Whether the signal with this id, or else each that has this name, is in the state."""
        return all(self.signals.get(each) == state for each in self._ids(name))

    def _ids(self, name: str) -> tuple[str, ...]:
        return self._named.get(name, (name,))
