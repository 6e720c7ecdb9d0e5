"""ROS 2's wire: a DDS participant, on the loopback interface unless it is to reach a car on the network."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import partial
from typing import Any

from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState, WaitSet
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic as DdsTopic
from cyclonedds.util import duration

from vehicle.wire.end import Opener
from vehicle.wire.topics import Topic

AT_ONCE = 512  # samples taken from a reader in one call
SECOND = 1_000_000_000  # ns

LOOPBACK = """<General>
  <Interfaces><NetworkInterface address="127.0.0.1" multicast="false"/></Interfaces>
  <AllowMulticast>false</AllowMulticast><MaxMessageSize>65500B</MaxMessageSize>
</General>
<Discovery>
  <ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>20</MaxAutoParticipantIndex>
  <Peers><Peer address="127.0.0.1"/></Peers>
</Discovery>"""


def on_domain(domain: int, *, network: bool = False) -> Opener:
    """Opens DDS domain `domain` (0 to 232) on this machine, or on whatever network DDS is configured for
    (CYCLONEDDS_URI)."""
    return partial(DdsTransport, domain, None if network else LOOPBACK)


def qos() -> Qos:
    """Reliable, volatile, keep-all; classic CDR, as ROS 2 sends it."""
    return Qos(
        Policy.Reliability.Reliable(duration(seconds=5)),
        Policy.Durability.Volatile,
        Policy.History.KeepAll,
        Policy.DataRepresentation(use_cdrv0_representation=True),
    )


class DdsTransport:
    """A participant of a domain; `config` None: what CYCLONEDDS_URI says, or DDS's defaults."""

    def __init__(self, domain: int, config: str | None, writes: Sequence[Topic], reads: Sequence[Topic]) -> None:
        # A Domain made without a configuration would ignore CYCLONEDDS_URI; one that a participant makes does not.
        self._domain = None if config is None else Domain(domain, config)
        self._participant = DomainParticipant(domain)
        settings = qos()
        self._writers = {topic: DataWriter(self._participant, self._open(topic), settings) for topic in writes}
        self._readers = {topic: DataReader(self._participant, self._open(topic), settings) for topic in reads}
        self._waitset = WaitSet(self._participant)
        mask = ViewState.Any | InstanceState.Any | SampleState.NotRead
        self._conditions = [ReadCondition(reader, mask) for reader in self._readers.values()]
        for condition in self._conditions:
            self._waitset.attach(condition)

    def _open(self, topic: Topic) -> DdsTopic[Any]:
        return DdsTopic(self._participant, topic.dds_name, topic.type)

    def matched(self, needed: Collection[Topic] | None) -> bool:
        """Whether each topic, or each of the `needed` ones, has found its other end."""
        asked = {topic: writer.get_matched_subscriptions for topic, writer in self._writers.items()}
        asked |= {topic: reader.get_matched_publications for topic, reader in self._readers.items()}
        return all(found() for topic, found in asked.items() if needed is None or topic in needed)

    def write(self, topic: Topic, message: Any) -> None:
        """Put a message on a topic."""
        self._writers[topic].write(message)

    def read(self, wait: float) -> list[tuple[Topic, Any]]:
        """What has come since the last call; if that is nothing, what comes within `wait` [s]."""
        if wait > 0.0 and not self._waitset.wait(duration(nanoseconds=round(wait * SECOND))):
            return []
        return [
            (topic, sample)
            for topic, reader in self._readers.items()
            for sample in reader.take(AT_ONCE)
            if hasattr(sample, "__idl__")  # else a note that a writer has gone
        ]

    def close(self) -> None:
        """Leave the domain."""
        for entity in (self._waitset, *self._conditions, *self._readers.values(), *self._writers.values()):
            _delete(entity)
        _delete(self._participant)
        if self._domain is not None:
            _delete(self._domain)


def _delete(entity: Any) -> None:
    # The binding frees an entity only when Python forgets it; a domain must be gone before its number is used again.
    entity.__del__()
