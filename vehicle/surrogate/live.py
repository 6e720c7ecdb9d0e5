"""The surrogate in real time: it lives by its own clock, obeys what comes, and stops by itself when nothing does."""

from __future__ import annotations

import time
from collections.abc import Sequence

import msgspec

from vehicle.messages import VehicleState
from vehicle.surrogate.ecu import DriveByWire
from vehicle.surrogate.hidden import Hidden
from vehicle.surrogate.node import MOTION, SUBSTEP, Node
from vehicle.surrogate.truth import Truth
from vehicle.wire import topics
from vehicle.wire.end import Opener
from vehicle.wire.live import LiveEnd
from vehicle.wire.ros2_types import Bool, String

BEGINNING = 1_000_000_000_000  # ns: what its clock shows at its start, so that nobody takes it for the harness's


class LiveNode(Node):
    """A surrogate car on the wire that `opener` opens, by the wall clock.

    at      x, y [m] and yaw [rad] where it stands before it is placed
    driver  publish the hands of one, who never takes over: for a surrogate in the place of a real car
    """

    stepped = False

    def __init__(
        self,
        opener: Opener,
        hidden: Hidden,
        seed: int,
        unit: DriveByWire | None = None,
        *,
        at: Sequence[float] = (0.0, 0.0, 0.0),
        driver: bool = False,
        truth: Truth | None = None,
    ) -> None:
        self._zero = time.monotonic_ns() - BEGINNING
        self._driver = driver
        if driver:
            self.writes = (*topics.FROM_CAR, *topics.HANDS)
        super().__init__(opener, hidden, seed, unit, truth=truth, end=LiveEnd)
        x, y, yaw = at
        self._place(VehicleState(t=0.0, x=x, y=y, yaw=yaw, v=0.0))

    def serve(self) -> None:
        """Live until the parent ends."""
        end = self._end
        assert isinstance(end, LiveEnd)
        while True:
            end.receive_until(self._zero + self._now + SUBSTEP, self._answer)
            self._obey()
            if self._unit is not None:
                self._unit.listen(self._now)
            self._advance(self._now + SUBSTEP)
            if self._driver and (self._now - self._start) % MOTION == 0:
                for topic in topics.HANDS:
                    self._queue(topic, Bool(False), 0)
            self._look()
            self._deliver()

    def _answer(self, arrived: int, numbers: list[int]) -> None:
        end = self._end
        assert isinstance(end, LiveEnd)
        number, sent = numbers[:2]
        if number == 0:
            if end.matched():
                end.send(topics.DESCRIPTION, String(msgspec.json.encode(self.description).decode()))
            return
        end.say(number, sent, arrived - self._zero, time.monotonic_ns() - self._zero)

    def _place(self, state: VehicleState) -> None:
        """There, but its clock goes on."""
        super()._place(state)
        # The grid of its sensors begins now; what the clock has skipped while it was placed is not made up for.
        self._now = self._start = (time.monotonic_ns() - self._zero) // SUBSTEP * SUBSTEP
        self._commanded = self._now
