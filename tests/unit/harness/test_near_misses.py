"""Files that are nearly right: a road of another folder, names of CARLA, a version before 1.0, a missing file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from openscenario.findings import Finding, ScenarioError
from openscenario.model.entities import ego_among
from openscenario.read import check_scenario, read_scenario
from openscenario.road.network import load_network
from openscenario.storyboard.engine import Storyboard

Write = Callable[..., Path]
ROAD = 'filepath="straight.xodr"'
CRITERION = (
    '<StopTrigger><ConditionGroup><Condition name="criteria_RunningStopTest" delay="0" conditionEdge="rising">'
    '<ByValueCondition><ParameterCondition parameterRef="" value="" rule="lessThan"/></ByValueCondition>'
    "</Condition></ConditionGroup></StopTrigger></Storyboard>"
)


@pytest.fixture
def maps(scenario: Write, tmp_path: Path) -> Path:
    """A folder with the road of the scenario under the name of a town of CARLA."""
    folder = tmp_path / "maps"
    (folder / "Databases").mkdir(parents=True)
    text = (scenario().parent / "straight.xodr").read_text()
    (folder / "Town04.xodr").write_text(text)
    (folder / "Databases" / "e6mini.xodr").write_text(text)
    return folder


def errors(path: Path, **options: object) -> list[Finding]:
    found = check_scenario(path, strict=False, **options)  # type: ignore[arg-type]
    return [finding for finding in found if finding.severity == "error"]


@pytest.mark.parametrize(
    ("written", "used"),
    [
        ("Town04", "Town04.xodr"),
        ("Town04.xodr", "Town04.xodr"),
        ("../../elsewhere/Town04.xodr", "Town04.xodr"),
        ("Databases/e6mini.xodr", "Databases/e6mini.xodr"),
    ],
)
def test_a_road_is_found_in_a_library_folder_by_its_path_or_name(
    scenario: Write, maps: Path, written: str, used: str
) -> None:
    path = scenario((ROAD, f'filepath="{written}"'))
    inside = path.parent / "deep" / "deeper"
    inside.mkdir(parents=True)
    path = path.rename(inside / "x.xosc")
    found = read_scenario(path, library=[maps, path.parents[2]])
    assert found.road_network.logic_file == (maps / used).resolve()
    (warning,) = (each for each in check_scenario(path, library=[maps, path.parents[2]]) if each.code[:5] == "path.")
    assert (warning.code, warning.severity) == ("path.found_elsewhere", "warning")
    assert warning.element.endswith("LogicFile@filepath")


def test_the_road_beside_the_scenario_comes_first(scenario: Write, maps: Path) -> None:
    path = scenario()
    (maps / "straight.xodr").write_text("no road")
    assert read_scenario(path, library=[maps]).road_network.logic_file == (path.parent / "straight.xodr").resolve()


def test_a_missing_road_is_said_with_all_folders_and_the_nearest_name(scenario: Write, maps: Path) -> None:
    path = scenario((ROAD, 'filepath="Town40"'))
    (error,) = errors(path, library=[maps])
    assert error.code == "path.not_found"
    assert str(path.parent) in error.message
    assert str(maps) in error.message
    assert "did you mean 'Town04.xodr'?" in error.message


def test_a_road_outside_of_the_folders_is_still_refused(scenario: Write, maps: Path) -> None:
    (error,) = errors(scenario((ROAD, 'filepath="/etc/Town04.xodr"')), library=[maps])
    assert error.code == "path.outside_root"


@pytest.mark.parametrize(
    ("names", "ego"),
    [
        (("hero", "adversary"), "hero"),
        (("a", "ego_vehicle"), "ego_vehicle"),
        (("hero", "EGO"), "EGO"),
        (("Heron", "b"), None),
    ],
)
def test_the_ego_is_known_by_the_names_that_carla_gives_it(names: tuple[str, ...], ego: str | None) -> None:
    assert ego_among(names) == ego


def test_a_criterion_of_carla_is_never_true_and_said(scenario: Write) -> None:
    path = scenario()
    text = path.read_text()
    path.write_text(text[: text.rindex("<StopTrigger>")] + CRITERION + "</OpenSCENARIO>")
    (finding,) = (each for each in check_scenario(path) if each.code == "condition.criterion")
    assert (finding.severity, finding.found) == ("warning", "criteria_RunningStopTest")
    read = read_scenario(path)
    board = Storyboard(read, load_network(path.with_name("straight.xodr")))
    board.start()
    for _ in range(10):
        board.step(0.1)
    assert not board.done


def test_a_parameter_that_nobody_declares_is_an_error_elsewhere(scenario: Write) -> None:
    path = scenario()
    text = path.read_text()
    wrong = CRITERION.replace("criteria_RunningStopTest", "stop")
    path.write_text(text[: text.rindex("<StopTrigger>")] + wrong + "</OpenSCENARIO>")
    assert [each.code for each in errors(path)] == ["param.undefined"]


def test_a_version_before_1_0_is_refused_with_advice(scenario: Write) -> None:
    path = scenario(('revMajor="1"', 'revMajor="0"'))
    with pytest.raises(ScenarioError, match="style sheet"):
        read_scenario(path)


def test_a_header_without_a_description_is_a_warning(scenario: Write) -> None:
    path = scenario()
    text = path.read_text()
    start = text.index(' description="')
    path.write_text(text[:start] + text[text.index('"', start + 15) + 1 :])
    assert read_scenario(path).file_header.description == ""
    found = [(each.code, each.severity) for each in check_scenario(path)]
    assert found == [("xml.missing_attribute", "warning")]
