"""A planted fault is found, shrunk to a variant one can read, written as a file, and replayed by one command."""

from __future__ import annotations

import dataclasses
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from openscenario.read import read_declarations
from scenarios import path as shipped

# tests/plugin/test_fuzz_page.py searches in each run of the tests; this second search is a minute of `make nightly`.
pytestmark = pytest.mark.nightly

# The stack notices a crossing 10 m before its middle only: soon enough for the nominal pedestrian, not for others.
TEST = """
from hypothesis import given, settings
from pytest_dvp import scenario_variants

@settings(max_examples=25, derandomize=True, database=None)
@given(variant=scenario_variants("pedestrian_crossing.xosc"))
def test_with_a_late_crossing_rule(run, gate, variant):
    gate(run(variant, P={"DECISION_PC_d_max": 10.0}))
"""


@dataclasses.dataclass(frozen=True)
class Failure:
    folder: Path
    output: str

    @property
    def lines(self) -> list[str]:
        """The failure's own text: from the test's heading to the next section of pytest."""
        lines = self.output.splitlines()
        start = next(i for i, line in enumerate(lines) if line.startswith("____"))
        end = next(i for i, line in enumerate(lines[start:], start) if re.match(r"=+ (dvp|short test summary)", line))
        return lines[start:end]

    @property
    def command(self) -> list[str]:
        return shlex.split(self.lines[-1])

    @property
    def gate(self) -> str:
        """Which gate failed, with its numbers."""
        line = next(line for line in self.lines if "GateFailed: " in line)
        return line.partition("GateFailed: ")[2]


@pytest.fixture(scope="module")
def failure(tmp_path_factory: pytest.TempPathFactory) -> Failure:
    folder = tmp_path_factory.mktemp("planted")
    (folder / "pytest.ini").write_text(
        "[pytest]\naddopts = --strict-markers --strict-config -W error -p no:cacheprovider\n"
    )
    (folder / "test_planted.py").write_text(TEST)
    return Failure(folder, _python(folder, "-m", "pytest", "-p", "no:benchmark", "test_planted.py").stdout)


def _python(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "COLUMNS": "120"}
    for name in ("GITHUB_ACTIONS", "PYTEST_ADDOPTS"):
        environment.pop(name, None)
    command = [sys.executable, *arguments]
    return subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300, check=False
    )


def test_the_fault_is_found(failure: Failure) -> None:
    assert "1 failed" in failure.output
    assert failure.gate


def test_it_is_shrunk_to_one_changed_parameter_with_a_short_value(failure: Failure) -> None:
    (example,) = {line.strip() for line in failure.lines if re.match(r"E?\s+variant=", line)}
    found = re.fullmatch(r"E?\s*variant=Variant\(pedestrian_crossing\.xosc, (\w+)=([\d.]+)\),?", example)
    assert found is not None, example
    assert found[1] in ("ego_speed", "pedestrian_speed", "trigger_distance")
    assert len(found[2]) <= 5


def test_the_variant_is_a_file_whose_values_are_the_variants(failure: Failure) -> None:
    file = failure.folder / failure.command[2]
    assert file.suffix == ".xosc"
    written = {declared.name: float(declared.value) for declared in read_declarations(file)}
    nominal = {d.name: float(d.value) for d in read_declarations(shipped("pedestrian_crossing.xosc"))}
    assert written.keys() == nominal.keys()
    assert sum(written[name] != nominal[name] for name in nominal) == 1


def test_the_last_line_is_a_command_that_fails_the_same_way(failure: Failure) -> None:
    program, *arguments = failure.command
    assert program == "dvp"
    replayed = _python(failure.folder, "-m", "pytest_dvp.cli", *arguments, "--no-report")
    assert replayed.returncode == 1, replayed.stderr
    assert failure.gate in replayed.stdout
