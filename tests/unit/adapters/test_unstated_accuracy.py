"""Drivers that do not state how accurate they are: an accuracy is assumed, and said once in the run's notes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

pytest.importorskip("cyclonedds")

from pytest_dvp.drive.wire_log import WireLog, wire_notes, wire_verdict
from tests.unit.adapters.test_words_before_a_reset import STATE, real_car
from vehicle.messages import GnssFix, Imu, Odometry
from vehicle.wire import convert, topics
from vehicle.wire.health import Trouble

Spoil = Callable[[Any, Any], None]


class Drive:
    """A real car that stands, and what its receiver says ten times a second."""

    def __init__(self) -> None:
        self.troubles: list[Trouble] = []
        self.car, self.end = real_car(record=self.troubles.append)
        self.end.says = lambda: {
            topics.ODOMETRY: convert.state_to_ros(STATE, 0),
            topics.FEEDBACK: convert.feedback_to_ros(Odometry(0.0, 0.0, 0.0), 0),
        }
        self.car.reset(STATE)
        self.seen: list[GnssFix] = []
        self.felt: list[Imu] = []

    def begin(self) -> None:
        """A run."""
        self.car._begin()
        self.car._begun = False  # time is what `at` says
        self.car._health.reset()

    def at(self, t: float, **said: Any) -> None:
        """The tick at `t` [s], with one message on each of the topics that are named."""
        for name, message in said.items():
            message.header.stamp = convert.stamp(round(t * convert.SECOND))
            self.end.kept[getattr(topics, name)].append(message)
        self.car._now = round(t * convert.SECOND)
        observed = self.car._observed()
        self.seen += observed.gnss
        self.felt += observed.imu

    @property
    def notes(self) -> list[str]:
        return [f"{trouble.topic}: {trouble}" for trouble in self.troubles]


def place_and_heading() -> tuple[Any, Any]:
    place, heading = convert.fix_to_ros(GnssFix(0.0, 3.0, 4.0, 0.02, 0.7, 0.01), 0)
    assert heading is not None
    return place, heading


def all_zero(place: Any, heading: Any) -> None:
    place.position_covariance, heading.orientation_covariance = [0.0] * 9, [0.0] * 9


def not_a_number(place: Any, heading: Any) -> None:
    place.position_covariance, heading.orientation_covariance = [float("nan")] * 9, [0.0] * 8 + [float("nan")]


def negative(place: Any, heading: Any) -> None:
    place.position_covariance, heading.orientation_covariance = [-1.0] + [0.0] * 8, [0.0] * 8 + [-1.0]


@pytest.mark.parametrize("spoil", [all_zero, not_a_number, negative])
def test_an_accuracy_that_is_not_stated_is_assumed_and_said_once_a_run(spoil: Spoil) -> None:
    """sensor_msgs/Imu: "a covariance matrix of all zeros will be interpreted as covariance unknown"."""
    drive = Drive()
    for _ in range(2):
        drive.begin()
        for k in range(5):
            place, heading = place_and_heading()
            spoil(place, heading)
            drive.at(0.1 * k, FIX=place, HEADING=heading)
    assert {(fix.sigma, fix.yaw_sigma) for fix in drive.seen} == {(8.0 / 2.45, 0.035)}
    assert drive.notes == 2 * [
        "/gnss/heading: assumed: an accuracy, as none is stated: 0.035 rad (2 deg)",
        "/gnss/fix: assumed: an accuracy, as none is stated: 3.3 m per axis",
    ]


def test_an_accuracy_that_is_stated_counts_and_nothing_is_said() -> None:
    drive = Drive()
    drive.begin()
    place, heading = place_and_heading()
    drive.at(0.0, FIX=place, HEADING=heading)
    (fix,) = drive.seen
    assert (fix.sigma, fix.yaw_sigma) == (pytest.approx(0.02), pytest.approx(0.01))
    assert drive.notes == []


def test_a_sensor_without_an_error_stays_one_over_the_wire() -> None:
    """A twin's may have none; a variance of 0 would say that it is not known."""
    place, heading = convert.fix_to_ros(GnssFix(0.0, 3.0, 4.0, 0.0, 0.7, 0.0), 0)
    fix = convert.fix_from_ros(place, heading)
    assert isinstance(fix, GnssFix)
    assert (fix.sigma, fix.yaw_sigma) == (pytest.approx(1e-6), pytest.approx(1e-6))


@pytest.mark.parametrize("which", ["angular_velocity_covariance", "linear_acceleration_covariance"])
def test_an_imu_that_does_not_measure_is_not_used_and_that_is_said(which: str) -> None:
    """Not a car that never turns: sensor_msgs/Imu sets element 0 to -1 for "no estimate"."""
    drive = Drive()
    drive.begin()
    for k in range(3):
        message = convert.imu_to_ros(Imu(0.0, 1.0, 2.0, 0.0), 0)
        setattr(message, which, [-1.0] + [0.0] * 8)
        drive.at(0.1 * k, IMU=message)
    assert drive.felt == []
    assert drive.notes == [
        "/imu/data: unmeasured: force or yaw rate, as its covariance of -1 says; its messages are not used"
    ]


def test_a_reference_without_a_yaw_rate_gives_its_force_all_the_same() -> None:
    message = convert.imu_to_ros(Imu(0.0, 1.0, 2.0, 0.0), 0)
    message.angular_velocity_covariance = [-1.0] + [0.0] * 8
    assert convert.imu_from_ros(message, turns=False) == Imu(0.0, 1.0, 2.0, 0.0)


def test_what_is_assumed_is_a_note_of_the_run_and_spoils_no_verdict() -> None:
    from pytest_dvp.logs.log_contents import LogEvent

    class Recorder:
        def __init__(self) -> None:
            self.events: list[LogEvent] = []

        def event(self, *what: Any) -> None:
            self.events.append(LogEvent(*what))

    log, recorder = WireLog(), Recorder()
    log.record(Trouble(0.1, "/gnss/fix", "assumed: an accuracy", 1.0))
    log.drain(recorder)  # type: ignore[arg-type]
    told: Any = recorder
    assert wire_notes(told) == ("/gnss/fix: assumed: an accuracy",)
    assert wire_verdict(told) is None
