"""ROS 1: a real roscore, every message to a node of genpy's own and back, and the surrogate driven over it.

rospy is Debian's (`apt-get install ros-core python3-rospy`), used through a bridge: under the system's Python, under
this one with a path to it, and under older ones that are here.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
import xmlrpc.client
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("cyclonedds")

sys.path.insert(0, str(Path(__file__).parents[1] / "unit" / "wire"))
from test_cdr import MESSAGES
from test_fastdds import FIELDS

from pytest_dvp.drive.result import RunResult
from pytest_dvp.drive.run import run
from tests.unit.harness.conftest import OneTrick, coast
from tests.unit.harness.conftest import scenario as scenario
from tests.unit.harness.test_loop import WITH_TARGET
from vehicle.adapter import VehicleLost
from vehicle.adapters.process import CarProcess, surrogate
from vehicle.adapters.ros1 import by_ros1, settings_of
from vehicle.messages import Command, Observation, VehicleState, no_surroundings
from vehicle.wire import topics
from vehicle.wire.end import End
from vehicle.wire.ros1 import on_ros1, read_settings
from vehicle.wire.ros1_messages import kind_of
from vehicle.wire.topics import Topic

Write = Callable[..., Path]

PYTHON, PACKAGES = "/usr/bin/python3", "/usr/lib/python3/dist-packages"
PATIENCE = 60.0  # s for two nodes to find each other on a busy machine
SENT = [topic for topic in MESSAGES if topic != topics.STEP]
START = VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=5.0)


@pytest.fixture(scope="session")
def master(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A roscore's address; its log and those of the nodes go into a folder of the test."""
    if not os.environ.get("DVP_INTEROP"):
        pytest.skip("starts a roscore: make interop")
    if shutil.which("rosmaster") is None or not Path(PACKAGES, "rospy").is_dir():
        pytest.skip("needs ROS 1: apt-get install ros-core python3-rospy (make interop)")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    address, logs = f"http://127.0.0.1:{port}", tmp_path_factory.mktemp("roslog")
    os.environ["ROS_LOG_DIR"] = str(logs)
    environment = {**os.environ, "ROS_MASTER_URI": address, "ROS_IP": "127.0.0.1"}
    with (logs / "said.txt").open("w") as said:
        process = subprocess.Popen(["rosmaster", "--core", "-p", str(port)], env=environment, stdout=said, stderr=said)
    try:
        deadline = time.monotonic() + PATIENCE
        while not answers(address):
            assert process.poll() is None, (logs / "said.txt").read_text()
            assert time.monotonic() < deadline, "no roscore"
        yield address
    finally:
        process.terminate()
        process.wait(10)


def answers(address: str) -> bool:
    try:
        with xmlrpc.client.ServerProxy(address) as master:
            return bool(master.getPid("/test")[0] == 1)
    except OSError:
        return False


def nodes(address: str) -> set[str]:
    """Who publishes or subscribes."""
    with xmlrpc.client.ServerProxy(address) as master:
        _, _, (publishers, subscribers, _) = master.getSystemState("/test")
    return {name for _, names in (*publishers, *subscribers) for name in names}


def settings_file(folder: Path, address: str, **more: object) -> Path:
    lines = [f"{key} = {json.dumps(value)}" for key, value in {"master": address, **more}.items()]
    (folder / "ros1.toml").write_text("\n".join(lines) + "\n")
    return folder / "ros1.toml"


def interpreters() -> list[dict[str, object]]:
    """Ways to reach rospy: the system's Python, this one with a path, older ones with a path."""
    old = [str(each) for each in sorted(Path.home().glob(".pyenv/versions/3.[68].*/bin/python"))]
    found = [each for name in ("python3.6", "python3.8") if (each := shutil.which(name)) and "shims" not in each]
    return [{"python": PYTHON}, {"path": [PACKAGES]}, *({"python": each, "path": [PACKAGES]} for each in found or old)]


@pytest.fixture
def reached(master: str, tmp_path: Path) -> Path:
    return settings_file(tmp_path, master, python=PYTHON)


