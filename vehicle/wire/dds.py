"""One end of the wire: a DDS participant on the loopback interface, and lock-step with the other end.

DDS keeps the order within a topic, not between topics. So a step names, besides its number and time, how many samples
its sender has put on each topic; the receiver goes on when it has them all. That makes stepped time deterministic.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState, WaitSet
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic as DdsTopic
from cyclonedds.util import duration

from vehicle.wire.ros2_types import UInt64MultiArray
from vehicle.wire.topics import Topic

POLL = 0.02  # s, between two looks at whether the other end is still there
AT_ONCE = 512  # samples taken from a reader in one call

LOOPBACK = """<General>
  <Interfaces><NetworkInterface address="127.0.0.1" multicast="false"/></Interfaces>
  <AllowMulticast>false</AllowMulticast><MaxMessageSize>65500B</MaxMessageSize>
</General>
<Discovery>
  <ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>20</MaxAutoParticipantIndex>
  <Peers><Peer address="127.0.0.1"/></Peers>
</Discovery>"""


class Silence(Exception):
    """The other end did not say in time what was waited for."""


def qos() -> Qos:
    """Reliable, volatile, keep-all; classic CDR, as ROS 2 sends it."""
    return Qos(
        Policy.Reliability.Reliable(duration(seconds=5)),
        Policy.Durability.Volatile,
        Policy.History.KeepAll,
        Policy.DataRepresentation(use_cdrv0_representation=True),
    )


class End:
    """One end on DDS domain `domain` (0 to 232): it writes some topics and reads others.

    `alive` is asked while it waits, and says by an exception that waiting is in vain.
    """

    config: str | None = LOOPBACK  # of DDS; None: what CYCLONEDDS_URI says, or its defaults

    def __init__(
        self,
        domain: int,
        writes: Sequence[Topic],
        reads: Sequence[Topic],
        step: tuple[Topic, Topic],
        alive: Callable[[], None],
    ) -> None:
        self._alive = alive
        self._writes, self._reads = tuple(writes), tuple(reads)
        self._step_out, self._step_in = step
        self._domain = Domain(domain) if self.config is None else Domain(domain, self.config)
        self._participant = DomainParticipant(domain)
        settings = qos()
        self._writers = {
            topic: DataWriter(self._participant, self._open(topic), settings)
            for topic in (*self._writes, self._step_out)
        }
        self._readers = {
            topic: DataReader(self._participant, self._open(topic), settings) for topic in (*self._reads, self._step_in)
        }
        self._sent = dict.fromkeys(self._writes, 0)
        self._got = dict.fromkeys(self._reads, 0)
        self._kept: dict[Topic, list[Any]] = {topic: [] for topic in self._reads}
        self._steps: deque[list[int]] = deque()
        self._waitset = WaitSet(self._participant)
        mask = ViewState.Any | InstanceState.Any | SampleState.NotRead
        self._conditions = [ReadCondition(reader, mask) for reader in self._readers.values()]
        for condition in self._conditions:
            self._waitset.attach(condition)

    def _open(self, topic: Topic) -> DdsTopic[Any]:
        return DdsTopic(self._participant, topic.dds_name, topic.type)

    def matched(self) -> bool:
        """Whether each topic has found its other end."""
        return all(w.get_matched_subscriptions() for w in self._writers.values()) and all(
            r.get_matched_publications() for r in self._readers.values()
        )

    def send(self, topic: Topic, message: Any) -> None:
        """Put a message on a topic."""
        self._writers[topic].write(message)
        self._sent[topic] += 1

    def step(self, number: int, stamp: int) -> None:
        """Say that step `number` reaches to `stamp` [ns], and how much was sent on each topic until now."""
        counts = [self._sent[topic] for topic in self._writes]
        self._writers[self._step_out].write(UInt64MultiArray(data=[number, stamp, *counts]))

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
        """Leave the domain."""
        for entity in (self._waitset, *self._conditions, *self._readers.values(), *self._writers.values()):
            _delete(entity)
        _delete(self._participant)
        _delete(self._domain)

    def _receive(self) -> None:
        if not self._waitset.wait(duration(seconds=POLL)):
            self._alive()
            return
        for topic, reader in self._readers.items():
            for sample in reader.take(AT_ONCE):
                if not hasattr(sample, "__idl__"):  # a note that a writer has gone
                    continue
                if topic == self._step_in:
                    self._steps.append(list(sample.data))
                else:
                    self._got[topic] += 1
                    self._kept[topic].append(sample)


def _delete(entity: Any) -> None:
    # The binding frees an entity only when Python forgets it; a domain must be gone before its number is used again.
    entity.__del__()
