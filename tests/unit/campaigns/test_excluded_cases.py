"""Values that a constraint of the scenario excludes, as it compares parameters: no drive, and no part of a share."""

from __future__ import annotations

import itertools
import sys
from pathlib import Path

import pytest
from lxml import etree

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
from pytest_dvp.cli.command_line import main  # noqa: E402
from pytest_dvp.drive.assignments import Assignments  # noqa: E402
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
    assert len(said) == 1
    assert said[0].startswith("3 of 9 cases are left out, outside the scenario's constraints; the first: ")
    assert "'other' is outside its constraints" in said[0]


def test_what_is_set_for_all_cases_is_asked_with_each(tmp_path: Path) -> None:
    """An ego of 0.2 for all, and only the other car's speed in the file: one of its three values is below."""
    path = distribution(tmp_path)
    root = etree.parse(path)
    for each in root.iterfind(".//DeterministicSingleParameterDistribution[@parameterName='ego']"):
        each.getparent().remove(each)
    root.write(path)
    chosen = choose(path, RunSpec(set=Assignments(scenario={"ego": "0.2"})))
    assert [case.values["other"] for case in chosen] == ["0.1"]
    assert {case.values["other"] for case in choose(path, RunSpec(set=Assignments(scenario={"ego": "1.0"})))} == set(
        OTHER
    )


def test_a_parameter_of_another_scenario_excludes_nothing_and_hides_no_exclusion(tmp_path: Path) -> None:
    scenario = distribution(tmp_path).with_name("slower.xosc")
    why = excluded_by(scenario, {"ego": "0.2", "other": "0.9"})
    assert why
    assert excluded_by(scenario, {"ego": "0.2", "other": "0.9", "only_elsewhere": "1"}) == why


def test_a_value_set_for_all_drives_that_is_excluded_itself_is_an_error(tmp_path: Path) -> None:
    path = distribution(tmp_path).with_name("slower.xosc")
    options = {"seed": 7, "rootdir": tmp_path, "parameters": {"other": "0.9"}}
    order = Drive("k", "b", "sample", str(path), {"ego": "0.2"}, options, str(tmp_path))
    with pytest.raises(ScenarioError, match="other"):
        drive(order)


def only_faster(folder: Path) -> Path:
    """A distribution of which every case is excluded."""
    path = distribution(folder)
    path.write_text(path.read_text().replace('value="0.1"', 'value="1.5"').replace('value="0.5"', 'value="1.6"')
                    .replace('value="0.9"', 'value="1.7"'))  # fmt: skip
    return path


def test_a_campaign_of_which_nothing_can_be_driven_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["campaign", str(only_faster(tmp_path)), "--out", str(tmp_path / "out"), "--jobs", "1"]) == 2
    told = capsys.readouterr().err
    assert "nothing was driven: all 9 cases are outside the scenario's constraints; the first: " in told


def test_a_session_of_which_nothing_can_be_driven_says_so(pytester: pytest.Pytester) -> None:
    path = only_faster(pytester.path)
    done = pytester.runpytest_inprocess(str(path))
    done.stdout.fnmatch_lines(["*nothing to drive: 9 of 9 cases are left out*the first: *'other' is outside*"])


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
