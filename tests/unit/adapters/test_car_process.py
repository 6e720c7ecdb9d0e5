"""The surrogate over DDS as a process: same bytes on repeat, one line when it is lost, nothing left behind."""

from __future__ import annotations

import hashlib
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("cyclonedds")

from tests.waiting import is_gone, wait_until
from vehicle import child_process
from vehicle.adapter import Vehicle, VehicleLost
from vehicle.adapters.process import CarProcess, Lease, surrogate
from vehicle.messages import Command, Surroundings, VehicleState
from vehicle.wire import topics
from vehicle.wire.faults import parse_fault
from vehicle.wire.health import Trouble

SEDAN = Path(__file__).parents[2] / "data" / "can" / "sedan.dbc"
START = VehicleState(t=0.0, x=10.0, y=5.0, yaw=0.3, v=3.0)
BOXES = np.array([[25.0, 9.0, 0.75, 0.3, 4.0, 1.8, 1.5, 0.0, 0.0]])
AROUND = Surroundings(BOXES, np.zeros(1, dtype=np.int64), ("Target",))


@pytest.fixture(scope="module")
def car() -> Iterator[CarProcess]:
    car = surrogate(seed=7)
    yield car
    car.close()


def drive(car: Vehicle, ticks: int = 40) -> str:
    """A digest of every observation and every row of motion of a short drive."""
    digest = hashlib.sha256()
    car.reset(START)
    for k in range(ticks):
        seen = car.observe(AROUND)
        for part in (seen.gnss, seen.odometry, seen.imu, seen.camera):
            digest.update(repr(part).encode())
        if seen.lidar is not None:
            digest.update(seen.lidar.points.tobytes())
        car.apply(Command(t=0.05 * k, steer=0.05, accel=1.0, throttle=0.0, brake=0.0))
        digest.update(car.step(0.05).tobytes())
    return digest.hexdigest()


def test_stepped_time_gives_the_same_bytes_again_and_in_another_process(car: CarProcess) -> None:
    first = drive(car)
    assert drive(car) == first
    other = surrogate(seed=7)
    try:
        assert drive(other) == first
    finally:
        other.close()


def test_a_car_that_never_says_its_speed_is_named_and_one_without_a_heading_is_not() -> None:
    """Nothing on two topics from the first moment on; feedback must come, a heading is the car's own affair."""
    for topic, said in ((topics.FEEDBACK.name, ["silent"]), (topics.HEADING.name, [])):
        troubles: list[Trouble] = []
        other = surrogate(seed=7, fault=parse_fault(f"silence:{topic}@0+60"), record=troubles.append)
        try:
            drive(other, 70)
        finally:
            other.close()
        assert [trouble.what for trouble in troubles if trouble.topic == topic] == said


@pytest.mark.nightly
@pytest.mark.parametrize("dbc", [SEDAN, None])
def test_over_can_stepped_time_gives_the_same_bytes_again(dbc: Path | None) -> None:
    pytest.importorskip("cantools")
    from vehicle.wire.can_map import find_map

    digests = set()
    for _ in range(2 if dbc is None else 1):
        other = surrogate(seed=7, can=find_map(dbc))
        try:
            digests |= {drive(other, 12), drive(other, 12)}
        finally:
            other.close()
    assert len(digests) == 1


def test_over_can_a_car_that_is_stopped_is_sent_full_braking_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """No step follows: a harness that stops a car has no more to do with it. The wheel stays where it is."""
    pytest.importorskip("cantools")
    from vehicle.wire.can_codec import Codec, Frame
    from vehicle.wire.can_map import find_map

    car = surrogate(seed=7, can=find_map())
    try:
        drive(car, 4)
        frames: list[Frame] = []
        assert car.by_wire is not None
        monkeypatch.setattr(car.by_wire._link, "send", frames.append)
        car.stop()
    finally:
        car.close()
    reader = Codec(find_map(), sends="report")
    said = {key: value for frame in frames for key, value in reader.read(frame).values.items()}
    assert (said["brake"], said["throttle"]) == (1.0, 0.0)
    assert said["steer"] == pytest.approx(0.05, abs=0.02)


def test_it_obeys_and_says_where_it_is(car: CarProcess) -> None:
    """1 m/s^2 for 2 s from 3 m/s, less 0.108 m/s^2 of rolling and the motor's lag of some 20 ms."""
    car.reset(START)
    rows = []
    for k in range(40):
        car.apply(Command(t=0.05 * k, steer=0.0, accel=1.0, throttle=0.0, brake=0.0))
        rows.append(car.step(0.05))
    motion = np.concatenate(rows)
    assert np.diff(motion[:, 0]) == pytest.approx(0.01)
    assert motion[-1, 0] == pytest.approx(1.98)  # its reference system is 20 ms late
    assert motion[-1, 5] == pytest.approx(3.0 + 1.98 * (1.0 - 0.108), abs=0.15)
    assert motion[:, 4] == pytest.approx(0.3, abs=0.008)  # its heading is known to 0.1 deg, 1 sigma


