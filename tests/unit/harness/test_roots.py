"""What a scenario may reach from where the command stands: the root folder, and the folders of the ini file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from pytest_dvp.cli.command_line import main

Write = Callable[..., Path]
INI = {
    "pytest.ini": "[pytest]\ndvp_library =\n    {}\n",
    "tox.ini": "[pytest]\ndvp_library = {}\n",
    "setup.cfg": "[tool:pytest]\ndvp_library = {}\n",
    "pyproject.toml": '[tool.pytest.ini_options]\ndvp_library = ["{}"]\n',
}


@pytest.fixture
def project(scenario: Write, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with roads/ and scenarios/x.xosc, which names ../roads/straight.xodr; the command stands beside it."""
    path = scenario(('filepath="straight.xodr"', 'filepath="../roads/straight.xodr"'))
    for folder in ("roads", "scenarios"):
        (path.parent / folder).mkdir()
    (path.parent / "straight.xodr").rename(path.parent / "roads" / "straight.xodr")
    path.rename(path.parent / "scenarios" / "x.xosc")
    monkeypatch.chdir(path.parent / "scenarios")
    return path.parent


def test_a_path_outside_says_which_folders_were_taken_and_what_to_do(
    project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["play", "x.xosc"]) == 1
    said = capsys.readouterr().err
    assert f"allowed: below {project / 'scenarios'} (" in said
    assert "--library DIR (dvp_library in the ini file), or put a pytest.ini into the folder above both" in said
    assert main(["play", "x.xosc", "--library", "../roads"]) == 0
    (project / "pytest.ini").write_text("[pytest]\n")
    assert main(["play", "x.xosc"]) == 0


@pytest.mark.parametrize("name", INI)
def test_the_library_of_the_ini_file_holds_for_the_command_as_well(
    name: str, project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its path starts at the ini file, as in pytest, and not where the command stands."""
    (project / "scenarios" / name).write_text(INI[name].format("../roads"))
    assert main(["play", "x.xosc"]) == 0
    (project / "scenarios" / name).write_text(INI[name].format("../rods"))
    assert main(["play", "x.xosc"]) == 2
    assert f"{name}: dvp_library: no folder " in capsys.readouterr().err
