"""A parameter distribution as items: one a case, none built for the count, and too many only when asked for."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.plugin.conftest import HEAD


def write_distribution(folder: Path, inside: str, scenario: str = "good.xosc") -> None:
    (folder / "speeds.xosc").write_text(
        f"<OpenSCENARIO>{HEAD}<ParameterValueDistribution>\n"
        f'<ScenarioFile filepath="{scenario}"/>\n<Deterministic>\n'
        f'<DeterministicSingleParameterDistribution parameterName="ego_speed">{inside}'
        "</DeterministicSingleParameterDistribution></Deterministic></ParameterValueDistribution></OpenSCENARIO>"
    )


def stepped(step: str) -> str:
    return f'<DistributionRange stepWidth="{step}"><Range lowerLimit="2" upperLimit="6"/></DistributionRange>'


@pytest.fixture
def varied(project: pytest.Pytester) -> pytest.Pytester:
    """The project with a distribution of five speeds."""
    write_distribution(project.path, stepped("1"))
    return project


def test_every_case_is_an_item_that_carries_its_values(varied: pytest.Pytester) -> None:
    result = varied.runpytest_inprocess("--collect-only", "-q", "speeds.xosc")
    assert [line for line in result.outlines if "::" in line] == [
        f"speeds.xosc::dt[{number}-ego_speed={number + 1}]" for number in range(1, 6)
    ]
    result.stdout.fnmatch_lines(["dvp: *5 of 5 cases of speeds.xosc*"])


def test_the_cases_run_and_one_can_be_named(varied: pytest.Pytester) -> None:
    varied.runpytest_inprocess("speeds.xosc").assert_outcomes(passed=5)
    varied.runpytest_inprocess("speeds.xosc::dt[3-ego_speed=4]").assert_outcomes(passed=1)


def test_a_sample_is_said_to_be_one_and_repeats(varied: pytest.Pytester) -> None:
    first, again = (
        varied.runpytest_inprocess("--collect-only", "-q", "speeds.xosc", "--dvp-cases", "2") for _ in range(2)
    )
    first.stdout.fnmatch_lines(["dvp: *2 of 5 cases of speeds.xosc*"])
    items = [[line for line in result.outlines if "::" in line] for result in (first, again)]
    assert len(items[0]) == 2
    assert items[0] == items[1]


def test_four_million_cases_are_one_line_that_says_how_to_take_a_sample(varied: pytest.Pytester) -> None:
    write_distribution(varied.path, stepped("0.000001"))
    result = varied.runpytest_inprocess("speeds.xosc")
    result.stdout.fnmatch_lines(["*speeds.xosc: 4000001 cases*--dvp-cases 100*"])
    assert "Traceback" not in result.stdout.str()
    sample = varied.runpytest_inprocess("speeds.xosc", "--dvp-cases", "3")
    sample.assert_outcomes(passed=3)
    sample.stdout.fnmatch_lines(["dvp: *3 of 4000001 cases*"])


def test_a_slip_is_a_collection_error_with_its_place(varied: pytest.Pytester) -> None:
    write_distribution(varied.path, stepped("0"))
    result = varied.runpytest_inprocess("speeds.xosc")
    result.stdout.re_match_lines([r".*speeds\.xosc:4: error dist\.step_not_positive .*"])


def test_a_broken_scenario_shows_once_and_not_with_each_case(varied: pytest.Pytester) -> None:
    good = (varied.path / "good.xosc").read_text()
    (varied.path / "good.xosc").write_text(good.replace('laneId="-1"', 'laneId="-9"'))
    result = varied.runpytest_inprocess("speeds.xosc")
    result.assert_outcomes(errors=1)
    assert len(re.findall(r"good\.xosc:\d+: error", result.stdout.str())) == 1


def test_a_value_set_from_outside_may_not_fix_what_is_varied(varied: pytest.Pytester) -> None:
    result = varied.runpytest_inprocess("speeds.xosc", "--dvp-set", "ego_speed=3")
    result.stdout.fnmatch_lines(["*--dvp-set ego_speed: speeds.xosc varies it*"])


def test_cases_of_an_unknown_number_are_refused(varied: pytest.Pytester) -> None:
    result = varied.runpytest_inprocess("speeds.xosc", "--dvp-cases", "0")
    result.stderr.fnmatch_lines(["*--dvp-cases is 0, expected a whole number >= 1*"])


def test_no_case_runs_on_a_real_vehicle(varied: pytest.Pytester) -> None:
    result = varied.runpytest_inprocess("--collect-only", "-q", "speeds.xosc", "-m", "pe or rw")
    assert [line for line in result.outlines if "::" in line] == []
