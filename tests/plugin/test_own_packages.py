"""A project with packages `vehicle` and `ads` of its own: theirs and ours work in one process, whoever starts it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from pytest_dvp.rooms.side_by_side import ROOT
from tests.plugin.conftest import write_scenario

STACK = """
from ads.speeds import WANTED
from pytest_dvp.rooms.vehicle.messages import Command
import vehicle

assert vehicle.OWNER == "the project"


class Stack:
    def tick(self, observation):
        return Command(observation.t, 0.0, WANTED, 0.5, 0.0)
"""
TESTS = """
import pickle

import pytest_dvp
import vehicle
from ads.speeds import WANTED
from vehicle.my_stack import Command, Stack


def test_their_modules_are_theirs():
    assert (vehicle.OWNER, WANTED) == ("the project", 0.25)
    assert pickle.loads(pickle.dumps(Stack)) is Stack


def test_their_stack_drives_in_our_car(run):
    log = run("s.xosc", ads="vehicle.my_stack:Stack").log
    assert log.meta["ads"] == "vehicle.my_stack:Stack"
    assert set(log["throttle_cmd"][1:]) == {0.5}
    assert type(pickle.loads(pickle.dumps(Command(0.0, 0.0, 0.0, 0.0, 0.0)))) is Command
"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    write_scenario(tmp_path, "s.xosc")
    (tmp_path / "pytest.ini").write_text("[pytest]\npythonpath = .\ndvp_duration = 0.2\n")
    for name in ("vehicle", "ads"):
        (tmp_path / name).mkdir()
    (tmp_path / "vehicle" / "__init__.py").write_text('OWNER = "the project"\n')
    (tmp_path / "vehicle" / "my_stack.py").write_text(STACK)
    (tmp_path / "ads" / "__init__.py").touch()
    (tmp_path / "ads" / "speeds.py").write_text("WANTED = 0.25\n")
    (tmp_path / "test_own.py").write_text(TESTS)
    return tmp_path


