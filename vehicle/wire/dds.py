"""ROS 2's wire: a DDS participant, on the loopback interface unless it is to reach a car on the network.

What is read is asked for as reliable. A writer that offers best effort (rclcpp::SensorDataQoS, as most drivers do)
would never match that, so a topic on which one is found is read as best effort from then on: that matches both kinds.
What is lost then is found by the stamps (`vehicle/wire/missing.py`).
"""

from __future__ import annotations

import re
import time
from collections.abc import Collection, Sequence
from functools import partial
from typing import Any

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication, BuiltinTopicDcpsSubscription
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
LOOK = 0.1  # s between two looks at whether a writer offers less than is asked for; chosen: once in two ticks
RELIABILITY = 11  # DDS_RELIABILITY_QOS_POLICY_ID (DDS 1.4, 2.3.3)
ENDPOINTS = 4096  # that are looked through; chosen: a large ROS 2 system has some hundreds

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


def qos(*, reliable: bool = True) -> Qos:
    """Reliable or best effort, volatile, keep-all; classic CDR, as ROS 2 sends it."""
    return Qos(
        Policy.Reliability.Reliable(duration(seconds=5)) if reliable else Policy.Reliability.BestEffort,
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
        self._writers = {topic: DataWriter(self._participant, self._open(topic), qos()) for topic in writes}
        self._waitset = WaitSet(self._participant)
        self._readers: dict[Topic, DataReader[Any]] = {}
        self._conditions: dict[Topic, ReadCondition] = {}
        self._looked, self._taken_over = time.monotonic(), list[tuple[Topic, Any]]()
        self._best_effort: set[Topic] = set()  # what is read so
        for topic in reads:
            self._listen(topic, qos())

    def _listen(self, topic: Topic, settings: Qos) -> None:
        reader = DataReader(self._participant, self._open(topic), settings)
        condition = ReadCondition(reader, ViewState.Any | InstanceState.Any | SampleState.NotRead)
        self._readers[topic], self._conditions[topic] = reader, condition
        self._waitset.attach(condition)

    def _meet_best_effort(self) -> None:
        """Read as best effort where a writer offers no more than that."""
        self._looked = time.monotonic()
        for topic, reader in tuple(self._readers.items()):
            refused = reader.get_requested_incompatible_qos_status()
            if topic in self._best_effort or not refused.total_count:
                continue
            if refused.last_policy_id != RELIABILITY and not self._is_offered_as_best_effort(topic):
                continue
            self._best_effort.add(topic)
            self._taken_over += _taken(topic, reader)
            self._waitset.detach(self._conditions[topic])
            _delete(self._conditions[topic])
            _delete(reader)
            self._listen(topic, qos(reliable=False))

    def _is_offered_as_best_effort(self, topic: Topic) -> bool:
        """Whether any writer does, as the reader tells only why it refused the last one."""
        return any(
            each.topic_name == topic.dds_name and each.qos[Policy.Reliability] == Policy.Reliability.BestEffort
            for each in self._endpoints(BuiltinTopicDcpsPublication)
        )

    def _endpoints(self, which: Any) -> list[Any]:
        """Writers (BuiltinTopicDcpsPublication) or readers (BuiltinTopicDcpsSubscription) of all other participants."""
        listing, mine = BuiltinDataReader(self._participant, which), self._participant.get_guid()
        found = [each for each in listing.take(ENDPOINTS) if hasattr(each, "qos") and each.participant_key != mine]
        _delete(listing)
        return found

    def _open(self, topic: Topic) -> DdsTopic[Any]:
        return DdsTopic(self._participant, topic.dds_name, topic.type)

    def matched(self, needed: Collection[Topic] | None) -> bool:
        """Whether each topic, or each of the `needed` ones, has found its other end."""
        self._meet_best_effort()
        asked = {topic: writer.get_matched_subscriptions for topic, writer in self._writers.items()}
        asked |= {topic: reader.get_matched_publications for topic, reader in self._readers.items()}
        return all(found() for topic, found in asked.items() if needed is None or topic in needed)

    def write(self, topic: Topic, message: Any) -> None:
        """Put a message on a topic."""
        self._writers[topic].write(message)

    def read(self, wait: float) -> list[tuple[Topic, Any]]:
        """What has come since the last call; if that is nothing, what comes within `wait` [s]."""
        if time.monotonic() - self._looked > LOOK:
            self._meet_best_effort()
        came, self._taken_over = self._taken_over, []
        if not came and wait > 0.0 and not self._waitset.wait(duration(nanoseconds=round(wait * SECOND))):
            return []
        return came + [each for topic, reader in self._readers.items() for each in _taken(topic, reader)]

    def unmatched(self) -> dict[Topic, str]:
        """What is on the other end of each topic and does not match: type, QoS. A topic that nobody has is left out."""
        self._meet_best_effort()  # a writer that has come since the last look is no misfit
        refused: dict[Topic, str] = {}
        for what, which, own in (
            ("written", BuiltinTopicDcpsPublication, {t: r.get_matched_publications for t, r in self._readers.items()}),
            ("read", BuiltinTopicDcpsSubscription, {t: w.get_matched_subscriptions for t, w in self._writers.items()}),
        ):
            found = self._endpoints(which)
            for topic, matched in own.items():
                others = {_shown(each) for each in found if each.topic_name == topic.dds_name}
                if others and not matched():
                    refused[topic] = f"{what} as {' and as '.join(sorted(others))}"
        return refused

    def close(self) -> None:
        """Leave the domain."""
        for entity in (self._waitset, *self._conditions.values(), *self._readers.values(), *self._writers.values()):
            _delete(entity)
        _delete(self._participant)
        if self._domain is not None:
            _delete(self._domain)


def _taken(topic: Topic, reader: Any) -> list[tuple[Topic, Any]]:
    samples = reader.take(AT_ONCE)
    return [(topic, sample) for sample in samples if hasattr(sample, "__idl__")]  # else a note that a writer has gone


def _shown(endpoint: Any) -> str:
    """Type and those policies of an endpoint that decide whether it matches."""
    policies = [endpoint.qos[kind] for kind in (Policy.Reliability, Policy.Durability, Policy.DataRepresentation)]
    words = [type(policy).__qualname__.rpartition(".")[2] for policy in policies[:2] if policy is not None]
    names = [re.sub(r"\B(?=[A-Z])", " ", word).lower() for word in words]
    xcdr2 = policies[2] is not None and not policies[2].use_cdrv0_representation
    return f"{endpoint.type_name} ({', '.join([*names, *(['XCDR2 only'] if xcdr2 else [])])})"


def _delete(entity: Any) -> None:
    # The binding frees an entity only when Python forgets it; a domain must be gone before its number is used again.
    entity.__del__()
