"""A simulated driver on ground of 100 x 60 m, and one that notes what it is asked for."""

from __future__ import annotations

import math
from typing import Any

from pytest_dvp.gap.manoeuvres.driving_limits import Envelope
from pytest_dvp.gap.manoeuvres.simulated_driver import Driver
from pytest_dvp.gap.manoeuvres.simulated_driver import Test as Trial

ENVELOPE = Envelope(max_speed=10.0, max_acceleration=2.0, max_deceleration=4.0, max_lateral=4.0, length=100.0,
                    width=60.0, max_steer=0.45, steer_rate=1.0)  # fmt: skip


def driver(**given: Any) -> Driver:
    return Driver(ENVELOPE, 2.5, 3.0, **given)


class Listener(Driver):
    """Notes the tests and circles of a manoeuvre instead of driving them."""

    def __init__(self, envelope: Envelope = ENVELOPE, **given: Any) -> None:
        super().__init__(envelope, 2.5, 3.0, **given)
        self.wanted: list[Trial] = []
        self.notes: list[tuple[Any, ...]] = []

    def tests(self, wanted: Any) -> Any:
        self.wanted = list(wanted)
        return iter(())

    def note(self, *what: Any) -> Any:
        self.notes.append(what)
        return iter(())

    def stand(self, seconds: float) -> Any:
        return self.note("stand", seconds)

    def reach(self, speed: float) -> Any:
        return self.note("reach", speed)

    def other_side(self) -> Any:
        return self.note("other side")

    def close_circle(self, angle: float) -> Any:
        return self.note("close", angle)

    def halt(self) -> Any:
        return self.note("halt")

    def circle(self, speed: float, angle: float, *, turns: float = math.inf, seconds: float = 60.0) -> Any:
        return self.note("circle", speed, angle, turns, seconds)


def listened(manoeuvre: Any, **given: Any) -> Listener:
    d = Listener(**given)
    list(manoeuvre(d))
    return d