def started(words: list[str], folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    there = {name: value for name, value in os.environ.items() if name not in ("DVP_ROOMS", "PYTHONPATH")}
    command, there = [sys.executable, *words], {**there, **environment}
    return subprocess.run(command, cwd=folder, env=there, capture_output=True, text=True, check=False)


PYTEST = "import sys, pytest; sys.path.pop(0); raise SystemExit(pytest.main())"
"""What the command `pytest` does: unlike `python -m pytest` it leaves the current folder out of Python's path."""


@pytest.mark.nightly
def test_their_stack_and_their_tests_run_beside_ours_in_a_worker_of_xdist(project: Path) -> None:
    done = started(["-c", PYTEST, "-q", "-n", "1", "-p", "no:cacheprovider"], project)
    assert "2 passed" in done.stdout, done.stdout + done.stderr


def test_python_m_pytest_finds_both(project: Path) -> None:
    """The option asks our `ads` for its parameters, the test asks theirs."""
    words = ["-m", "pytest", "-q", "-p", "no:cacheprovider", "-k", "theirs"]
    done = started([*words, "--dvp-set", "P.LQR_q11=3", "s.xosc", "test_own.py"], project)
    assert "1 passed, 4 deselected" in done.stdout, done.stdout + done.stderr


DVP = ["-P", "-c", "from pytest_dvp.cli.command_line import main; raise SystemExit(main())"]


@pytest.mark.nightly
def test_dvp_drives_their_stack(project: Path) -> None:
    words = ["run", "s.xosc", "--no-report", "--json", "--ads", "vehicle.my_stack:Stack"]
    done = started([*DVP, *words], project, PYTHONPATH=".")
    assert json.loads(done.stdout)["ads"] == "vehicle.my_stack:Stack", done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.nightly
def test_dvp_checks_beside_their_packages(project: Path) -> None:
    done = started([*DVP, "check", "s.xosc", "--json"], project)
    assert (done.returncode, json.loads(done.stdout)["findings"]) == (0, []), done.stderr


@pytest.mark.parametrize("name", ["machine_code", "openscenario", "reports", "scenarios", "vehicle.py"])
def test_any_of_the_names_may_be_theirs_and_a_module_of_the_name_counts(name: str, tmp_path: Path) -> None:
    theirs = tmp_path / name
    if not theirs.suffix:
        theirs.mkdir()
        theirs /= "__init__.py"
    theirs.write_text("OWNER = 1\n")
    stem = Path(name).stem
    code = f"import {stem} as theirs, pytest_dvp, pytest_dvp.rooms.{stem} as ours; print(theirs.OWNER, ours.__file__)"
    said = started(["-c", code], tmp_path)
    assert said.stdout.split()[0] == "1", said.stderr
    assert not Path(said.stdout.split()[1]).is_relative_to(tmp_path)


def test_a_script_may_import_theirs_before_or_after_ours(project: Path) -> None:
    for first, second in (("vehicle", "pytest_dvp"), ("pytest_dvp", "vehicle")):
        (project / "script.py").write_text(
            f"import {first}, {second}\n"
            "from pytest_dvp.drive.driver import Command\n"
            "from pytest_dvp.rooms.vehicle.messages import Command as ours\n"
            "assert vehicle.OWNER and Command is ours\n"
            "import scenarios\n"  # the project has none, so this is ours, once
            "from pytest_dvp.rooms import scenarios as again\n"
            "assert scenarios is again, (scenarios, again)\n"
        )
        done = started(["script.py"], project)
        assert done.returncode == 0, done.stderr


def test_the_surrogate_starts_by_the_name_that_nobody_else_has(project: Path, tmp_path: Path) -> None:
    for folder in (project, Path(sys.prefix)):
        done = started(["-m", "pytest_dvp.rooms.vehicle.surrogate", "--help"], folder)
        assert done.stdout.startswith("usage: python -m vehicle.surrogate"), done.stderr


def test_without_a_package_of_theirs_both_names_are_one_module() -> None:
    code = "import pytest_dvp, vehicle.messages as m, pytest_dvp.rooms.vehicle.messages as r; print(m is r, m.__name__)"
    assert started(["-c", code], Path(sys.prefix)).stdout == "True vehicle.messages\n"


def test_ours_loaded_before_theirs_was_in_sight_is_said_in_one_line(project: Path) -> None:
    code = "import sys, pytest_dvp.drive.driver; sys.path.insert(0, sys.argv[1]); import vehicle.my_stack"
    done = started(["-c", code, str(project)], Path(sys.prefix))
    last = done.stderr.splitlines()[-1]
    assert last.startswith(f"ModuleNotFoundError: {project}/vehicle is not searched: pytest_dvp has loaded its own")
    assert last.endswith("or set the environment variable DVP_ROOMS=apart)")
    assert started(["-c", code, str(project)], Path(sys.prefix), DVP_ROOMS="apart").returncode == 0


def test_theirs_beside_ours_loaded_by_hand_is_said_by_dvp_in_one_line(project: Path) -> None:
    """The project loads our `reports` before pytest_dvp, so that it cannot be moved, and has a `vehicle` of its own."""
    code = "import reports; from pytest_dvp.cli.command_line import main; raise SystemExit(main(['check', 's.xosc']))"
    done = started(["-c", code], project)
    assert done.returncode == 2
    assert done.stderr.startswith(f"dvp: {project}/vehicle hides the package 'vehicle' that pytest_dvp needs: ")
    assert done.stderr.count("\n") == 1


WRONG = """
from vehicle.messages import Command


class Stack:
    def tick(self, observation):
        return Command(observation.t, 0.0, 0.0, 0.0, 0.0)
"""
THEIR_COMMAND = """
import collections

Command = collections.namedtuple("Command", "t steer accel throttle brake")
"""
CURE = "`from pytest_dvp.rooms.vehicle.messages import"


@pytest.mark.parametrize("own_messages", [False, True])
def test_a_stack_that_means_our_command_and_gets_theirs_is_told_how_to_import_ours(
    project: Path, own_messages: bool
) -> None:
    (project / "wrong.py").write_text(WRONG)
    if own_messages:
        (project / "vehicle" / "messages.py").write_text(THEIR_COMMAND)
    done = started([*DVP, "run", "s.xosc", "--no-report", "--ads", "wrong.py:Stack"], project, PYTHONPATH=".")
    line, *_ = [line for line in (done.stdout + done.stderr).splitlines() if CURE in line]
    assert "side_by_side" not in line
    if own_messages:
        assert (
            f"tick returned a Command of {project}/vehicle/messages.py, expected that of {ROOT}/vehicle/messages.py: "
            in line
        )
    else:
        assert "No module named 'vehicle.messages' (wrong.py:2); " in line
        assert f"'vehicle' is {project}/vehicle/__init__.py here, " in line
