"""The budget of bytes and elements of scenarios, roads and catalogues, and the option that sets it."""

from __future__ import annotations

from pathlib import Path

import pytest

from openscenario.file_budget import BYTES, ELEMENTS, most_bytes, most_elements
from openscenario.findings import ScenarioError
from openscenario.road.opendrive import read_opendrive
from openscenario.xml import read_xml
from pytest_dvp.cli.command_line import main
from pytest_dvp.logs.budget import Budget, in_force
from tests.plugin.conftest import write_scenario


@pytest.mark.parametrize(("text", "size"), [("", BYTES), ("500", 500), ("2MB", 2_000_000), ("1GiB", 1 << 30)])
def test_the_variable_sets_it(text: str, size: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DVP_MAX_FILE_BYTES", text)
    assert most_bytes() == size


def test_elements_grow_with_the_bytes_and_do_not_shrink() -> None:
    assert [most_elements(n) for n in (1000, BYTES, 3 * BYTES)] == [ELEMENTS, ELEMENTS, 3 * ELEMENTS]


def test_a_budget_in_force_holds_for_roads(tmp_path: Path) -> None:
    write_scenario(tmp_path)
    road = tmp_path / "straight.xodr"
    size = road.stat().st_size
    read_opendrive(road)
    with in_force(Budget(file_bytes=size)):
        read_opendrive(road)
    with in_force(Budget(file_bytes=size - 1)), pytest.raises(ScenarioError, match=r"xml\.too_big.*--max-file-bytes"):
        read_opendrive(road)


@pytest.mark.parametrize("command", ["check", "play", "run"])
def test_the_option_of_a_command(command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write_scenario(tmp_path)
    assert main([command, str(path), "--max-file-bytes", "100"]) != 0
    told = capsys.readouterr()
    assert "up to 100 bytes" in told.out + told.err
    assert "--max-file-bytes allows more" in told.out + told.err


def test_a_file_with_more_elements_than_allowed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("openscenario.file_budget.ELEMENTS", 100)
    (tmp_path / "many.xml").write_text("<a>" + "<b/>" * 200 + "</a>")
    with pytest.raises(ScenarioError, match="more than 100 elements"):
        read_xml(tmp_path / "many.xml")
