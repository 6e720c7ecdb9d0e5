"""A real car by the wall clock, its wire played by hand: what it said before a reset is no part of the next run."""

from __future__ import annotations

import contextlib
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from typing import Any

import msgspec
import pytest

pytest.importorskip("cyclonedds")
pytest.importorskip("cantools")

from tests.unit.adapters.test_can_bus import LivePair, without
from vehicle.adapter import Hands, VehicleLost
from vehicle.adapters import topic_car
from vehicle.adapters.live import LiveCar
from vehicle.messages import Odometry, VehicleDescription, VehicleState
from vehicle.wire import convert, topics
from vehicle.wire import ros2_types as ros
from vehicle.wire.live import LiveEnd

FIRST, SECOND = 0.1, -0.2  # rad, the steering angles of the first and the second run
SHEET = VehicleDescription(4.0, 2.0, 1.5, 2.5, 1.2, 0.35, 20.0, 2.5, 8.0, 1000.0)
STATE = VehicleState(t=0.0, x=0.0, y=0.0, z=0.0, yaw=0.0, v=0.0, vx=0.0, vy=0.0, yaw_rate=0.0, position_sigma=0.0)


class HandEnd(LiveEnd):
    """The end of a wire on which a car speaks each time that somebody listens. `says` are its messages by topic."""

    shift = 0
    heard = 0

    def __init__(self, *_: Any) -> None:
        self.says: Callable[[], dict[topics.Topic, Any]] = dict
        self.kept: dict[topics.Topic, list[Any]] = defaultdict(list)
        self.kept[topics.DESCRIPTION] = [ros.String(msgspec.json.encode(SHEET).decode())]

    def matched(self, needed: object = None) -> bool:
        return True

    def unmatched(self) -> dict[topics.Topic, str]:
        return {}

    def step(self, number: int, stamp: int) -> None:
        pass

    def next_step(self, timeout: float) -> tuple[int, int]:
        return 0, 0

    def say(self, *numbers: int) -> None:
        self.number = numbers[0]

    def send(self, topic: topics.Topic, message: Any) -> None:
        pass

    def take(self, topic: topics.Topic) -> list[Any]:
        return self.kept.pop(topic, [])

    def receive_until(self, until: int, on_step: Callable[[int, list[int]], None] | None = None) -> None:
        for topic, message in self.says().items():
            self.kept[topic].append(message)
        if on_step is not None:
            now = time.monotonic_ns()
            on_step(now, [self.number, now, now, now])

    def close(self) -> None:
        pass


@pytest.fixture
def pair(request: pytest.FixtureRequest) -> Iterator[LivePair]:
    with contextlib.closing(LivePair(request.node.name)) as pair:
        yield pair


def real_car(**more: Any) -> tuple[LiveCar, HandEnd]:
    car = LiveCar(lambda *_: None, lambda: None, is_real=True, end=HandEnd, **more)  # type: ignore[arg-type,return-value]
    end: Any = car._wire()
    return car, end


def standing_car() -> tuple[LiveCar, HandEnd, list[Any]]:
    """A real car that was put where it stands, and what will be told of its wire."""
    troubles: list[Any] = []
    car, end = real_car(record=troubles.append)
    end.says = lambda: {
        topics.ODOMETRY: convert.state_to_ros(STATE, 0),
        topics.FEEDBACK: convert.feedback_to_ros(Odometry(0.0, 0.0, 0.0), 0),
    }
    car.reset(STATE)
    return car, end, troubles


def steer(car: LiveCar) -> float:
    return car._state.steer


def over_can(pair: LivePair, angle: float) -> dict[topics.Topic, Any]:
    pair.unit.report(time.monotonic_ns(), Odometry(0.0, 0.0, angle), stamped=False)
    return {topics.ODOMETRY: convert.state_to_ros(STATE, 0)}


