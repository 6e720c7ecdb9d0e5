"""Public scenario files: each becomes a model or findings; what becomes a model is written and reads back equal."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Callable
from decimal import Decimal
from pathlib import Path
from typing import Any, TypeAlias

import pytest
from lxml import etree

from openscenario.findings import ScenarioError
from openscenario.model import CatalogFile, FollowTrajectoryAction, Polyline
from openscenario.read import read_cases, read_catalog, read_declarations, read_distribution, read_scenario
from openscenario.write import _write_one, write_distribution, write_scenario

Kind: TypeAlias = tuple[Callable[..., Any], Callable[..., None]]

NAMED = (
    "openMSL__sl-3-1-osc-alks-scenarios/logical_scenarios/concrete_scenarios/"
    "alks_scenario_4_2_3_crossing_pedestrian_template.xosc",
    "vectorgrp__OSC-NCAP-scenarios/OpenSCENARIO/NCAP/AEB_VRU_2023/NCAP_AEB_VRU_CPNA_2023.xosc",
    "esmini__esmini/resources/xosc/cut-in.xosc",
    "esmini__esmini/resources/xosc/pedestrian.xosc",
)
AT_LEAST = 140  # scenarios of 255 files become a model: the others are negative samples and CARLA towns
AT_LEAST_CATALOGS = 20
EVERY = 1 if "DVP_NIGHTLY" in os.environ else 3  # of the files
DISTRIBUTIONS = 54 if EVERY == 1 else 18


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


def _write_catalog(file: CatalogFile, path: Path) -> None:
    _write_one(file.file_header, file.catalog, path)


def test_every_file_becomes_a_model_that_is_written_and_reads_back_or_findings(corpus: Path, tmp_path: Path) -> None:
    kinds: dict[str, Kind] = {
        "ParameterValueDistribution": (read_distribution, write_distribution),
        "Catalog": (read_catalog, _write_catalog),
    }
    files = sorted(corpus.rglob("*.xosc"))
    became, unexplained = Counter[str](), list[Path]()
    for file in files[::EVERY]:
        found = re.search(rb"<(ParameterValueDistribution|Catalog)\b", file.read_bytes())
        kind = found.group(1).decode() if found else ""
        read, write = kinds.get(kind, (read_scenario, write_scenario))
        try:
            model = read(file, library=[corpus])
        except ScenarioError as refused:
            unexplained += [file] if all(finding.severity != "error" for finding in refused.findings) else []
            continue
        became[kind] += 1
        write(model, tmp_path / "copy.xosc")
        assert read(tmp_path / "copy.xosc", library=[corpus]) == model, file
    assert unexplained == []
    assert len(files) == 255
    assert became["ParameterValueDistribution"] == DISTRIBUTIONS
    assert became[""] >= AT_LEAST // EVERY
    assert became["Catalog"] >= AT_LEAST_CATALOGS // EVERY


def declared_in(scenario: Path | None) -> set[str]:
    return {declaration.name for declaration in read_declarations(scenario or "")}


def test_deterministic_distributions_have_as_many_cases_as_a_count_by_hand(corpus: Path) -> None:
    """Counted anew from the XML with decimals, and building no case: the count of 52,500 costs what that of 1 costs."""
    checked = 0
    for file in sorted(corpus.rglob("*.xosc")):
        root = etree.parse(str(file), etree.XMLParser(recover=True)).getroot()
        definition = None if root is None else root.find("ParameterValueDistribution/Deterministic")
        if definition is None:
            continue
        expected = 1
        for part in definition.findall("*"):
            steps = part.find("DistributionRange")
            if steps is None:
                listed = part.findall("DistributionSet/Element") or part.findall(
                    "ValueSetDistribution/ParameterValueSet"
                )
                expected *= len(listed)
                continue
            low, high = (Decimal(steps.find("Range").get(name)) for name in ("lowerLimit", "upperLimit"))
            expected *= int((high - low) // Decimal(steps.get("stepWidth"))) + 1
        cases = read_cases(file, library=[corpus])
        assert cases.count == expected, file
        assert cases[expected - 1].keys() <= declared_in(cases.scenario)
        checked += 1
    assert checked == 54


def test_written_files_are_valid_against_the_schema(corpus: Path, tmp_path: Path) -> None:
    """The schema of 1.3 as packaged with `scenariogeneration`."""
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
