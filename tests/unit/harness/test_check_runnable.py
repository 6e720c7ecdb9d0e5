"""The last lines of `dvp check FOLDER`: which of its scenarios run, and why the others do not."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from pytest_dvp.cli.command_line import main

Write = Callable[..., Path]
ROAD = '<RoadNetwork><LogicFile filepath="straight.xodr"/></RoadNetwork>'
GEO = '<GeoPosition latitudeDeg="48" longitudeDeg="11"/>'  # and the road does not say where on the earth it is


@pytest.mark.nightly
def test_each_scenario_is_said_to_run_or_why_not(
    scenario: Write, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], checks_in_a_child: None
) -> None:
    folder = scenario(name="good.xosc").parent
    scenario((ROAD, "<RoadNetwork/>"), name="no_road.xosc")
    scenario(('<LanePosition roadId="1" laneId="-1" s="10"/>', GEO), name="geo.xosc")
    scenario(('entityRef="Ego"', 'entityRef="Eggo"'), name="typo.xosc")
    (folder / "catalogue.xosc").write_text(
        (folder / "good.xosc").read_text().split("<ParameterDeclarations>")[0] + '<Catalog name="c"/></OpenSCENARIO>'
    )
    (folder / "pytest.ini").write_text("[pytest]\n")
    monkeypatch.chdir(folder)
    main(["check", ".", "--json"])
    rows = {row["file"]: row for row in json.loads(capsys.readouterr().out)["scenarios"]}
    assert {name: row["runs"] for name, row in rows.items()} == {
        "geo.xosc": False, "good.xosc": True, "no_road.xosc": False, "typo.xosc": False,
    }  # fmt: skip
    assert "the scenario names no road network" in rows["no_road.xosc"]["why"]
    assert "geo" in rows["geo.xosc"]["why"].lower()
    assert "Eggo" in rows["typo.xosc"]["why"]
    main(["check", "."])
    assert "\ngood.xosc: runs\n" in capsys.readouterr().err


def test_a_scenario_whose_gate_file_is_wrong_does_not_run_and_the_line_is_said_of_that_file(
    scenario: Write, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = scenario().parent
    (folder / "x.gates.toml").write_text('\n[[gate]]\nmetric = "tetx"\nmax = 1\n')
    (folder / "pytest.ini").write_text("[pytest]\n")
    monkeypatch.chdir(folder)
    assert main(["check", "."]) == 1
    said = capsys.readouterr().err
    assert "x.xosc: refused: x.gates.toml:3: " in said
    assert "runs" not in said


def test_the_line_of_a_broken_road_is_said_with_the_road(
    scenario: Write, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = scenario().parent
    road = (folder / "straight.xodr").read_text()
    (folder / "straight.xodr").write_text(road[: road.index("<planView>")])  # of its line 6
    (folder / "pytest.ini").write_text("[pytest]\n")
    monkeypatch.chdir(folder)
    assert main(["check", "."]) == 1
    assert "x.xosc: refused: straight.xodr:6: not well-formed" in capsys.readouterr().err
