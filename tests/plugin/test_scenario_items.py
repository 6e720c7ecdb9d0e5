"""The scenarios that ship, as pytest items with the real closed loop: selecting, failing, repeating, reporting."""

from __future__ import annotations

import shutil
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

# See conftest.py: what inner sessions would import must be here before them.
import ads.stack  # noqa: F401
import pytest_dvp.drive.preparation
import pytest_dvp.drive.sumo_traffic
import pytest_dvp.plugin.scenario_strategy  # noqa: F401
import reports.html  # noqa: F401
import vehicle.twin  # noqa: F401

DRIVEN = ("overtaking", "pedestrian_crossing")  # by two workers; `make test` drives all by itself
NAMES = (
    "amber_close", "cut_in", "cyclist", "emergency_stop", "follow", "junction", "merging", "occluded_child",
    "overtaking", "pedestrian_crossing", "red_ahead", "slope_stop", "stop_and_go", "traffic_light", "urban",
    "vehicle_from_behind",
)  # fmt: skip
BETWEEN = "scenarios/overtaking.xosc::dt-rw-surrogate"  # its gate file has gates between stages
SPOILT = "--dvp-set=P.DECISION_PC_d_min=0"  # keeps no distance to an occupied crossing


@pytest.fixture
def shipped(pytester: pytest.Pytester, scenarios_dir: Path) -> pytest.Pytester:
    """A project whose folder `scenarios` is a copy of ours; runs and caches stay in it."""
    pytester.makeini("[pytest]\naddopts = --strict-markers --strict-config -W error")
    shutil.copytree(scenarios_dir, pytester.path / "scenarios", ignore=shutil.ignore_patterns("*.py", "__pycache__"))
    return pytester


def collected(project: pytest.Pytester, *arguments: str) -> list[str]:
    result = project.runpytest_inprocess("--collect-only", "-q", *arguments, "scenarios")
    return [line for line in result.outlines if "::" in line]


def test_every_scenario_is_an_item_of_every_stage_and_catalogues_are_none(shipped: pytest.Pytester) -> None:
    expected = [f"scenarios/{name}.xosc::{stage}" for name in NAMES for stage in ("dt", "pe-surrogate", "rw-surrogate")]
    assert [each for each in collected(shipped) if each != BETWEEN] == expected
    assert BETWEEN in collected(shipped)
    assert not (shipped.path / "runs").exists()


@pytest.mark.parametrize(
    ("expression", "items"),
    [
        ("overtaking and dt", ["overtaking"]),
        ("dt and not urban", [name for name in NAMES if name != "urban"]),
        ("crossing and dt", ["pedestrian_crossing"]),
    ],
)
def test_k_selects_items(shipped: pytest.Pytester, expression: str, items: list[str]) -> None:
    found = [each for each in collected(shipped, "-k", expression) if each != BETWEEN]
    assert found == [f"scenarios/{name}.xosc::dt" for name in items]


@pytest.mark.nightly
def test_failures_of_two_workers_are_reported_and_repeated(
    shipped: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    files = [f"scenarios/{name}.xosc" for name in DRIVEN]
    spoilt = shipped.runpytest_subprocess("-m", "dt", "-n", "2", "--junitxml=out.xml", SPOILT, *files)
    spoilt.assert_outcomes(passed=1, failed=1)
    spoilt.stdout.re_match_lines_random(
        [
            r"FAILED scenarios/pedestrian_crossing\.xosc::dt - \w+ [\d.]+ \S+ > [\d.]+ at t=[\d.]+ s.*",
            r"replay the worst: dvp run scenarios/\w+\.xosc --seed 7 --set P\.DECISION_PC_d_min=0.*",
        ]
    )
    _junit_has_the_numbers(shipped.path / "out.xml")
    assert {folder.name[5:] for folder in (shipped.path / "runs").glob("0*")} == {f"{name}-dt" for name in DRIVEN}
    repeated = shipped.runpytest_inprocess("-m", "dt", "--lf", *files)
    repeated.assert_outcomes(passed=1)
    repeated.stdout.fnmatch_lines(["*rerun previous 1 failure*"])
    assert collected(shipped, "-m", "dt", "--lf") == [f"scenarios/{name}.xosc::dt" for name in NAMES]  # none is left


def _junit_has_the_numbers(file: Path) -> None:
    cases = {
        case.get("classname", "").rpartition(".")[0].split("/")[-1]: case for case in ET.parse(file).iter("testcase")
    }
    properties = {
        name.split(".")[-1]: {p.get("name"): p.get("value") or "" for p in case.iter("property")}
        for name, case in cases.items()
    }
    assert sorted(properties) == sorted(DRIVEN)
    failed = {name for name, found in properties.items() if found["verdict"] != "PASS"}
    assert failed == {"pedestrian_crossing"}
    assert float(properties["pedestrian_crossing"]["tet"]) > 0.0
    assert float(properties["overtaking"]["tet"]) <= 1.0
