"""Writers on DDS that offer something else than what the adapter asks for: read all the same, or named."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator
from typing import Any

import msgspec
import pytest

pytest.importorskip("cyclonedds")

from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic as DdsTopic

from vehicle.adapter import VehicleLost
from vehicle.adapters.process import Lease
from vehicle.adapters.ros2 import Ros2Vehicle
from vehicle.wire import ros2_types as ros
from vehicle.wire import topics
from vehicle.wire.dds import DdsTransport, on_domain
from vehicle.wire.topics import Topic

SENSOR_DATA = Qos(  # rclcpp::SensorDataQoS
    Policy.Reliability.BestEffort,
    Policy.History.KeepLast(5),
    Policy.DataRepresentation(use_cdrv0_representation=True),
)
RELIABLE = Qos(Policy.Reliability.Reliable(10**9), Policy.DataRepresentation(use_cdrv0_representation=True))
NEWER = Qos(Policy.Reliability.Reliable(10**9), Policy.DataRepresentation(use_xcdrv2_representation=True))


class Pair:
    """A transport that reads odometry and IMU and writes commands, and the participant of a driver."""

    def __init__(self) -> None:
        self.lease = Lease()
        self.ours = on_domain(self.lease.domain)([topics.COMMAND], [topics.ODOMETRY, topics.IMU])
        self.driver = DomainParticipant(self.lease.domain)

    def writer(self, topic: Topic, settings: Qos) -> Any:
        return DataWriter(self.driver, DdsTopic(self.driver, topic.dds_name, topic.type), settings)

    def close(self) -> None:
        self.ours.close()
        self.driver.__del__()
        self.lease.release()


@pytest.fixture
def pair() -> Iterator[Pair]:
    with contextlib.closing(Pair()) as pair:
        yield pair


def until(done: Callable[[], object]) -> None:
    deadline = time.monotonic() + 20.0
    while not done():
        assert time.monotonic() < deadline
        time.sleep(0.02)


@pytest.mark.parametrize("settings", [SENSOR_DATA, RELIABLE], ids=["best effort", "reliable"])
def test_writers_of_either_reliability_are_read(pair: Pair, settings: Qos) -> None:
    writer = pair.writer(topics.ODOMETRY, settings)
    until(lambda: pair.ours.matched([topics.ODOMETRY]))
    until(writer.get_matched_subscriptions)
    writer.write(ros.Odometry(child_frame_id="mine"))
    ((topic, message),) = pair.ours.read(10.0)
    assert (topic, message.child_frame_id) == (topics.ODOMETRY, "mine")
    assert pair.ours.unmatched() == {}


def test_a_writer_of_best_effort_that_comes_later_is_read_without_being_asked_for(pair: Pair) -> None:
    """As a topic that a real car need not have: nobody waits for it. Topics of reliable writers stay reliable."""
    reliable = pair.writer(topics.ODOMETRY, RELIABLE)
    until(lambda: pair.ours.matched([topics.ODOMETRY]))
    late = pair.writer(topics.IMU, SENSOR_DATA)
    came: list[tuple[Topic, Any]] = []

    def read() -> bool:
        late.write(ros.Imu())
        came.extend(pair.ours.read(0.02))
        return bool(came)

    until(read)
    assert came[0][0] == topics.IMU
    assert isinstance(pair.ours, DdsTransport)
    assert isinstance(pair.ours._readers[topics.ODOMETRY].get_qos()[Policy.Reliability], Policy.Reliability.Reliable)
    assert reliable.get_matched_subscriptions()


def test_what_was_sent_reliably_before_a_writer_of_best_effort_came_is_not_lost(pair: Pair) -> None:
    first = pair.writer(topics.ODOMETRY, RELIABLE)
    until(lambda: pair.ours.matched([topics.ODOMETRY]))
    until(first.get_matched_subscriptions)
    first.write(ros.Odometry(child_frame_id="first"))
    time.sleep(0.1)
    second = pair.writer(topics.ODOMETRY, SENSOR_DATA)
    until(lambda: pair.ours.matched([topics.ODOMETRY]) and second.get_matched_subscriptions())
    second.write(ros.Odometry(child_frame_id="second"))
    came: list[tuple[Topic, Any]] = []
    until(lambda: came.extend(pair.ours.read(0.02)) or len(came) == 2)
    assert [message.child_frame_id for _, message in came] == ["first", "second"]


def test_an_end_that_does_not_match_is_named_with_its_qos(pair: Pair) -> None:
    wrong = pair.writer(topics.ODOMETRY, NEWER)
    other = DdsTopic(pair.driver, topics.COMMAND.dds_name, ros.String)
    reader = DataReader(pair.driver, other, RELIABLE)
    until(lambda: len(pair.ours.unmatched()) == 2)
    assert dict(pair.ours.unmatched()) == {
        topics.ODOMETRY: "written as nav_msgs::msg::dds_::Odometry_ (reliable, volatile, XCDR2 only)",
        topics.COMMAND: "read as std_msgs::msg::dds_::String_ (reliable, volatile)",
    }
    assert not wrong.get_matched_subscriptions()
    assert not reader.get_matched_publications()


def test_a_writer_of_best_effort_that_has_just_come_is_not_unfit(pair: Pair) -> None:
    """As that of a sensor that starts while a run is reset: it is read from the next look on."""
    writer = pair.writer(topics.IMU, SENSOR_DATA)
    assert isinstance(pair.ours, DdsTransport)
    until(lambda: pair.ours._readers[topics.IMU].get_requested_incompatible_qos_status().total_count)
    assert pair.ours.unmatched() == {}
    until(writer.get_matched_subscriptions)


def test_a_writer_of_best_effort_is_read_beside_one_that_cannot_match(pair: Pair) -> None:
    """Of several writers that are refused, the reader remembers only why the last one was."""
    assert isinstance(pair.ours, DdsTransport)
    refused = pair.ours._readers[topics.ODOMETRY].get_requested_incompatible_qos_status
    writer = pair.writer(topics.ODOMETRY, SENSOR_DATA)
    until(lambda: refused().total_count == 1)
    other = pair.writer(topics.ODOMETRY, NEWER)
    until(lambda: refused().total_count == 2)
    until(lambda: pair.ours.matched([topics.ODOMETRY]) and writer.get_matched_subscriptions())
    reader = pair.ours._readers[topics.ODOMETRY]
    assert pair.ours.matched([topics.ODOMETRY])
    assert pair.ours._readers[topics.ODOMETRY] is reader  # it is made anew once
    assert not other.get_matched_subscriptions()


def test_a_car_that_does_not_come_is_told_of_with_what_is_there(pair: Pair) -> None:
    wrong = pair.writer(topics.DONE, NEWER)
    with pytest.raises(VehicleLost, match=r"^no car answered .*; /simulation/done is written as std_msgs.*XCDR2 only"):
        Ros2Vehicle(on_domain(pair.lease.domain, network=True), lambda: None, ready=1.0)
    assert not wrong.get_matched_subscriptions()


def test_a_topic_that_does_not_fit_is_a_trouble_of_each_run() -> None:
    from tests.unit.adapters.test_words_before_a_reset import SHEET, STATE

    class Unfit:
        """An end on which a car answers each step, and the IMU has another type."""

        def __init__(self, *_: Any) -> None:
            self.at = 0, 0

        def take(self, topic: Topic) -> list[Any]:
            return [ros.String(msgspec.json.encode(SHEET).decode())] if topic == topics.DESCRIPTION else []

        def step(self, number: int, stamp: int) -> None:
            self.at = number, stamp

        def next_step(self, timeout: float, *, at_least: int = 0) -> tuple[int, int]:
            return self.at

        matched = staticmethod(lambda: True)
        send = staticmethod(lambda topic, message: None)
        unmatched = staticmethod(lambda: {topics.IMU: "written as x (best effort)"})

    troubles: list[str] = []
    end: Any = Unfit
    car = Ros2Vehicle(lambda w, r: None, lambda: None, record=lambda t: troubles.append(f"{t.topic} {t}"), end=end)  # type: ignore[arg-type,return-value]
    car.reset(STATE)
    assert troubles == ["/imu/data unfit: written as x (best effort)"]
