"""`--ads ros2:stack.toml`: a stack in a process of its own, reset for each run, an ERROR when it is lost."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

pytest.importorskip("cyclonedds")

from ads.parameters import preset
from openscenario.road.network import load_network
from pytest_dvp.drive.remote_stack import RemoteStack
from pytest_dvp.drive.run import run
from pytest_dvp.drive.stack_faults import AdsError
from pytest_dvp.text.errors import SettingError
from tests.unit.adapters.test_recorded_vehicle import CAR
from vehicle.messages import GnssFix, Observation, Odometry, Task
from vehicle.wire.geodetic import Origin

Write = Callable[..., Path]
REFERENCE = Path(__file__).parents[2] / "data" / "stacks" / "reference.toml"
RESETS = 20


@pytest.fixture(scope="module")
def stack() -> Iterator[RemoteStack]:
    with RemoteStack(REFERENCE) as stack:
        yield stack


def along_a_road() -> list[Observation]:
    """What a car sees that drives straight on at 10 m/s, 12 ticks of 0.05 s."""
    return [
        Observation(
            0.05 * k,
            gnss=(GnssFix(0.05 * k, 20.0 + 0.5 * k, -1.2, 0.02, 0.0, 0.005),),
            odometry=(Odometry(0.05 * k, 10.0, 0.0),),
            task=Task(set_speed=15.0) if k == 0 else None,
        )
        for k in range(12)
    ]


@pytest.mark.nightly
def test_twenty_resets_give_the_same_commands_from_one_process(scenario: Write, stack: RemoteStack) -> None:
    """Without a reset the second drive would go on from where the first one ended."""
    network = load_network(scenario().parent / "straight.xodr")
    seen = along_a_road()
    drives, pids = [], set()
    for _ in range(1 + RESETS):
        driver = stack(preset(), network, CAR)
        drives.append([driver.tick(one) for one in seen])
        pids.add(stack.wire().pid)
    assert all(drive == drives[0] for drive in drives)
    assert len(pids) == 1
    assert drives[0][-1].accel > 0.1


def test_it_drives_as_the_same_stack_in_this_process_does(scenario: Write, stack: RemoteStack) -> None:
    """What differs is float32 on the wire, and pedals that the harness adds: millimetres within 2 s."""
    path = scenario()
    here, there = run(path, duration=2.0).log, run(path, duration=2.0, ads=stack).log
    assert there["x"][-1] == pytest.approx(here["x"][-1], abs=0.02)
    assert there["ads.x"][-1] == pytest.approx(here["ads.x"][-1], abs=0.02)
    assert there["steer_cmd"] == pytest.approx(here["steer_cmd"], abs=2e-3, nan_ok=True)


@pytest.mark.nightly
def test_a_stack_that_dies_is_an_error_and_the_next_run_has_a_new_one(scenario: Write, stack: RemoteStack) -> None:
    path = scenario()
    run(path, duration=0.1, ads=stack)
    before = stack.wire().pid
    os.kill(before, signal.SIGKILL)
    lost = run(path, duration=0.3, ads=stack)
    assert (lost.status, lost.error) == ("ERROR", "the stack's process ended (killed by SIGKILL)")
    assert run(path, duration=0.1, ads=stack).error is None
    assert stack.wire().pid != before


def test_a_stack_named_on_the_command_line_ends_with_its_run(scenario: Write) -> None:
    result = run(scenario(), duration=0.2, ads=f"ros2:{REFERENCE}")
    assert result.error is None
    assert result.ads == "ros2:reference.toml"
    assert f"--ads ros2:{REFERENCE}" in result.replay or "--ads ros2:tests/data/stacks/reference.toml" in result.replay
    children = [
        path for path in Path("/proc").glob("[0-9]*/cmdline") if b"pytest_dvp.drive.stack_server" in _read(path)
    ]
    ours = [path for path in children if f"\nPPid:\t{os.getpid()}\n".encode() in _read(path.with_name("status"))]
    assert len(ours) <= 1  # the one that other tests here keep


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:
        return b""


def test_a_stack_that_cannot_start_says_why(scenario: Write, tmp_path: Path) -> None:
    file = tmp_path / "stack.toml"
    file.write_text('command = ["{python}", "-c", "raise SystemExit(\'no map server\')"]\n')
    result = run(scenario(), duration=0.2, ads=RemoteStack(file))
    assert (result.status, result.error) == ("ERROR", "the stack's process ended (exit code 1): no map server")
    file.write_text('command = ["no-such-program"]\n')
    assert run(scenario(), duration=0.2, ads=RemoteStack(file)).error == (
        "the stack's process cannot be started: no-such-program: No such file or directory"
    )


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("comand = []", r"stack\.toml: unknown key 'comand', did you mean 'command'\?"),
        ("", r"command: found None, allowed: a list of words"),
        ("command = ['x']\nanswer = 0", r"answer: found 0, allowed: seconds > 0"),
        ("command = ['x']\nstart = inf", r"start: found inf, allowed: seconds > 0, a day at most"),
        ("command = ['x'\n", r"stack\.toml:2: no stack: not TOML: Unclosed array"),
    ],
)
def test_a_wrong_file_is_one_line(tmp_path: Path, text: str, says: str) -> None:
    (tmp_path / "stack.toml").write_text(text)
    with pytest.raises(AdsError, match=says):
        RemoteStack(tmp_path / "stack.toml")


def test_a_file_that_is_not_there_is_one_line(scenario: Write) -> None:
    with pytest.raises(SettingError, match=r"no file .*nowhere\.toml; looked in "):
        run(scenario(), ads="ros2:nowhere.toml")


TMERC = "<geoReference>+proj=tmerc +lat_0=48.137 +lon_0=11.575 +k=1 +x_0=0 +y_0=0</geoReference>"


def test_a_stack_gets_latitude_and_longitude_of_the_map_and_where_that_lies(scenario: Write, tmp_path: Path) -> None:
    from types import SimpleNamespace
    from typing import Any

    from vehicle.wire import topics
    from vehicle.wire.stack_topics import send_observation, take_observation

    road = tmp_path / "there.xodr"
    text = (scenario().parent / "straight.xodr").read_text()
    begin, slash, rest = text.partition("/>") if "<header" in text.partition("/>")[0] else text.partition("</header>")
    road.write_text(f"{begin}>{TMERC}</header>{rest}" if slash == "/>" else f"{begin}{TMERC}</header>{rest}")
    network = load_network(road)
    with RemoteStack(REFERENCE) as remote:
        of_the_map = remote(preset(), network, CAR)._run["origin"]
    assert of_the_map == Origin(48.137, 11.575, None)
    file = tmp_path / "stack.toml"
    file.write_text('command = ["true"]\norigin = { latitude = -33.9, longitude = 151.2, height = 20 }\n')
    with RemoteStack(file) as remote:
        assert remote(preset(), network, CAR)._run["origin"] == Origin(-33.9, 151.2, 20.0)
    sent: dict[Any, list[Any]] = {}
    end: Any = SimpleNamespace(
        send=lambda topic, message: sent.setdefault(topic, []).append(message), take=lambda topic: sent.get(topic, [])
    )
    send_observation(end, Observation(0.0, gnss=(GnssFix(0.0, 20.0, -1.2, 0.02, 0.3, 0.005),)), of_the_map)
    assert (sent[topics.FIX][0].latitude, sent[topics.FIX][0].longitude) == pytest.approx((48.137, 11.575), abs=1e-3)
    (fix,) = take_observation(end, 0, of_the_map).gnss
    assert (fix.x, fix.y) == pytest.approx((20.0, -1.2), abs=1e-6)


def test_a_stack_on_a_map_elsewhere_drives_as_on_any(scenario: Write, stack: RemoteStack) -> None:
    """Fixes that come out elsewhere would have it brake: both ends must know where the map lies."""
    network = load_network(scenario().parent / "straight.xodr")
    seen = along_a_road()
    drives = []
    for origin in (None, Origin(48.137, 11.575, None)):
        driver = stack(preset(), network, CAR)
        driver._run["origin"] = origin or driver._run["origin"]
        drives.append([driver.tick(one).accel for one in seen])
    assert drives[1] == pytest.approx(drives[0], abs=1e-4)


@pytest.mark.parametrize("origin", ["3", "{ latitude = 1 }"])
def test_an_origin_that_is_none_is_one_line(tmp_path: Path, origin: str) -> None:
    file = tmp_path / "stack.toml"
    file.write_text(f'command = ["true"]\norigin = {origin}\n')
    with pytest.raises(AdsError, match=r"stack\.toml: \[origin\]: found .*, allowed: a table with latitude"):
        RemoteStack(file)