def test_a_brake_arrives_as_deceleration_though_the_message_has_no_pedals(car: CarProcess) -> None:
    """Half of 7 m/s^2 and 0.108 of rolling, from 3 m/s: it stands after 0.9 s, but for its springs."""
    car.reset(START)
    for k in range(20):
        car.apply(Command(t=0.05 * k, steer=0.0, accel=2.0, throttle=1.0, brake=0.5))
        rows = car.step(0.05)
    assert rows[-1, 5] == pytest.approx(0.0, abs=0.2)


def test_its_lidar_meets_the_box_it_was_sent(car: CarProcess) -> None:
    """Standing at (10, 5) with yaw 0.3, the rear of the box is 2 m before its centre, 15.5 m away."""
    car.reset(VehicleState(t=0.0, x=10.0, y=5.0, yaw=0.3, v=0.0))
    car.observe(AROUND)
    car.apply(Command(t=0.0, steer=0.0, accel=-3.0, throttle=0.0, brake=0.0))
    car.step(0.05)
    scan = car.observe(AROUND).lidar
    assert scan is not None
    along = 15.0 * np.cos(0.3) + 4.0 * np.sin(0.3) - car.description.lidar_x
    assert scan.points[:, 0].min() == pytest.approx(along - 2.0, abs=0.1)


@pytest.mark.nightly
def test_a_killed_car_is_one_line_and_leaves_nothing() -> None:
    car = surrogate()
    car.reset(START)
    os.kill(car.process.pid, signal.SIGKILL)
    with pytest.raises(VehicleLost, match=r"^the car's process ended \(killed by SIGKILL\)$"):
        car.step(0.05)
    car.stop()
    car.close()
    car.close()
    with pytest.raises(ProcessLookupError):
        os.killpg(car.process.pid, 0)


def test_a_stopped_car_is_found_out_at_once() -> None:
    car = surrogate(timeout=60.0)
    car.reset(START)
    os.kill(car.process.pid, signal.SIGSTOP)
    with pytest.raises(VehicleLost, match=r"^the car's process is stopped \(SIGSTOP\)$"):
        car.step(0.05)
    car.close()
    assert car.process.returncode == -signal.SIGKILL


@pytest.mark.nightly
def test_a_car_that_hangs_is_given_up_after_the_declared_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(child_process, "is_stopped", lambda pid: False)  # to the harness it only says nothing
    car = surrogate(timeout=0.3)
    car.reset(START)
    os.kill(car.process.pid, signal.SIGSTOP)
    with pytest.raises(VehicleLost, match=r"^the car did not answer within 0\.3 s at t = 0\.05 s$"):
        car.step(0.05)
    car.close()
    assert car.process.returncode == -signal.SIGKILL


def test_a_car_that_cannot_start_says_why(tmp_path: Path) -> None:
    hidden = tmp_path / "hidden.toml"
    hidden.write_text("[hidden.steer_dellay]\nT = 0.2\n")
    with pytest.raises(VehicleLost, match=r"exit code 2\): .*hidden\.toml.*did you mean steer_delay\?"):
        surrogate(hidden=hidden)


@pytest.mark.parametrize("stopped", [False, pytest.param(True, marks=pytest.mark.nightly)], ids=["running", "stopped"])
def test_a_car_ends_with_the_process_that_started_it(stopped: bool) -> None:
    """However both are: a harness that is killed, and a car that is stopped and hears of nothing."""
    started = "from vehicle.adapters.process import surrogate; import os; c = surrogate(); print(c.process.pid)\n"
    stop = "os.kill(c.process.pid, 19)\nwhile True:\n    try: c.step(0.05)\n    except ValueError: break\n"
    parent = subprocess.run(
        [sys.executable, "-c", started + stop * stopped + "import sys; sys.stdout.flush(); os.kill(os.getpid(), 9)"],
        stdout=subprocess.PIPE, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert parent.returncode == -signal.SIGKILL
    pid = int(parent.stdout)
    try:
        wait_until(lambda: is_gone(pid), f"process {pid} is still there")
    finally:
        if not is_gone(pid):
            os.kill(pid, signal.SIGKILL)


def test_two_runs_never_share_a_domain() -> None:
    first, second = Lease(), Lease()
    assert first.domain != second.domain
    first.release()
    third = Lease()
    assert third.domain != second.domain
    second.release()
    third.release()


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("how", "says"),
    [
        ("asleep", r"^the car's process hangs: it is asleep, and has not woken up in \d+ looks$"),
        ("works", r"^the car's process hangs: it has worked for \d\.\d s of processor time on one answer$"),
    ],
)
def test_a_car_that_hangs_is_found_out_long_before_its_time_is_over(how: str, says: str) -> None:
    car = CarProcess("tests.unit.adapters.hanging_car", [how], timeout=600.0)
    try:
        car.reset(START)
        car.step(0.05)
        with pytest.raises(VehicleLost, match=says):
            car.step(0.05)  # the third step
    finally:
        car.close()
    assert car.process.returncode is not None
