"""Public scenario files: each becomes a model or findings; what becomes a model is written and reads back equal."""

from __future__ import annotations

from pathlib import Path

import pytest

from openscenario.findings import ScenarioError
from openscenario.model import FollowTrajectoryAction, Polyline
from openscenario.read import read_scenario
from openscenario.write import write_scenario

NAMED = (
    "openMSL__sl-3-1-osc-alks-scenarios/logical_scenarios/concrete_scenarios/"
    "alks_scenario_4_2_3_crossing_pedestrian_template.xosc",
    "vectorgrp__OSC-NCAP-scenarios/OpenSCENARIO/NCAP/AEB_VRU_2023/NCAP_AEB_VRU_CPNA_2023.xosc",
    "esmini__esmini/resources/xosc/cut-in.xosc",
    "esmini__esmini/resources/xosc/pedestrian.xosc",
)
AT_LEAST = 140  # of 255 files become a model: the others are distributions, catalogues, negative samples, CARLA towns


@pytest.fixture(scope="session")
def corpus(shared_dir: Path) -> Path:
    return shared_dir / "openscenario" / "corpus"


@pytest.mark.parametrize("name", NAMED)
def test_the_named_scenarios_become_a_model(corpus: Path, name: str) -> None:
    scenario = read_scenario(corpus / name, library=[corpus])
    assert scenario.road_network.logic_file is not None
    assert any(entity.name.lower() == "ego" for entity in scenario.entities)


def test_expressions_of_a_public_file_have_the_values_computed_by_hand(corpus: Path) -> None:
    """The pedestrian of the ALKS template crosses on a polyline whose times come from `2 * sqrt(d * d) / v`."""
    scenario = read_scenario(corpus / NAMED[0], library=[corpus])
    values = {declaration.name: declaration.value for declaration in scenario.parameter_declarations}
    actions = [
        action.action
        for story in scenario.storyboard.stories
        for act in story.acts
        for group in act.maneuver_groups
        for maneuver in group.maneuvers
        for event in maneuver.events
        for action in event.actions
    ]
    (follow,) = [action for action in actions if isinstance(action, FollowTrajectoryAction)]
    assert isinstance(follow.trajectory.shape, Polyline)
    offset = abs(float(values["TargetBlocking_InitPosition_LateralOffset_m"]))
    speed = float(values["TargetBlocking_Speed_kph"]) / 3.6
    assert follow.trajectory.shape.vertices[-1].time == pytest.approx(2 * offset / speed)


def test_every_file_becomes_a_model_or_findings(corpus: Path, tmp_path: Path) -> None:
    files = sorted(corpus.rglob("*.xosc"))
    read, unexplained = 0, list[Path]()
    for file in files:
        try:
            scenario = read_scenario(file, library=[corpus])
        except ScenarioError as refused:
            unexplained += [file] if all(finding.severity != "error" for finding in refused.findings) else []
            continue
        read += 1
        write_scenario(scenario, tmp_path / "copy.xosc")
        assert read_scenario(tmp_path / "copy.xosc", library=[corpus]) == scenario, file
    assert unexplained == []
    assert len(files) == 255
    assert read >= AT_LEAST


def test_written_files_are_valid_against_the_schema(corpus: Path, tmp_path: Path) -> None:
    """The schema of 1.3 as packaged with `scenariogeneration`."""
    etree = pytest.importorskip("lxml.etree")
    schema_file = _schema()
    if schema_file is None:
        pytest.skip("no OpenSCENARIO schema installed")
    schema = etree.XMLSchema(etree.parse(str(schema_file)))
    for name in NAMED:
        write_scenario(read_scenario(corpus / name, library=[corpus]), tmp_path / "copy.xosc")
        assert schema.validate(etree.parse(str(tmp_path / "copy.xosc"))), (name, schema.error_log)


def _schema() -> Path | None:
    from importlib.metadata import PackageNotFoundError, files

    try:
        found = files("scenariogeneration") or []
    except PackageNotFoundError:
        return None
    return next((Path(str(f.locate())) for f in found if f.name == "OpenSCENARIO_1_3_1.xsd"), None)