def test_a_steering_angle_of_an_earlier_run_is_none_of_the_next_one(
    pair: LivePair, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The CAN of the second run has lost the message with the steering angle; the speed still comes."""
    car, end = real_car(by_wire=pair.harness)
    end.says = lambda: over_can(pair, FIRST)
    car.reset(STATE)
    assert steer(car) == pytest.approx(FIRST, abs=1e-3)
    pair.harness.listen(0, time.monotonic_ns())
    end.says()  # between the runs, and not yet read
    without(pair, 272, monkeypatch)
    end.says = lambda: over_can(pair, SECOND)
    with pytest.raises(VehicleLost, match=r"^the car does not say how it steers: nothing on CAN$"):
        car.reset(STATE)


def test_a_second_run_begins_with_the_steering_angle_that_the_car_has_then(pair: LivePair) -> None:
    car, end = real_car(by_wire=pair.harness)
    for angle in (FIRST, SECOND):
        end.says = lambda angle=angle: over_can(pair, angle)  # type: ignore[misc]
        car.reset(STATE)
        assert steer(car) == pytest.approx(angle, abs=1e-3)


@pytest.mark.parametrize(
    ("topic", "says"),
    [
        (topics.FEEDBACK, "does not say how it steers: nothing on /vehicle/feedback"),
        (topics.ODOMETRY, "does not say where it is: nothing on /vehicle/odom"),
    ],
)
def test_a_topic_that_spoke_before_the_reset_only_has_said_nothing(topic: topics.Topic, says: str) -> None:
    said = {
        topics.ODOMETRY: convert.state_to_ros(STATE, 0),
        topics.FEEDBACK: convert.feedback_to_ros(Odometry(0.0, 0.0, FIRST), 0),
    }
    car, end = real_car()
    end.says = lambda: dict(said)
    car.reset(STATE)
    assert steer(car) == pytest.approx(FIRST)
    end.kept[topic].append(said.pop(topic))
    with pytest.raises(VehicleLost, match=says):
        car.reset(STATE)


@pytest.mark.parametrize(
    ("topic", "says"),
    [
        (topics.FEEDBACK, r"^the car does not say how it steers: its report holds what is no finite number$"),
        (topics.ODOMETRY, r"^the car does not say where it is: /vehicle/odom holds what is no finite number$"),
    ],
)
def test_a_car_that_does_not_know_yet_is_not_driven(topic: topics.Topic, says: str) -> None:
    """NaN, as reference systems send it until they are aligned."""
    nan = float("nan")
    said = {
        topics.ODOMETRY: convert.state_to_ros(STATE, 0),
        topics.FEEDBACK: convert.feedback_to_ros(Odometry(0.0, 0.0, FIRST), 0),
    }
    said[topic] = {
        topics.ODOMETRY: convert.state_to_ros(VehicleState(t=0.0, x=nan, y=nan, yaw=nan, v=0.0), 0),
        topics.FEEDBACK: convert.feedback_to_ros(Odometry(0.0, 0.0, nan), 0),
    }[topic]
    car, end = real_car()
    end.says = lambda: dict(said)
    with pytest.raises(VehicleLost, match=says):
        car.reset(STATE)


def test_hands_that_spoke_before_the_reset_only_are_the_drivers(monkeypatch: pytest.MonkeyPatch) -> None:
    said = {
        topics.ODOMETRY: convert.state_to_ros(STATE, 0),
        topics.FEEDBACK: convert.feedback_to_ros(Odometry(0.0, 0.0, FIRST), 0),
        **dict.fromkeys(topics.HANDS, ros.Bool(False)),
    }
    monkeypatch.setattr(topic_car, "LiveEnd", HandEnd)
    car = topic_car.TopicCar(lambda *_: None, "here")  # type: ignore[arg-type,return-value]
    end: Any = car._wire()
    end.says = lambda: dict(said)
    car.reset(STATE)
    assert car.hands == Hands(False, False)
    end.kept[topics.OVERRIDE].append(said.pop(topics.OVERRIDE))
    car.reset(STATE)
    assert car.hands == Hands(True, False)


def test_a_receiver_without_a_fix_is_no_fault_and_gives_no_place() -> None:
    """At 10 Hz for 3 s without one: the receiver is not silent, its wire is sound, and the stack gets nothing."""
    car, end, troubles = standing_car()
    car._health.reset({topics.FIX.name})
    seen = []
    for k in range(60):
        t = 0.1 * k
        place, _ = convert.fix_to_ros(convert.GnssFix(t, 5.0 * t, 0.0, 0.02), round(t * convert.SECOND))
        if 20 <= k < 50:
            place.status.status = -1
            place.latitude = place.longitude = place.altitude = float("nan")
        end.kept[topics.FIX].append(place)
        car._now = round(t * convert.SECOND)
        seen += car._observed().gnss
    assert troubles == []
    assert [round(10.0 * fix.t) for fix in seen] == [*range(20), *range(50, 60)]


def test_a_fix_far_from_where_the_car_says_it_is_is_kept_back_and_named() -> None:
    """Of a car in Munich whose map has its origin there: the fix comes out 1,400 km from its pose."""
    car, end, troubles = standing_car()
    car._begin()
    end.kept[topics.ODOMETRY].append(convert.state_to_ros(STATE, 0))
    car._rows()
    place, _ = convert.fix_to_ros(convert.GnssFix(0.0, 0.0, 0.0, 0.02), 0)
    place.latitude, place.longitude = 48.137, 11.575
    end.kept[topics.FIX].append(place)
    assert car._observed().gnss == ()
    (elsewhere,) = troubles
    assert (elsewhere.topic, str(elsewhere)) == ("/gnss/fix", "elsewhere 1.44e+06 m")
    place.latitude, place.longitude = 40.5127, -3.348
    place.header.stamp = convert.stamp(200_000_000)
    end.kept[topics.FIX].append(place)
    car._now = 200_000_000
    car._health.reset()
    car._begun = False
    (fix,) = car._observed().gnss
    assert (fix.x, fix.y) == pytest.approx((0.0, 77.8), abs=0.1)
