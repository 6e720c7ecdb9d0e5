"""Values that a constraint of the scenario excludes, as it compares parameters: no drive, and no part of a share."""

from __future__ import annotations

import itertools
import sys
from pathlib import Path

import pytest

sys.path[:0] = [str(Path(__file__).parent)]
from planted import XOSC  # noqa: E402

from openscenario.findings import ScenarioError  # noqa: E402
from pytest_dvp.campaigns.campaign import Campaign  # noqa: E402
from pytest_dvp.campaigns.cases import choose, excluded_by  # noqa: E402
from pytest_dvp.campaigns.crew import LocalCrew  # noqa: E402
from pytest_dvp.campaigns.measured_probability import counted_probability  # noqa: E402
from pytest_dvp.campaigns.one_drive import Drive, drive  # noqa: E402
from pytest_dvp.campaigns.parameter_space import space_of  # noqa: E402
from pytest_dvp.campaigns.store import EXCLUDED, Row, Store  # noqa: E402
from pytest_dvp.campaigns.summary import summary, summary_text  # noqa: E402
from pytest_dvp.drive.run_spec import RunSpec  # noqa: E402

SLOWER = """<ParameterDeclaration name="ego" parameterType="double" value="0.5"/>
    <ParameterDeclaration name="other" parameterType="double" value="0.4"><ConstraintGroup>
      <ValueConstraint rule="lessThan" value="${$ego}"/>
    </ConstraintGroup></ParameterDeclaration>"""
AXIS = """<DeterministicSingleParameterDistribution parameterName="{}"><DistributionSet>{}</DistributionSet>
    </DeterministicSingleParameterDistribution>"""
EGO, OTHER = ("0.2", "0.6", "1.0"), ("0.1", "0.5", "0.9")
SLOWER_ONES = {(e, o) for e, o in itertools.product(EGO, OTHER) if float(o) < float(e)}


def distribution(folder: Path) -> Path:
    """Nine pairs of speeds, of which six have the other car slower, as the scenario wants."""
    (folder / "slower.xosc").write_text(XOSC.format(SLOWER))
    axes = "".join(
        AXIS.format(name, "".join(f'<Element value="{value}"/>' for value in values))
        for name, values in (("ego", EGO), ("other", OTHER))
    )
    path = folder / "speeds.xosc"
    path.write_text(
        '<OpenSCENARIO><FileHeader revMajor="1" revMinor="2" date="2026-01-01T00:00:00" description="" author=""/>'
        '<ParameterValueDistribution><ScenarioFile filepath="slower.xosc"/>'
        f"<Deterministic>{axes}</Deterministic></ParameterValueDistribution></OpenSCENARIO>"
    )
    return path


def test_the_cases_of_a_distribution_are_those_within_the_constraints(tmp_path: Path) -> None:
    said: list[str] = []
    chosen = choose(distribution(tmp_path), RunSpec(), say=said.append)
    assert {(case.values["ego"], case.values["other"]) for case in chosen} == SLOWER_ONES
    assert chosen.count == 9
    assert said == ["3 of 9 cases are left out: their values are outside the scenario's constraints"]


def test_what_is_wrong_otherwise_is_no_exclusion(tmp_path: Path) -> None:
    path = distribution(tmp_path).with_name("slower.xosc")
    assert "'other' is outside its constraints" in excluded_by(path, {"ego": "0.2", "other": "0.5"})
    assert excluded_by(path, {"ego": "0.6", "other": "0.5"}) == ""
    assert excluded_by(path, {"ego": "fast", "other": "0.5"}) == ""


def work(order: Drive) -> Row:
    """A drive of which only the constraints matter; every pair within them is a failure."""
    if excluded_by(Path(order.scenario), order.parameters):
        return drive(order)
    return Row(
        order.key, order.scenario, order.parameters, 7, "FAIL", {}, {}, False, 0.0, "", "", order.base, order.purpose,
        -1.0, "gap", "", "",
    )  # fmt: skip


def test_a_campaign_drives_none_of_them_and_counts_them_apart(tmp_path: Path) -> None:
    settings = RunSpec()
    with Store(tmp_path / "out", writes=True) as store:
        campaign = Campaign(space_of(distribution(tmp_path), settings), settings, store, LocalCrew(1, work))
        rows = campaign.rows_of([{"ego": e, "other": o} for e, o in itertools.product(EGO, OTHER)], "sample")
        excluded = [row for row in rows if row.verdict == EXCLUDED]
        assert len(excluded) == 3
        assert not any(row.failed or row.objective is not None for row in excluded)
        assert "6 failed, 3 outside the constraints" in campaign.progress.text()
        told = summary(store.rows())
    assert (told["runs"], told["excluded"], told["verdicts"]) == (6, 3, {"FAIL": 6})
    assert "3 more were not driven" in summary_text(told)
    found = counted_probability(rows)
    assert (found.runs, found.failures, found.estimate) == (6, 6, 1.0)


def test_a_drive_that_cannot_be_read_is_still_an_error(tmp_path: Path) -> None:
    path = distribution(tmp_path).with_name("slower.xosc")
    order = Drive("k", "b", "sample", str(path), {"ego": "fast"}, {"seed": 7, "rootdir": tmp_path}, str(tmp_path))
    with pytest.raises(ScenarioError, match="ego"):
        drive(order)