@pytest.fixture(scope="session")
def answered(master: str, tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[Topic, Any], dict[str, str]]:
    """What came back on each topic, and what the peer printed."""
    folder = tmp_path_factory.mktemp("peer")
    about = [(topic.name, kind_of(topic).name, kind_of(topic).text) for topic in MESSAGES]
    (folder / "topics.json").write_text(json.dumps(about))
    back = {topic: Topic("/echo" + topic.name, topic.type) for topic in MESSAGES}
    with (folder / "said.txt").open("w+") as said:
        command = [PYTHON, str(Path(__file__).with_name("ros1_peer.py")), master, str(folder / "topics.json")]
        peer = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=said)

        def alive() -> None:
            assert peer.poll() is None, f"the peer ended with {peer.returncode}"

        opener = on_ros1(read_settings(settings_file(folder, master, python=PYTHON)), "test")
        end = End(opener, SENT, [back[topic] for topic in SENT], (topics.STEP, back[topics.STEP]), alive)
        try:
            deadline = time.monotonic() + PATIENCE
            while not end.matched():
                alive()
                assert time.monotonic() < deadline, "the peer was not found"
            for topic in SENT:
                end.send(topic, MESSAGES[topic])
            end.step(7, 12_340_000_000)  # comes back with how much was sent: all of it must be here then
            assert end.next_step(PATIENCE) == (7, 12_340_000_000)
            came = {topic: end.take(back[topic]) for topic in SENT}
        finally:
            end.close()
            assert peer.stdin is not None
            peer.stdin.close()
            peer.wait(10)
        said.seek(0)
        parts = said.read().split("== ")[1:]
    return came, {part.split("\n", 1)[0]: part.split("\n", 1)[1] for part in parts}


@pytest.mark.parametrize("topic", [t for t in SENT if t != topics.OBJECTS], ids=lambda topic: topic.name)
def test_a_message_comes_back_as_it_was_sent(topic: Topic, answered: tuple[dict[Topic, Any], dict[str, str]]) -> None:
    (back,) = answered[0][topic]
    assert back.serialize() == MESSAGES[topic].serialize()


def test_objects_come_back_but_for_their_names(answered: tuple[dict[Topic, Any], dict[str, str]]) -> None:
    (back,) = answered[0][topics.OBJECTS]
    sent = MESSAGES[topics.OBJECTS]
    assert [each.bbox for each in back.detections] == [each.bbox for each in sent.detections]
    assert [each.id for each in back.detections] == ["0", "1"]


@pytest.mark.parametrize("topic", [t for t in FIELDS if t != topics.CLOCK], ids=lambda topic: topic.name)
def test_the_peer_understood_its_fields(topic: Topic, answered: tuple[dict[Topic, Any], dict[str, str]]) -> None:
    printed = answered[1][topic.name].replace('"', "").replace("\\t", "\t")
    for field in FIELDS[topic]:
        assert field in printed


def drive(car: CarProcess) -> bytes:
    """The motion of two seconds, steering a little."""
    rows = []
    car.reset(START)
    for tick in range(40):
        car.observe(no_surroundings())
        car.apply(Command(0.05 * tick, 0.05, 1.0, 0.0, 0.0))
        rows.append(car.step(0.05))
    return np.concatenate(rows).tobytes()


def test_over_ros_1_and_over_dds_it_is_the_same_car_byte_for_byte(master: str, tmp_path: Path) -> None:
    """Whatever interpreter rospy lives under."""
    over_dds = surrogate(7)
    expected = drive(over_dds)
    over_dds.close()
    for how in interpreters():
        settings, _ = settings_of(settings_file(tmp_path, master, **how))
        car = surrogate(7, **by_ros1(settings))
        try:
            assert drive(car) == expected, how
            assert drive(car) == expected, how  # and again
        finally:
            car.close()
    assert {name for name in nodes(master) if "dvp" in name} == set()


@pytest.mark.parametrize("stage", ["pe", "rw"])
def test_a_run_over_ros_1_is_the_same_bytes_again(scenario: Write, reached: Path, stage: str) -> None:
    where = {"stage": stage, "vehicle": f"ros1:{reached}", "duration": 2.0, "ads": OneTrick(coast)}
    first, second = (run(scenario(*WITH_TARGET), **where) for _ in range(2))  # type: ignore[arg-type]
    assert first.error is second.error is None
    assert first.stage == f"{stage}-surrogate"
    assert first.log.meta["vehicle"]["wire"] == "ros1"
    for name, column in first.log.columns.items():
        np.testing.assert_array_equal(column, second.log.columns[name], err_msg=name)


def test_by_the_wall_clock_it_drives_too(scenario: Write, reached: Path) -> None:
    result = run(scenario(), stage="pe", vehicle=f"ros1:{reached}", clock="real", duration=1.0, ads=OneTrick(coast))
    assert result.error is None
    assert result.log.meta["timing"]["commands"] >= 50


