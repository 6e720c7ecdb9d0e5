"""One end of a wire: topics that it writes and reads, and lock-step with the other end.

A transport (DDS, ROS 1) keeps the order within a topic, not between topics. So a step names, besides its number and
time, how many messages its sender has put on each topic; the receiver goes on when it has them all. That makes stepped
time deterministic.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any, Protocol, TypeAlias

from vehicle.wire.ros2_types import UInt64MultiArray
from vehicle.wire.topics import Topic

POLL = 0.02  # s, between two looks at whether the other end is still there


class Silence(Exception):
    """The other end did not say in time what was waited for."""


class Transport(Protocol):
    """What carries messages between two ends, none lost (but from writers that do not care), in their order."""

    def matched(self, needed: Collection[Topic] | None) -> bool:
        """Whether each topic, or each of the `needed` ones, has found its other end."""

    def unmatched(self) -> Mapping[Topic, str]:
        """Topics that somebody else has in a way that does not fit, and in which."""

    def write(self, topic: Topic, message: Any) -> None:
        """Put a message on a topic."""

    def read(self, wait: float) -> list[tuple[Topic, Any]]:
        """What has come since the last call; if that is nothing, what comes within `wait` [s]."""

    def close(self) -> None:
        """Leave the wire."""


Opener: TypeAlias = Callable[[Sequence[Topic], Sequence[Topic]], Transport]
"""Opens a transport for topics that are written and topics that are read."""


class End:
    """One end of the wire that `opener` opens: it writes some topics and reads others.

    `step` are the topics on which it says and hears of steps. `alive` is asked while it waits, and says by an exception
    that waiting is in vain.
    """

    def __init__(
        self,
        opener: Opener,
        writes: Sequence[Topic],
        reads: Sequence[Topic],
        step: tuple[Topic, Topic],
        alive: Callable[[], None],
    ) -> None:
        self._alive = alive
        self._writes, self._reads = tuple(writes), tuple(reads)
        self._step_out, self._step_in = step
        self._sent = dict.fromkeys(self._writes, 0)
        self._got = dict.fromkeys(self._reads, 0)
        self._kept: dict[Topic, list[Any]] = {topic: [] for topic in self._reads}
        self._steps: deque[list[int]] = deque()
        self._wire = opener((*self._writes, self._step_out), (*self._reads, self._step_in))

    def matched(self, needed: Collection[Topic] | None = None) -> bool:
        """Whether each topic, or each of the `needed` ones, has found its other end."""
        return self._wire.matched(needed)

    def unmatched(self) -> Mapping[Topic, str]:
        """Topics that somebody else has in a way that does not fit, and in which."""
        return self._wire.unmatched()

    def send(self, topic: Topic, message: Any) -> None:
        """Put a message on a topic."""
        self._wire.write(topic, message)
        self._sent[topic] += 1

    def step(self, number: int, stamp: int) -> None:
        """Say that step `number` reaches to `stamp` [ns], and how much was sent on each topic until now."""
        counts = [self._sent[topic] for topic in self._writes]
        self._wire.write(self._step_out, UInt64MultiArray(data=[number, stamp, *counts]))

    def next_step(self, timeout: float, *, at_least: int = 0) -> tuple[int, int]:
        """Number and time [ns] of the next step of the other end from number `at_least` on, once all that was sent
        before it is here.

        Raises Silence after `timeout` [s].
        """
        deadline = time.monotonic() + timeout
        while True:
            while self._steps and self._steps[0][0] < at_least:
                self._steps.popleft()
            if self._steps and all(
                self._got[topic] >= count for topic, count in zip(self._reads, self._steps[0][2:], strict=True)
            ):
                number, stamp, *_ = self._steps.popleft()
                return number, stamp
            if time.monotonic() > deadline:
                raise Silence(f"nothing came for {timeout:g} s")
            self._receive()

    def take(self, topic: Topic) -> list[Any]:
        """The messages of a topic since the last call, oldest first."""
        kept = self._kept[topic]
        self._kept[topic] = []
        return kept

    def close(self) -> None:
        """Leave the wire."""
        self._wire.close()

    def _receive(self) -> None:
        came = self._wire.read(POLL)
        if not came:
            self._alive()
        for topic, message in came:
            if topic == self._step_in:
                self._steps.append(list(message.data))
            else:
                self._got[topic] += 1
                self._kept[topic].append(message)
