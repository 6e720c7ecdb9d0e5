"""Faults of a wire, named from the messages alone; what cannot be used is kept back. Times in seconds, 10 Hz."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vehicle.messages import CameraBox, CameraFrame, GnssFix, Imu, LidarScan
from vehicle.wire.health import Health, Trouble

TOPIC = "/gnss/fix"
RATE = 10.0


class Receiver:
    """A topic at 10 Hz whose messages are 20 ms old when they come; the car drives at 5 m/s."""

    def __init__(self) -> None:
        self.troubles: list[Trouble] = []
        self.health = Health(self.troubles.append)
        self.health.speed = 5.0
        self.kept: list[GnssFix] = []

    def get(self, *stamps: float, now: float | None = None, **changes: float) -> None:
        for stamp in stamps:
            fix = GnssFix(stamp, changes.get("x", 5.0 * stamp), changes.get("y", 0.0), 0.02)
            arrival = stamp + 0.02 if now is None else now
            self.kept += self.health.sift(TOPIC, [fix], arrival)
            self.health.look(arrival)

    @property
    def named(self) -> list[str]:
        return [trouble.what for trouble in self.troubles]


@pytest.fixture
def receiver() -> Receiver:
    receiver = Receiver()
    receiver.get(*(k / RATE for k in range(20)))
    assert receiver.named == []
    return receiver


def test_a_sound_topic_has_no_trouble(receiver: Receiver) -> None:
    receiver.get(*(k / RATE for k in range(20, 200)))
    assert receiver.named == []
    assert len(receiver.kept) == 200


def test_two_messages_missing_are_two_lost(receiver: Receiver) -> None:
    """Told once eight have followed; before, they may only be held up."""
    receiver.get(*(k / RATE for k in range(22, 29)))
    assert receiver.named == []
    receiver.get(2.9)
    assert [(t.what, t.amount, str(t)) for t in receiver.troubles] == [("lost", 2.0, "lost 2 messages")]


def test_a_gap_in_times_of_arrival_tells_of_no_loss(receiver: Receiver) -> None:
    """Frames of a CAN bus are stamped when they come; what was lost of them their counters tell. Silence stays one."""
    (kept,) = receiver.health.sift(TOPIC, [GnssFix(2.2, 11.0, 0.0, 0.02)], 2.2, by_source=False)
    assert (kept.t, receiver.named) == (2.2, [])
    receiver.health.look(2.6)
    assert receiver.named == ["silent"]


def test_a_message_that_comes_twice_is_kept_once(receiver: Receiver) -> None:
    receiver.get(2.0, 2.0)
    assert receiver.named == ["repeated"]
    assert [fix.t for fix in receiver.kept[-2:]] == [1.9, 2.0]


def test_a_message_overtaken_by_the_next_is_kept_back(receiver: Receiver) -> None:
    """It is kept back, but it has come: none is lost."""
    receiver.get(2.1, now=2.12)
    receiver.get(2.0, now=2.12)
    assert receiver.kept[-1].t == 2.1
    receiver.get(*(k / RATE for k in range(22, 40)))
    assert receiver.named == ["out_of_order"]


def test_a_message_kept_back_has_come(receiver: Receiver) -> None:
    receiver.get(2.0, y=math.nan)
    receiver.get(2.1, x=500.0)
    receiver.get(*(k / RATE for k in range(22, 40)))
    assert receiver.named == ["not_finite", "jump"]


def test_a_late_message_counts_and_is_named(receiver: Receiver) -> None:
    receiver.get(2.0, now=2.32)
    assert receiver.named == ["late"]
    assert receiver.kept[-1].t == 2.0


@pytest.mark.parametrize(("stamp", "name"), [(2.5, "ahead"), (1.5, "stepped_back")])
def test_a_clock_that_steps_is_named_and_its_message_kept_back(receiver: Receiver, stamp: float, name: str) -> None:
    receiver.get(stamp, now=2.02)
    assert receiver.named == [name]
    assert receiver.kept[-1].t == 1.9


def test_silence_is_named_once_and_again_after_a_word(receiver: Receiver) -> None:
    """Three intervals are 0.3 s: 1.9 + 0.3 + the usual 0.02 s of delay."""
    for now in (2.2, 2.21, 2.23, 2.5, 3.0):
        receiver.health.look(now)
    assert [(t.what, t.t) for t in receiver.troubles] == [("silent", 2.23)]
    receiver.get(3.0)
    receiver.health.look(4.0)
    assert receiver.named == ["silent", "silent"]


@pytest.mark.parametrize("messages", [1, 2, 8])
def test_a_topic_that_dies_before_its_rhythm_is_known_is_silent_after_3_s(messages: int) -> None:
    receiver = Receiver()
    receiver.get(*(k / RATE for k in range(messages)))
    last = (messages - 1) / RATE + 0.02  # when it came
    for after in (0.5, 2.99, 3.01, 4.0):
        receiver.health.look(last + after)
    assert [(t.what, t.t) for t in receiver.troubles] == [("silent", pytest.approx(last + 3.01))]


def test_a_receiver_of_1_hz_is_not_silent_between_its_messages() -> None:
    receiver = Receiver()
    for k in range(200):
        if k % 10 == 0:
            receiver.get(k / RATE)
        receiver.health.look(k / RATE + 0.02)
    assert receiver.named == []


def test_a_topic_that_must_speak_and_never_does_is_silent_and_any_other_may_stay_away() -> None:
    receiver = Receiver()
    receiver.health.reset([TOPIC])
    for k in range(100):
        receiver.health.sift("/gnss/heading", [], 5.0 + 0.1 * k)
        receiver.health.look(5.0 + 0.1 * k)
    assert [(t.topic, t.what, t.t) for t in receiver.troubles] == [(TOPIC, "silent", pytest.approx(8.1))]


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_is_kept_back(receiver: Receiver, value: float) -> None:
    receiver.get(2.0, y=value)
    assert receiver.named == ["not_finite"]
    assert receiver.kept[-1].t == 1.9


def test_numbers_are_looked_for_in_clouds_and_boxes() -> None:
    troubles: list[Trouble] = []
    health = Health(troubles.append)
    cloud = np.zeros((3, 3))
    assert len(health.sift("/lidar/points", [LidarScan(0.0, cloud)], 0.0)) == 1
    cloud[2, 1] = np.nan
    assert health.sift("/lidar/points", [LidarScan(0.1, cloud)], 0.1) == []
    box = CameraBox(0.0, math.nan, 1.0, 1.0, "vehicle", 0.9)
    assert health.sift("/camera/detections", [CameraFrame(0.1, (box,))], 0.1) == []
    assert health.sift("/imu/data", [Imu(0.0, 0.0, 0.0, math.inf)], 0.1) == []
    assert [t.what for t in troubles] == ["not_finite"] * 3


def test_a_position_no_car_can_reach_is_kept_back(receiver: Receiver) -> None:
    """60 m/s for 0.1 s and 3 m of noise: 9 m."""
    receiver.get(2.0, x=9.5 + 8.9)
    receiver.get(2.1, x=9.5 + 8.9 + 60.0)
    assert receiver.named == ["jump"]
    assert receiver.kept[-1].t == 2.0


def test_positions_that_stay_elsewhere_are_believed_after_five(receiver: Receiver) -> None:
    """Then it was the one before them that was wrong."""
    receiver.get(2.0, 2.1, 2.2, 2.3, x=500.0)
    assert receiver.kept[-1].t == 1.9
    receiver.get(2.4, 2.5, x=500.0)
    assert receiver.kept[-1].t == 2.5


def test_a_position_that_stands_while_the_wheels_turn_is_frozen(receiver: Receiver) -> None:
    receiver.get(*(2.0 + k / RATE for k in range(10)), x=10.0)
    assert receiver.named == ["frozen"]


@pytest.mark.parametrize("speed", [5.0, -5.0])
def test_a_position_that_is_frozen_since_before_the_car_moved_is_named(receiver: Receiver, speed: float) -> None:
    """Ten positions of a standing car, then the wheels turn: the fifth position of the moving car names it, once."""
    receiver.health.speed = 0.0
    receiver.get(*(2.0 + k / RATE for k in range(10)), x=10.0)
    receiver.health.speed = speed
    receiver.get(*(3.0 + k / RATE for k in range(10)), x=10.0)
    assert [(t.what, t.t) for t in receiver.troubles] == [("frozen", pytest.approx(3.42))]


def test_a_standing_car_may_stand(receiver: Receiver) -> None:
    receiver.health.speed = 0.0
    receiver.get(*(2.0 + k / RATE for k in range(10)), x=10.0)
    assert receiver.named == []


def test_a_new_run_begins_without_a_past(receiver: Receiver) -> None:
    receiver.health.reset()
    receiver.get(0.0, 0.1)
    assert receiver.named == []
