"""The driver that a vehicle has in the place of the default controller: what it was told by its file."""

from __future__ import annotations

import math

from openscenario.model.entities import Controller


class Driver:
    """The driver of one vehicle: which domains it has, the speed that it wishes [m/s] and its time gap [s].

    A wished speed of None is the one that the vehicle was last given; a time gap of None is the usual one.
    """

    def __init__(self, controller: Controller) -> None:
        self.longitudinal = self.lateral = False
        self.wished = _number(controller, "setSpeed")
        self.headway = _number(controller, "timeGap")

    @property
    def at_work(self) -> bool:
        """Whether it drives anything."""
        return self.longitudinal or self.lateral


def _number(controller: Controller, name: str) -> float | None:
    try:
        value = float(controller.properties.get(name) or "")
    except ValueError:
        return None
    return value if 0.0 < value < math.inf else None
