"""One end of the wire in real time: messages when they come, stamps on one clock, the other end's clock estimated.

Stamps are those of the source, on the source's clock. A ping goes to the car with the harness's time, and comes back
with the car's times of receiving and sending: of those with the shortest way the offset of both clocks is taken
(as NTP does; D. L. Mills, RFC 5905, sec. 8). Its error is at most half the difference of both ways, and less than half
the shortest round trip.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, NamedTuple

from vehicle.wire.convert import SECOND, nanoseconds, stamp
from vehicle.wire.end import POLL, End
from vehicle.wire.ros2_types import UInt64MultiArray
from vehicle.wire.topics import Topic


class Ping(NamedTuple):
    """A ping that came back: round trip [ns] less the time in the car, and car's clock less harness's [ns]."""

    round_trip: int
    offset: int


class LiveEnd(End):
    """An end that waits for times, not for steps. `shift` [ns] is taken off the stamps of all that is taken."""

    shift = 0
    heard = 0  # monotonic [ns] when something came last

    def receive_until(self, until: int, on_step: Callable[[int, list[int]], None] | None = None) -> None:
        """Take what comes until `until` [ns, monotonic], and once what is there already.

        `on_step` gets time of arrival [ns, monotonic] and content of each message on the topic of steps at once.
        """
        self._collect(0.0, on_step)
        while (left := until - time.monotonic_ns()) > 0:
            if not self._collect(min(left / SECOND, POLL), on_step):
                self._alive()

    def say(self, *numbers: int) -> None:
        """Put a message on the topic of steps."""
        self._wire.write(self._step_out, UInt64MultiArray(data=list(numbers)))

    def take(self, topic: Topic) -> list[Any]:
        """The messages of a topic since the last call, oldest first, their stamps on this end's clock."""
        messages = super().take(topic)
        if self.shift:
            for message in messages:
                for part in (message, *getattr(message, "transforms", ())):
                    if hasattr(part, "header"):
                        part.header.stamp = stamp(nanoseconds(part.header) - self.shift)
        return messages

    def drop_until(self, topic: Topic, wanted: Callable[[Any], bool]) -> bool:
        """Forget the messages of a topic before the first wanted one; whether that has come."""
        kept = self._kept[topic]
        while kept and not wanted(kept[0]):
            kept.pop(0)
        return bool(kept)

    def _collect(self, wait: float, on_step: Callable[[int, list[int]], None] | None) -> bool:
        came = self._wire.read(wait)
        for topic, message in came:
            self.heard = time.monotonic_ns()
            if topic != self._step_in:
                self._kept[topic].append(message)
            elif on_step is not None:
                on_step(self.heard, list(message.data))
        return bool(came)
