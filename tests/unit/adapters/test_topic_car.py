"""A real car on topics: driven only from where it stands, and only while its driver's hands are known to be off.

The car is the surrogate with a driver at rest, in a process of its own, on DDS as CYCLONEDDS_URI configures it.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("cyclonedds")

from tests.unit.adapters.test_words_before_a_reset import HandEnd
from vehicle.adapter import Hands, VehicleLost
from vehicle.adapters import topic_car
from vehicle.adapters.process import Lease
from vehicle.adapters.topic_car import Ros1Car, Ros2Car
from vehicle.guard.guarded_vehicle import GuardedVehicle, limits_of
from vehicle.guard.messages import Decision, State
from vehicle.messages import Command, GnssFix, Odometry, VehicleState, no_surroundings
from vehicle.wire import convert, topics
from vehicle.wire.dds import LOOPBACK
from vehicle.wire.geodetic import Origin

START = VehicleState(t=0.0, x=30.0, y=5.0, yaw=0.3, v=0.0)


@pytest.fixture(scope="module")
def car() -> Iterator[tuple[Ros2Car, subprocess.Popen[bytes]]]:
    """The harness's side, and the process of the car."""
    lease, before = Lease(), os.environ.get("CYCLONEDDS_URI")
    os.environ["CYCLONEDDS_URI"] = f"<CycloneDDS><Domain>{LOOPBACK}</Domain></CycloneDDS>"
    words = ["--dds", str(lease.domain), "--clock", "real", "--driver", "--at", "30", "5", "0.3"]
    process = subprocess.Popen([sys.executable, "-m", "vehicle.surrogate", *words], stdin=subprocess.PIPE)
    try:
        car = Ros2Car(str(lease.domain))
        yield car, process
        car.close()
    finally:
        assert process.stdin is not None
        process.stdin.close()
        process.kill()
        process.wait()
        lease.release()
        os.environ.pop("CYCLONEDDS_URI")
        if before is not None:
            os.environ["CYCLONEDDS_URI"] = before


@pytest.mark.nightly
def test_it_is_real_and_its_driver_has_it_until_hands_are_heard_of(car: tuple[Ros2Car, object]) -> None:
    assert car[0].is_real
    car[0].reset(START)
    assert car[0].hands == Hands(False, False)


@pytest.mark.parametrize(
    ("place", "says"),
    [
        (
            (20.0, 5.0, 0.3),
            r"^the car is 10\.0 m from where the scenario places the ego \(x=20\.0, y=5\.0, yaw=0\.30 rad\)",
        ),
        ((30.0, 5.0, -0.2), r"turned by 29 deg; allowed are 2 m and 20 deg$"),
    ],
)
def test_a_car_that_stands_elsewhere_is_not_driven(
    car: tuple[Ros2Car, object], place: tuple[float, float, float], says: str
) -> None:
    x, y, yaw = place
    with pytest.raises(VehicleLost, match=says):
        car[0].reset(VehicleState(t=0.0, x=x, y=y, yaw=yaw, v=0.0))