def test_a_fault_on_the_wire_is_named_there_too(scenario: Write, reached: Path) -> None:
    where = {"stage": "rw", "vehicle": f"ros1:{reached}", "duration": 2.0, "ads": OneTrick(coast)}
    result = run(scenario(*WITH_TARGET), fault="duplicate@1+0.5", **where)  # type: ignore[arg-type]
    named = {(event.text.split(" ")[0], event.element) for event in result.log.events if event.kind == "wire"}
    assert ("repeated", "/vehicle/odom") in named
    assert result.status != "PASS"


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP])
def test_a_bridge_that_dies_or_is_stopped_ends_the_run_and_leaves_nothing(
    scenario: Write, reached: Path, how: signal.Signals
) -> None:
    struck: list[int] = []

    def strike(observation: Observation) -> Command:
        if observation.t >= 0.5 and not struck:
            struck.extend(bridges(os.getpid()))
            os.kill(struck[0], how)
        return coast(observation)

    where = {"stage": "rw", "vehicle": f"ros1:{reached}", "duration": 2.0}
    result = run(scenario(), ads=OneTrick(strike), **where)  # type: ignore[arg-type]
    assert result.status == "ERROR"
    assert "the bridge to ROS 1's process" in (result.error or "")
    assert result.log.duration == pytest.approx(0.5, abs=0.11)
    assert not any(Path(f"/proc/{pid}").exists() for pid in struck)
    assert run(scenario(), ads=OneTrick(coast), **where).error is None  # type: ignore[arg-type]


def bridges(parent: int) -> list[int]:
    """Children of a process that are bridges."""
    found = Path(f"/proc/{parent}/task/{parent}/children").read_text().split()
    return [int(pid) for pid in found if "bridge_server" in Path(f"/proc/{pid}/cmdline").read_text()]


def test_without_a_roscore_or_without_rospy_it_is_one_line(master: str, tmp_path: Path) -> None:
    settings, _ = settings_of(settings_file(tmp_path, "http://127.0.0.1:1", python=PYTHON))
    with pytest.raises(VehicleLost, match=r"^the bridge to ROS 1: no roscore answers at http://127\.0\.0\.1:1 \("):
        surrogate(**by_ros1(settings))


@pytest.fixture
def tabby(master: str, tmp_path: Path) -> Iterator[Path]:
    """A car of its own on ROS 1, with a driver, in namespace /tabby: its settings."""
    file = settings_file(tmp_path, master, python=PYTHON, namespace="/tabby")
    words = ["--ros1", "", "--ros1-file", str(file), "--clock", "real", "--driver", "--at", "10", "-1.75", "0"]
    car = subprocess.Popen([sys.executable, "-m", "vehicle.surrogate", *words], stdin=subprocess.PIPE)
    try:
        yield file
    finally:
        assert car.stdin is not None
        car.stdin.close()
        car.kill()
        car.wait()


def creep(observation: Observation) -> Command:
    """A little more than nothing, straight on."""
    return Command(observation.t, 0.0, 0.3, 0.1, 0.0)


def on_tabby(path: Path, file: Path, **keys: Path) -> RunResult:
    return run(path, stage="pe", vehicle=f"ros1_car:{file}", duration=1.0, ads=OneTrick(creep), **keys)  # type: ignore[arg-type]


def test_a_real_car_is_driven_dry_without_keys_and_armed_with_both(scenario: Write, tabby: Path) -> None:
    path = scenario(('AbsoluteTargetSpeed value="$ego_speed"', 'AbsoluteTargetSpeed value="0"'))
    path.with_name(f"{path.stem}.gates.toml").write_text('[[gate]]\nmetric = "collision"\nmax = 0\n')
    dry = on_tabby(path, tabby)
    assert (dry.error, dry.status, dry.stage) == (None, "INCONCLUSIVE", "pe")
    assert dry.log.columns["v"][-1] == pytest.approx(0.0, abs=0.02)
    arming, envelope = path.with_name("arming.toml"), path.with_name("envelope.toml")
    arming.write_text(f'vehicle = "ros1_car"\nscenario = "{path.name}"\n')
    envelope.write_text("area = [[-50, -50], [1050, -50], [1050, 50], [-50, 50]]\nmax_speed = 8.0\n")
    armed = on_tabby(path, tabby, arming=arming, envelope=envelope)
    assert (armed.error, armed.stage) == (None, "pe")
    late = any(event.kind == "wire" for event in armed.log.events)  # of a busy machine: named, and no PASS
    assert armed.status == ("INCONCLUSIVE" if late else "PASS")
    assert armed.log.columns["v"][-1] > 0.1
    assert armed.log.meta["timing"]["commands"] >= 50
