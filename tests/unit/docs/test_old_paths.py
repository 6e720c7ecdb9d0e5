"""Import paths of version 0.1 work, and say where the names are now."""

from __future__ import annotations

import subprocess
import sys

import pytest

OLD = [
    ("pytest_dvp.log", "Log", "LogError", "FloatArray", "ObjectTrack"),
    ("pytest_dvp.logs.read", "read_log"),
    ("pytest_dvp.reality_gap.segments", "Segments"),
    ("pytest_dvp.reality_gap.black_box", "CompareError", "load_subject"),
    ("pytest_dvp.reality_gap.manoeuvres.robot", "CommandPlayer"),
    ("pytest_dvp.fixtures", "Run"),
    ("pytest_dvp.run", "run", "RunResult"),
    ("pytest_dvp.cli", "main"),
    ("vehicle.model.catalogue", "catalogue"),
    ("vehicle.model.parameters", "preset_s"),
    ("vehicle.model.replay", "Replay"),
]


def python(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-W", "always", "-c", code], capture_output=True, text=True, check=False)


def test_each_name_is_there_with_a_warning() -> None:
    lines = ["import pytest_dvp"]
    lines += [f"from {module} import {', '.join(names)}" for module, *names in OLD]
    lines += ["from pytest_dvp.logs import log, log_error", "assert (Log, LogError) == (log.Log, log_error.LogError)"]
    lines += ["import pytest_dvp.run", "assert callable(pytest_dvp.run)", "assert run is not None"]
    done = python("\n".join(lines))
    assert done.returncode == 0, done.stderr
    for module, *_ in OLD:
        assert f"DeprecationWarning: {module}" in done.stderr, module


def test_a_program_of_an_old_path_runs() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "pytest_dvp.ads_node", "--help"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "--ads" in done.stdout


@pytest.mark.parametrize("name", ["pytest_dvp.reality_gap.nothing", "pytest_dvp.logg"])
def test_other_names_are_unknown_as_ever(name: str) -> None:
    done = python(f"import pytest_dvp, {name}")
    assert f"ModuleNotFoundError: No module named {name!r}" in done.stderr


def test_a_name_that_no_new_module_has() -> None:
    assert "cannot import name 'Nothing' from 'pytest_dvp.log'" in python("from pytest_dvp.log import Nothing").stderr
