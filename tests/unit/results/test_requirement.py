"""The requirement that a gate verifies, from its file to JUnit and the report."""

from __future__ import annotations

from pathlib import Path

import pytest
from results_logs import drive_straight

from pytest_dvp.plugin.fixtures import properties
from pytest_dvp.verdicts.judging import check_gates, judge, read_gates
from reports.verdicts import rows


def gate_file(tmp_path: Path, requirement: str) -> Path:
    path = tmp_path / "a.gates.toml"
    path.write_text(f'[[gate]]\nmetric = "collision"\nmax = 0\nrequirement = {requirement}\n')
    return path


def test_requirement_reaches_junit_and_the_report(tmp_path: Path) -> None:
    verdicts = judge(read_gates(gate_file(tmp_path, '"SR-12"')), drive_straight(1.0))
    plain = [verdict.as_dict() for verdict in verdicts]
    told = properties({"status": "PASS", "metrics": {}, "verdicts": plain, "folder": str(tmp_path)})
    assert ("collision.requirement", "SR-12") in told
    assert [row.requirement for row in rows(plain)] == ["SR-12"]


@pytest.mark.parametrize("wrong", ["12", '""', '"a\\nb"', '["SR-12"]'])
def test_a_wrong_requirement_is_a_finding_with_its_line(tmp_path: Path, wrong: str) -> None:
    (finding,) = check_gates(gate_file(tmp_path, wrong))
    assert (finding.code, finding.line) == ("dvp.gates.requirement", 4)
