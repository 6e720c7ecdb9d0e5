"""`dvp check X.xosc` exits 1 exactly when `dvp run X.xosc` is refused before its first tick.

The answer of the run is what `prepare` does, with which every run begins.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from openscenario.findings import ScenarioError
from pytest_dvp.campaigns.cases import is_distribution
from pytest_dvp.cli.command_line import main
from pytest_dvp.cli.shared import runnable_scenarios
from pytest_dvp.drive.preparation import prepare
from pytest_dvp.drive.request import request_of, spec_of
from pytest_dvp.drive.run_spec import RunSpec
from pytest_dvp.verdicts.gate import GateError

Write = Callable[..., Path]
PLACE = '<LanePosition roadId="1" laneId="-1" s="10"/>'
ROAD = '<RoadNetwork><LogicFile filepath="straight.xodr"/></RoadNetwork>'
OUTSIDE = "../elsewhere/catalogs"
CHANGES = {
    "as it is": (),
    "no ego": (('"Ego"', '"Target"'),),
    "the ego of CARLA": (('"Ego"', '"hero"'),),
    "the ego is a name in the wrong case": (('name="Ego"', 'name="ego"'), ('entityRef="Ego"', 'entityRef="ego"')),
    "an entity that nobody declares": (('entityRef="Ego"', 'entityRef="Eggo"'),),
    "no road": ((ROAD, "<RoadNetwork/>"),),
    "a road that is not there": (("straight.xodr", "no.xodr"),),
    "a place that needs a geo reference": ((PLACE, '<GeoPosition latitudeDeg="48" longitudeDeg="11"/>'),),
    "a lane that the road does not have": ((PLACE, PLACE.replace('"-1"', '"-9"')),),
    "a place behind the end of the road": ((PLACE, PLACE.replace('"10"', '"1e5"')),),
    "a version before 1.0": (('revMajor="1"', 'revMajor="0"'),),
    "a date that is none": (('date="2026-01-01T00:00:00"', 'date="yesterday"'),),
    "no date": ((' date="2026-01-01T00:00:00"', ""),),
    "a catalogue folder outside of the allowed ones": (
        (
            "<CatalogLocations/>",
            f'<CatalogLocations><VehicleCatalog><Directory path="{OUTSIDE}"/></VehicleCatalog></CatalogLocations>',
        ),
    ),
}  # fmt: skip
GATES = {
    "a goal on the road": 'goal = { road = "1", lane = -1, s = 100.0 }',
    "a goal on no lane": 'goal = { road = "1", lane = -4, s = 100.0 }',
    "a goal behind the end of the road": 'goal = { road = "1", lane = -1, s = 1e5 }',
    "a goal against the traffic": 'goal = { road = "1", lane = -1, s = 2.0 }',
}
ROADS = {
    "an empty side": ("<center>", "<left></left><center>"),
    "no header": ("<header", "<userData"),
    "a gap": ('length="', 'length="9'),
    "no lane to drive on": ('type="driving"', 'type="sidewalk"'),
    "not well-formed": ("</planView>", ""),
}
EVERY = 1 if os.environ.get("DVP_NIGHTLY") else 22  # of the files found in public repositories


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What runs is asked in this process; test_check_runnable.py asks the process that a check starts for it."""

    def ask(files: Sequence[str], settings: RunSpec) -> dict[str, tuple[str, int | None]]:
        return {file: runnable_scenarios._refusal(Path(file), settings) for file in files}

    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(runnable_scenarios, "_ask", ask)


def refused(path: Path, **options: object) -> bool:
    """Whether a run of the file does not come to its first tick."""
    given = {"rootdir": Path.cwd(), **options}
    try:
        prepare(request_of(path, given, spec_of(given))).close()
    except (ScenarioError, GateError):
        return True
    return False


def checked(path: Path, *words: str) -> bool:
    """Whether a check of the file finds an error."""
    return main(["check", str(path), "--json", *words]) == 1


@pytest.mark.parametrize("what", CHANGES)
def test_scenarios(scenario: Write, what: str) -> None:
    path = scenario(*CHANGES[what])
    assert checked(path) is refused(path)


@pytest.mark.parametrize("what", GATES)
def test_gate_files(scenario: Write, what: str) -> None:
    path = scenario()
    path.with_name("x.gates.toml").write_text(f'[task]\n{GATES[what]}\n\n[[gate]]\nmetric = "collision"\nmax = 0\n')
    assert checked(path) is refused(path)


@pytest.mark.parametrize("roads", ["strict", "lenient"])
@pytest.mark.parametrize("what", ROADS)
def test_roads(scenario: Write, what: str, roads: str) -> None:
    path = scenario()
    road = path.with_name("straight.xodr")
    old, new = ROADS[what]
    assert old in road.read_text()
    road.write_text(road.read_text().replace(old, new))
    assert checked(path, "--roads", roads) is refused(path, roads=roads)


def test_both_answers_are_among_them(scenario: Write) -> None:
    """The tests above would pass with two functions that always say no."""
    assert not refused(scenario())
    assert refused(scenario(*CHANGES["no ego"]))


@pytest.mark.parametrize("kind", ["wild", "corpus"])
def test_files_of_public_repositories(shared_dir: Path, kind: str) -> None:
    folder = shared_dir / "openscenario" / kind
    files = [path for path in sorted(folder.rglob("*.xosc")) if not runnable_scenarios.is_catalogue(path)]
    different = []
    for path in files[::EVERY]:
        try:
            if is_distribution(path):
                continue
        except ScenarioError:
            pass  # no XML: both say so
        if checked(path, "--library", str(folder)) is not refused(path, library=[folder]):
            different.append(path.name)
    assert different == []
