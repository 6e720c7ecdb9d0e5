"""A driving stack given by name runs in a process of its own: it can hang, crash and print, and the log is the same."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from pytest_dvp.cli.command_line import main
from pytest_dvp.drive import stack_process
from pytest_dvp.drive.result import RunResult
from pytest_dvp.drive.run import run
from pytest_dvp.drive.stack_faults import AdsError
from tests.unit.harness.test_loop import WITH_TARGET

Write = Callable[..., Path]
LIMIT = 1.0  # s of wall time for a tick; a machine that is busy takes long over one that does not hang, too

STACKS = '''
import ctypes, os, random, sys, time
import numpy as np
from vehicle.messages import Command, Detection

print("loaded by", os.getpid())

class Straight:
    def tick(self, observation):
        return Command(observation.t, 0.0, 0.0, 0.0, 0.0)

class Late(Straight):
    """Misbehaves at t = 0.5 s."""
    def tick(self, observation):
        if observation.t >= 0.5:
            self.misbehave()
        return super().tick(observation)

class Loops(Late):
    """The loop is one line, so that the traceback names the same one wherever the interruption meets it."""
    def misbehave(self):
        while True: time.sleep(0.001)

class Stubborn(Late):
    def misbehave(self):
        while True:
            try:
                time.sleep(0.01)
            except Exception:
                pass

class HoldsTheLock(Late):
    def misbehave(self):
        print("so far")
        ctypes.PyDLL(None).sleep(1000)

class Crashes(Late):
    def misbehave(self):
        ctypes.string_at(0)

class Leaves(Late):
    def misbehave(self):
        print("no licence", file=sys.stderr)
        os._exit(0)

class Raises(Late):
    def misbehave(self):
        {}["key"]

class Asks(Late):
    def misbehave(self):
        input("which way? ")

class Ends(Late):
    def misbehave(self):
        sys.exit(3)

class Nothing(Straight):
    def tick(self, observation):
        return None

class SleepsAtFirst(Straight):
    def __init__(self):
        time.sleep(1000)

class HangsAtOnce(Loops):
    def tick(self, observation):
        self.misbehave()

class NeverCloses(Straight):
    def close(self):
        while True:
            time.sleep(0.001)

class HangingTrace(Straight):
    @property
    def trace(self):
        while True:
            time.sleep(0.001)

class Offers:
    """All that a stack may offer, in kinds of numbers that are no floats."""
    def __init__(self, parameters, network, description):
        self.gain, self.network, self.car = parameters["gain"], network, description
        self.detections = []
        self.paths = [np.array([[0.0, 1.0], [2.0, 3.0]]), None, [[4, 5], [6, 7]]]

    parameters = {"gain": 2, "offset": 0.5}
    nets = [{"name": "N", "places": ("a", "b")}]

    def tick(self, observation):
        k = round(20 * observation.t)
        lane = self.network.lane_pose("1", -1, 20.0)
        cloud = observation.lidar.points if observation.lidar else np.zeros((0, 3))
        cloud += 1.0
        self.detections.clear()
        self.detections.append(Detection(observation.t, "vehicle", np.float64(k), 2, 0.1, 4.0, np.float32(1.7), 0, 0))
        self.trace = {"cloud": cloud.sum(), "count": len(cloud), "y": lane.y, "wheelbase": self.car.wheelbase,
                      "yes": np.bool_(True), "set": observation.task.set_speed if observation.task else -1}
        self.path = self.paths[k // 5 % 3]
        return Command(np.float64(observation.t), np.float32(0.01) * self.gain, 0, np.float64(0.1), False)
'''


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One for all tests, so that one process serves as many of them as it survives."""
    folder = tmp_path_factory.mktemp("stacks")
    (folder / "pytest.ini").write_text("[pytest]\n")
    (folder / "s.py").write_text(STACKS)
    return folder


@pytest.fixture(autouse=True)
def here(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)


def both(path: Path, name: str, **options: object) -> tuple[RunResult, RunResult]:
    """The same run in a process of its own and in this one; their logs have the same bytes."""
    apart, within = (run(path, ads=f"s.py:{name}", stack_process=how, **options) for how in ("on", "off"))  # type: ignore[arg-type]
    logs = []
    for result in (apart, within):
        result.log.save("log.mcap")
        logs.append(Path("log.mcap").read_bytes())
    assert logs[0] == logs[1]
    return apart, within


