"""Scenarios of others, unmodified, with the reference stack as Ego: they run to a verdict under the default gates.

At their speeds (up to 30 m/s) the stack may fail a gate; it may not break, and the harness may not either.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pytest_dvp.drive.result import RunResult
from pytest_dvp.drive.run import run

CORPUS = "openscenario/corpus"
CUT_IN = "esmini__esmini/resources/xosc/cut-in.xosc"
PEDESTRIAN = "esmini__esmini/resources/xosc/pedestrian.xosc"
ALKS = (
    "openMSL__sl-3-1-osc-alks-scenarios/logical_scenarios/concrete_scenarios/"
    "alks_scenario_4_2_3_crossing_pedestrian_template.xosc"
)
NCAP = "vectorgrp__OSC-NCAP-scenarios/OpenSCENARIO/NCAP/AEB_VRU_2023/NCAP_AEB_VRU_CPNA_2023.xosc"
SCENARIOS = {"cut-in": CUT_IN, "pedestrian": PEDESTRIAN, "alks-crossing-pedestrian": ALKS, "ncap-cpna": NCAP}


@pytest.fixture(scope="module")
def drives(shared_dir: Path) -> dict[str, RunResult]:
    corpus = shared_dir / CORPUS
    # A scenario may name files of its own repository, above its own folder: that is what --library is for.
    return {
        name: run(corpus / file, library=[corpus / Path(file).parts[0]], rootdir=(corpus / file).parent)
        for name, file in SCENARIOS.items()
    }


@pytest.mark.parametrize("name", SCENARIOS)
def test_it_runs_to_a_verdict(name: str, drives: dict[str, RunResult]) -> None:
    result = drives[name]
    assert result.error is None
    assert result.status in ("PASS", "FAIL")
    assert {verdict.status for verdict in result.verdicts} <= {"PASS", "FAIL"}
    assert result.ending in ("stop", "collision")


@pytest.mark.parametrize("name", SCENARIOS)
def test_the_default_gates_apply(name: str, drives: dict[str, RunResult]) -> None:
    assert {verdict.metric for verdict in drives[name].verdicts} == {"collision", "road_departure", "scenario_ended"}


@pytest.mark.parametrize("name", SCENARIOS)
def test_the_stack_drives_the_ego_and_starts_as_the_file_says(name: str, drives: dict[str, RunResult]) -> None:
    log = drives[name].log
    assert log.meta["ego"]["name"] == "Ego"
    assert log["v"][0] == pytest.approx(log.meta["task"]["set_speed"], abs=1e-9)
    assert log["v"][0] > 3.0
    assert all(np.isfinite(log[name]).all() for name in ("x", "y", "yaw", "v", "steer"))
    assert log.paths  # it has planned