def test_it_is_reset_with_the_steering_angle_that_it_reports(
    car: tuple[Ros2Car, object], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The scenario knows of none. A car that reports none is not driven."""
    answers = {
        topics.ODOMETRY: [convert.state_to_ros(START, 10**9)],
        topics.FEEDBACK: [convert.feedback_to_ros(Odometry(1.0, 0.0, 0.21), 10**9)],
    }
    take = car[0]._wire().take
    monkeypatch.setattr(car[0]._wire(), "take", lambda topic: answers.get(topic, take(topic)))
    car[0].reset(START)
    assert car[0]._state.steer == pytest.approx(0.21)
    answers[topics.FEEDBACK] = []
    with pytest.raises(VehicleLost, match=r"^the car does not say how it steers: nothing on /vehicle/feedback$"):
        car[0].reset(START)


def test_behind_the_gate_it_stays_where_it_is_until_it_is_armed(car: tuple[Ros2Car, object]) -> None:
    """A dry run: half a second of full acceleration asked for, none given; how punctual it was is known."""
    decisions: list[Decision] = []
    gated = GuardedVehicle(
        car[0], limits_of(car[0].description), name="ros2_car", scenario="x.xosc", record=decisions.append
    )
    gated.reset(START)
    rows = []
    for tick in range(10):
        gated.observe(no_surroundings())
        gated.apply(Command(0.05 * tick, 0.0, 2.0, 1.0, 0.0))
        rows.append(gated.step(0.05))
    motion = np.concatenate(rows)
    assert len(motion) >= 30
    assert motion[:, 1] == pytest.approx(30.0, abs=0.06)  # its reference system is off by 15 mm, 1 sigma
    assert motion[:, 2] == pytest.approx(5.0, abs=0.06)
    assert np.ptp(motion[:, 1:3], axis=0).max() < 0.02  # and scatters by 2 mm
    assert {decision.state for decision in decisions} == {State.DRY}
    assert car[0].hands == Hands(False, False)


def test_a_car_whose_hands_fall_silent_is_its_drivers(
    car: tuple[Ros2Car, object], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing new for STALE = 0.2 s: whoever has the wheel, it is not the stack."""
    car[0].reset(START)
    assert car[0].hands == Hands(False, False)
    monkeypatch.setattr(car[0]._wire(), "take", lambda topic: [])
    monkeypatch.setattr(car[0], "_clock", lambda: 0.19)
    assert car[0].hands == Hands(False, False)
    monkeypatch.setattr(car[0], "_clock", lambda: 0.2)
    assert car[0].hands == Hands(True, False)


def test_a_car_that_is_stopped_is_lost_within_what_it_may_be_silent(
    car: tuple[Ros2Car, subprocess.Popen[bytes]],
) -> None:
    live, process = car
    live.reset(START)
    live.observe(no_surroundings())
    live.step(0.05)
    process.send_signal(signal.SIGSTOP)

    def go_on() -> None:
        for _ in range(100):
            live.step(0.02)

    with pytest.raises(VehicleLost, match=r"^the car has been silent for 0\.\d+ s"):
        go_on()
    live.stop()  # nobody is asked anything any more


def test_a_domain_or_a_file_that_is_none_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(VehicleLost, match=r"^vehicle ros2_car:seven: expected a DDS domain, 0 to 232, as ros2_car:7$"):
        Ros2Car("seven")
    with pytest.raises(VehicleLost, match=r"^vehicle ros1_car:no\.toml: no\.toml: No such file or directory$"):
        Ros1Car("no.toml")


def test_who_waits_for_a_car_that_does_not_come_learns_where_it_was_looked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    lease, network = Lease(), f"<CycloneDDS><Domain>{LOOPBACK}</Domain></CycloneDDS>"
    monkeypatch.setenv("CYCLONEDDS_URI", network)
    with pytest.raises(VehicleLost, match=r"^no car answered on the wire within 0\.1 s; expected a node that") as lost:
        Ros2Car(str(lease.domain), ready=0.1)
    lease.release()
    for named in ("/vehicle/description", f"on DDS domain {lease.domain} (", network):
        assert named in str(lost.value)
    assert Ros1Car.waits_for("car.toml").endswith("at the ROS master that car.toml names")


def test_an_interpreter_without_rospy_is_one_line(tmp_path: Path) -> None:
    """A virtual environment does not see the system's packages."""
    (tmp_path / "ros1.toml").write_text("")
    with pytest.raises(VehicleLost, match=r"^the bridge to ROS 1: \S+ lacks a module: No module named 'rospy'$"):
        Ros1Car(str(tmp_path / "ros1.toml"))


@pytest.mark.nightly
def test_a_surrogate_that_cannot_open_its_wire_ends_with_one_line(tmp_path: Path) -> None:
    """While it still listens to whether its parent lives."""
    (tmp_path / "ros1.toml").write_text('python = "/no/python"\n')
    words = ["--ros1", "/x", "--ros1-file", str(tmp_path / "ros1.toml")]
    with subprocess.Popen(
        [sys.executable, "-m", "vehicle.surrogate", *words], stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stderr is not None
        assert process.stderr.read() == (
            "the bridge to ROS 1's process cannot be started: /no/python: No such file or directory\n"
        )
    assert process.returncode == 2


@pytest.fixture
def located(monkeypatch: pytest.MonkeyPatch) -> Callable[..., topic_car.TopicCar]:
    """A car on no wire, with what its file says of the map."""
    monkeypatch.setattr(topic_car, "LiveEnd", HandEnd)
    return lambda **said: topic_car.TopicCar(lambda *_: None, "here", **said)  # type: ignore[arg-type,return-value]


MUNICH = Origin(48.137, 11.575, None, 500.0, -200.0)


@pytest.mark.parametrize("stated", [True, False])
def test_fixes_are_those_of_the_map_that_is_stated_or_else_of_its_road_file(
    located: Callable[..., topic_car.TopicCar], stated: bool
) -> None:
    car = located(origin=MUNICH) if stated else located()
    car.locate_map(Origin(0.0, 0.0) if stated else MUNICH, "")
    place, _ = convert.fix_to_ros(GnssFix(0.0, 0.0, 0.0, 0.02), 0)
    place.latitude, place.longitude, place.altitude = 48.137, 11.575, 560.0
    fix = car._fix(place)
    assert isinstance(fix, GnssFix)
    assert (fix.x, fix.y) == pytest.approx((500.0, -200.0), abs=1e-6)


def test_a_map_that_says_nothing_lies_where_it_always_did(located: Callable[..., topic_car.TopicCar]) -> None:
    car = located()
    car.locate_map(None, "")
    fix = car._fix(convert.fix_to_ros(GnssFix(0.0, 3.0, 4.0, 0.02), 0)[0])
    assert isinstance(fix, GnssFix)
    assert (fix.x, fix.y) == pytest.approx((3.0, 4.0), abs=1e-6)


def test_a_map_whose_place_cannot_be_read_must_be_stated(located: Callable[..., topic_car.TopicCar]) -> None:
    located(origin=MUNICH).locate_map(None, "it needs pyproj")
    says = r"^it needs pyproj; or state it in the car's file: origin = \{ latitude = 48.137, longitude = 11.575 \}$"
    with pytest.raises(VehicleLost, match=says):
        located().locate_map(None, "it needs pyproj")


def test_a_file_says_domain_and_origin(tmp_path: Path) -> None:
    file = tmp_path / "car.toml"
    file.write_text("domain = 7\norigin = { latitude = 48.137, longitude = 11.575, x = 500, y = -200 }\n")
    assert topic_car._domain(str(file)) == (7, MUNICH)
    assert "on DDS domain 7 " in Ros2Car.waits_for(str(file))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("domain = 233", "domain: found 233, allowed: a DDS domain, 0 to 232"),
        ("domain = true", "domain: found True, allowed: a DDS domain, 0 to 232"),
        ("[origin]\nlatitude = 9\nlongitude = 1", "domain: it is missing, allowed: a DDS domain, 0 to 232"),
        ("domains = 7", "domains is unknown, allowed: domain, origin"),
        ("domain = 7\norigin = 3",
         "origin: found 3, allowed: a table with latitude and longitude, and height, x, y, turn"),
        ("domain = 7\n[origin]\nlatitude = 91\nlongitude = 1",
         "origin: latitude: found 91, allowed: -90 to 90"),
        ("domain = 7\n[origin]\nlatitude = 9\nlongitude = nan",
         "origin: longitude: found nan, allowed: -180 to 180"),
        ("domain = 7\n[origin]\nlatitude = 9\nlongitude = 1\nheigth = 2",
         "origin: heigth is unknown, allowed: latitude, longitude, height, x, y, turn"),
    ],
)  # fmt: skip
def test_a_file_that_says_something_else_is_one_line(tmp_path: Path, text: str, says: str) -> None:
    file = tmp_path / "car.toml"
    file.write_text(text)
    with pytest.raises(VehicleLost) as lost:
        Ros2Car(str(file))
    assert str(lost.value) == f"vehicle ros2_car:{file}: {says}"


def test_the_file_of_a_ros1_car_says_it_too(tmp_path: Path) -> None:
    file = tmp_path / "car.toml"
    file.write_text("origin = { latitude = 48.137 }\n")
    with pytest.raises(VehicleLost, match=r"car\.toml: origin: found \{'latitude': 48\.137\}, allowed: a table with"):
        Ros1Car(str(file))
