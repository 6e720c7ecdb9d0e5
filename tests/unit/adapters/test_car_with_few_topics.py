"""A real car by the wall clock that has what any car must have and no more, in a thread of this process, on DDS.

Its clock is a day ahead, and its accelerometer's stamps lie a millisecond before those of its motion.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator

import msgspec
import numpy as np
import pytest

pytest.importorskip("cyclonedds")

from vehicle.adapters.process import Lease
from vehicle.adapters.topic_car import Ros2Car
from vehicle.messages import Command, FloatArray, Imu, Odometry, VehicleDescription, VehicleState, no_surroundings
from vehicle.wire import convert, topics
from vehicle.wire import ros2_types as ros
from vehicle.wire.dds import LOOPBACK, DdsTransport

SHEET = VehicleDescription(4.0, 2.0, 1.5, 2.5, 1.2, 0.35, 20.0, 2.5, 8.0, 1000.0)
START = VehicleState(t=0.0, x=30.0, y=5.0, yaw=0.3, v=0.0)
DAY = 86_400 * 10**9  # ns
SAYS = (topics.DESCRIPTION, topics.DONE, topics.ODOMETRY, topics.FEEDBACK, topics.REFERENCE_IMU)


class SmallCar:
    """No camera, no LiDAR, no GNSS; it knows nothing of objects and signals. `stamps` [ns] are of its commands."""

    def __init__(self, domain: int) -> None:
        self._wire = DdsTransport(domain, None, SAYS, (topics.COMMAND, topics.STEP))
        self.stamps: list[int] = []
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._live, daemon=True)
        self._thread.start()

    @staticmethod
    def clock() -> int:
        return time.monotonic_ns() + DAY

    def close(self) -> None:
        self._over.set()
        self._thread.join()
        self._wire.close()

    def _live(self) -> None:
        while not self._over.is_set():
            for topic, message in self._wire.read(0.005):
                if topic == topics.COMMAND:
                    self.stamps.append(convert.nanoseconds(message.header))
                elif message.data[0] == 0:
                    self._wire.write(topics.DESCRIPTION, ros.String(msgspec.json.encode(SHEET).decode()))
                else:
                    answer = [*message.data[:2], self.clock(), self.clock()]
                    self._wire.write(topics.DONE, ros.UInt64MultiArray(data=answer))
            now = self.clock()
            self._wire.write(topics.REFERENCE_IMU, convert.imu_to_ros(Imu(0.0, 1.5, -0.7, 0.0), now - 1_000_000))
            self._wire.write(topics.ODOMETRY, convert.state_to_ros(START, now))
            self._wire.write(topics.FEEDBACK, convert.feedback_to_ros(Odometry(0.0, 0.0, 0.05), now))


@pytest.fixture(scope="module")
def both() -> Iterator[tuple[Ros2Car, SmallCar]]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CYCLONEDDS_URI", f"<CycloneDDS><Domain>{LOOPBACK}</Domain></CycloneDDS>")
        lease = Lease()
        small = SmallCar(lease.domain)
        try:
            car = Ros2Car(str(lease.domain), ready=30.0)
            yield car, small
            car.close()
        finally:
            small.close()
            lease.release()


def drive(car: Ros2Car) -> FloatArray:
    """Motion of 0.3 s under one command."""
    car.reset(START)
    car.observe(no_surroundings())
    car.apply(Command(0.0, 0.0, 0.5, 0.1, 0.0))
    return np.concatenate([car.step(0.1) for _ in range(3)])


def test_a_car_without_some_topics_is_found_and_tells_its_motion(both: tuple[Ros2Car, SmallCar]) -> None:
    rows = drive(both[0])
    assert rows[-5:, 1:3] == pytest.approx(np.tile([30.0, 5.0], (5, 1)))


def test_what_was_felt_last_counts_whatever_its_stamp(both: tuple[Ros2Car, SmallCar]) -> None:
    """Units with stamps of their own are no reason to take a car for one that feels nothing."""
    rows = drive(both[0])
    assert rows[-5:, 9:11] == pytest.approx(np.tile([1.5, -0.7], (5, 1)))


def test_commands_are_stamped_on_the_clock_of_the_car(both: tuple[Ros2Car, SmallCar]) -> None:
    """A car that refuses old commands by their stamp refused them all."""
    car, small = both
    before, begin = len(small.stamps), small.clock()
    drive(car)
    assert small.stamps[before:]
    for stamp in small.stamps[before:]:
        assert begin < stamp < small.clock()