def test_all_that_a_stack_offers_gives_the_same_bytes_in_a_process_of_its_own(scenario: Write) -> None:
    apart, _ = both(scenario(*WITH_TARGET), "Offers", duration=1.5)
    assert apart.error is None
    assert apart.log.meta["P"] == {"gain": 2, "offset": 0.5}
    assert apart.log["ads.count"].max() > 0
    assert len(apart.log.paths) == 4
    assert list(apart.log.detections.x[:3]) == [0.0, 1.0, 2.0]


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("Loops", "ADS s.py:Loops: tick did not return within 1 s (--tick-limit)"),
        ("Raises", "KeyError: 'key'"),
        ("Ends", "ADS s.py:Ends: tick ended the program: SystemExit: 3 (s.py:56)"),
        ("Nothing", "ADS s.py:Nothing: tick returned None, expected a vehicle.messages.Command"),
    ],
)
def test_what_a_stack_does_wrong_reads_the_same_in_both(scenario: Write, name: str, says: str) -> None:
    apart, within = both(scenario(), name, **({"tick_limit": LIMIT} if name == "Loops" else {}))
    assert apart.status == within.status == "ERROR"
    assert apart.error is not None
    assert apart.error.strip().splitlines()[-1] == says
    assert within.error == apart.error
    if name in ("Loops", "Raises"):
        assert apart.error.startswith("Traceback (most recent call last):\n")
        assert ", in misbehave\n" in apart.error
        assert "pytest_dvp" not in apart.error
        assert apart.log.duration == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("HoldsTheLock", "ADS s.py:HoldsTheLock: tick did not return within 1 s (--tick-limit)"),
        ("Crashes", "ADS s.py:Crashes: its process ended in tick (killed by SIGSEGV)"),
        ("Leaves", "ADS s.py:Leaves: its process ended in tick (exit code 0): no licence"),
        ("Asks", "EOFError: EOF when reading a line"),
    ],
)
@pytest.mark.nightly(by_day=2)
def test_what_no_interruption_reaches_is_ended_and_the_next_run_has_a_new_process(
    scenario: Write, name: str, says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = scenario()
    result = run(path, ads=f"s.py:{name}", **({"tick_limit": LIMIT} if name == "HoldsTheLock" else {}))
    assert (result.status, result.ending) == ("ERROR", "fault")
    assert result.error is not None
    assert result.error.strip().splitlines()[-1] == says
    assert result.log.duration == pytest.approx(0.5)
    assert name == "Leaves" or ", in misbehave\n" in result.error
    printed = capsys.readouterr()
    assert ("so far" in printed.out) == (name == "HoldsTheLock")
    assert ("no licence" in printed.err) == (name == "Leaves")
    assert name != "HoldsTheLock" or run(path, ads="s.py:Straight", duration=0.1).error is None


def test_a_stack_that_never_comes_to_be_is_one_line(scenario: Write) -> None:
    Path("endless.py").write_text("import time\nwhile True: time.sleep(0.001)\n")
    says = (
        r"^ADS s.py:SleepsAtFirst: cannot be made: __init__ did not return within 1.2 s \(--tick-limit\) \(s.py:6\d\)$"
    )
    for how in ("on", "off"):
        with pytest.raises(AdsError, match=says):
            run(scenario(), ads="s.py:SleepsAtFirst", tick_limit=0.2, stack_process=how)
        with pytest.raises(
            AdsError, match=r"cannot be loaded: import did not return within 0.3 s .* \(endless.py:2\)$"
        ):
            run(scenario(), ads="endless.py:Stack", tick_limit=0.05, stack_process=how)


def test_trace_and_close_cannot_hang_a_run_either(scenario: Write, capsys: pytest.CaptureFixture[str]) -> None:
    for how in ("on", "off"):
        result = run(scenario(), ads="s.py:NeverCloses", duration=0.1, tick_limit=0.2, stack_process=how)
        assert result.error is None
        assert "ADS s.py:NeverCloses: close did not return within 1.2 s (--tick-limit)\n" in capsys.readouterr().err
    result = run(scenario(), ads="s.py:HangingTrace", tick_limit=0.2, stack_process="off")
    assert result.error is not None
    assert ", in trace\n" in result.error


def test_the_wall_limit_holds_while_a_tick_hangs_and_the_car_is_stopped(
    scenario: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    stopped = []
    monkeypatch.setattr("vehicle.twin.Twin.stop", lambda car: stopped.append(car))
    for how in ("on", "off"):
        result = run(scenario(), ads="s.py:HangsAtOnce", wall_limit=1.5, stack_process=how)
        assert (result.status, result.ending) == ("ERROR", "wall")
        assert result.error is not None
        assert result.error.endswith("tick did not return before the wall limit of 1.5 s ended the run")
    assert len(stopped) == 2


def test_one_process_serves_run_after_run_with_a_new_stack_until_its_file_changes(
    scenario: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    path = scenario()
    Path("t.py").write_text(STACKS)
    for _ in range(2):
        assert run(path, ads="t.py:Loops", duration=0.2).error is None
    assert capsys.readouterr().out.count("loaded by") == 1
    Path("t.py").write_text(STACKS + "\n# edited\n")
    run(path, ads="t.py:Loops", duration=0.1)
    assert capsys.readouterr().out.count("loaded by") == 1


def test_the_environment_and_the_current_folder_of_a_run_are_those_of_the_harness(
    scenario: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    Path("places.py").write_text(
        "import os\n\nfrom vehicle.messages import Command\n\n\nclass Stack:\n    def __init__(self):\n"
        "        self.trace = {'set': float(os.environ.get('MINE', -1)), 'here': os.path.exists('places.py')}\n"
        "        os.chdir('/')\n\n    def tick(self, o):\n        return Command(o.t, 0.0, 0.0, 0.0, 0.0)\n"
    )
    path = scenario()
    found = []
    for value in ("1", "2", None):
        monkeypatch.setenv("MINE", value) if value else monkeypatch.delenv("MINE")
        log = run(path, ads="places.py:Stack", duration=0.1).log
        found.append((log["ads.set"][0], log["ads.here"][0]))
    assert found == [(1.0, 1.0), (2.0, 1.0), (-1.0, 1.0)]


def test_a_class_that_is_given_runs_here_and_its_python_code_is_interrupted(scenario: Write) -> None:
    import time

    from vehicle.messages import Command, Observation

    class Hangs:
        def __init__(self) -> None:
            self.trace = {"pid": os.getpid()}

        def tick(self, observation: Observation) -> Command:
            if observation.t > 0.2:
                time.sleep(1000.0)
            return Command(observation.t, 0.0, 0.0, 0.0, 0.0)

    result = run(scenario(), ads=Hangs, tick_limit=0.2, stack_process="on")
    assert result.log["ads.pid"][0] == os.getpid()
    assert result.error is not None
    assert "time.sleep(1000.0)" in result.error


def test_in_another_thread_python_code_is_interrupted_too(scenario: Write) -> None:
    import threading

    path, found = scenario(), list[RunResult]()
    thread = threading.Thread(
        target=lambda: found.append(run(path, ads="s.py:Stubborn", tick_limit=0.1, stack_process="off"))
    )
    thread.start()
    thread.join()
    assert str(found[0].error).endswith("did not return within 0.1 s (--tick-limit)")


def test_what_a_stack_prints_is_no_part_of_the_json(scenario: Write, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(scenario())
    for how in ("on", "off"):
        Path("u.py").write_text(STACKS + f"\n# {how}\n")
        assert main(["run", path, "--ads", "u.py:Straight", "--json", "--no-report", "--stack-process", how]) == 0
        printed = capsys.readouterr()
        assert json.loads(printed.out)["status"] == "PASS"
        assert "loaded by" in printed.err


def test_a_process_that_was_forked_leaves_the_processes_of_its_parent_alone(scenario: Write) -> None:
    path = scenario()
    run(path, ads="s.py:Straight", duration=0.1)
    kept = list(stack_process._IDLE)
    assert kept
    child = os.fork()
    if child == 0:
        free = stack_process.borrow("s.py:Straight", ())
        os._exit(0 if free is None else 1)
    assert os.waitpid(child, 0)[1] == 0
    assert kept == stack_process._IDLE
