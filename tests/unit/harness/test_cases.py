"""`dvp run` of a parameter distribution: every case, or a sample that says so; checked before anything runs."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from pytest_dvp.campaigns.cases import choose
from pytest_dvp.cli.command_line import main
from pytest_dvp.drive.run_spec import RunSpec

Write = Callable[..., Path]


@pytest.fixture
def speeds(scenario: Write, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Path]:
    """Writes a distribution of `ego_speed` from 2 to 6 m/s in steps of a width beside the small scenario."""
    good = scenario()
    monkeypatch.chdir(good.parent)
    (good.parent / "pytest.ini").write_text("[pytest]\n")

    def write(step: str) -> Path:
        path = good.with_name("speeds.xosc")
        path.write_text(
            '<OpenSCENARIO><FileHeader revMajor="1" revMinor="1" date="2026-01-01T00:00:00" description="" author=""/>'
            f'<ParameterValueDistribution><ScenarioFile filepath="{good.name}"/><Deterministic>'
            '<DeterministicSingleParameterDistribution parameterName="ego_speed">'
            f'<DistributionRange stepWidth="{step}"><Range lowerLimit="2" upperLimit="6"/></DistributionRange>'
            "</DeterministicSingleParameterDistribution></Deterministic></ParameterValueDistribution></OpenSCENARIO>"
        )
        return path

    return write


def test_every_case_is_run_with_its_value(speeds: Callable[[str], Path], capsys: pytest.CaptureFixture[str]) -> None:
    path = speeds("4")
    main(["run", str(path), "--duration", "0.2", "--no-report", "--json"])
    out, err = capsys.readouterr()
    assert [document["set"]["ego_speed"] for document in json.loads(out)] == ["2", "6"]
    assert "speeds.xosc: 2 of 2 cases of " in err
    assert "speeds.xosc[2-ego_speed=6]" in err


def test_thousands_of_cases_want_to_be_asked_for(
    speeds: Callable[[str], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", str(speeds("0.001"))]) == 2
    assert "4001 cases, more than the 1000 that run unasked; --cases 100 runs" in capsys.readouterr().err


def test_what_is_varied_cannot_be_set_as_well(
    speeds: Callable[[str], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", str(speeds("1")), "--set", "ego_speed=3"]) == 2
    assert capsys.readouterr().err == "--set ego_speed: speeds.xosc varies it\n"


def test_the_check_says_how_many_cases_a_distribution_has(
    speeds: Callable[[str], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", str(speeds("1"))]) == 0
    out, err = capsys.readouterr()
    assert out == ""
    assert "speeds.xosc: 5 cases of " in err


def test_more_cases_than_a_session_holds_are_refused(
    speeds: Callable[[str], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", str(speeds("0.0000001")), "--cases", "2000000"]) == 2
    assert capsys.readouterr().err == "--cases is 2000000, expected at most 1000000 of the 40000001 cases at once\n"


def test_names_of_cases_are_unique_and_cut(speeds: Callable[[str], Path]) -> None:
    chosen = choose(speeds("0.01"), RunSpec())
    names = [case.name for case in chosen]
    assert chosen.count == len(set(names)) == 401
    assert names[0] == "001-ego_speed=2"


def test_the_gates_beside_a_distribution_judge_its_cases(
    speeds: Callable[[str], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    """They stand before the scenario's own; --gates stands before both. The run folder tells the case."""
    path = speeds("4")
    path.with_name("x.gates.toml").write_text('[[gate]]\nmetric = "max_jerk"\nmax = 100\n')
    path.with_name("speeds.gates.toml").write_text('[[gate]]\nmetric = "collision"\nmax = 0\n')
    assert main(["run", str(path), "--duration", "0.2", "--json"]) == 0
    documents = json.loads(capsys.readouterr().out)
    assert [[verdict["metric"] for verdict in document["verdicts"]] for document in documents] == [["collision"]] * 2
    assert [Path(document["folder"]).name for document in documents] == ["0001-speeds-1-dt", "0002-speeds-2-dt"]
    assert "--gates speeds.gates.toml" in documents[0]["replay"]
    main(["run", str(path), "--duration", "0.2", "--json", "--no-report", "--gates", "x.gates.toml"])
    assert [v["metric"] for v in json.loads(capsys.readouterr().out)[0]["verdicts"]] == ["max_jerk"]


def test_the_check_holds_such_a_gate_file_against_the_scenario_that_is_varied(
    speeds: Callable[[str], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    path = speeds("4").with_name("speeds.gates.toml")
    path.write_text('[task]\ngoal = { road = "7", lane = -1, s = 20.0 }\n[[gate]]\nmetric = "collision"\nmax = 0\n')
    assert main(["check", str(path)]) == 1
    assert f"{path}:2: error dvp.task task.goal.road: no road 7 in x.xosc; allowed: 1" in capsys.readouterr().out


def test_the_check_of_a_distribution_reads_the_gates_of_the_scenario_that_is_varied(
    speeds: Callable[[str], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    speeds("4")
    Path("x.gates.toml").write_text('[[gate]]\nmetric = "tetx"\nmax = 1\n')
    assert main(["check", "speeds.xosc"]) == 1
    assert capsys.readouterr().out.startswith("x.gates.toml:2: error ")
    main(["check", "."])
    assert "speeds.xosc: refused: x.gates.toml:2: " in capsys.readouterr().err


def test_the_check_begins_with_a_case_that_the_constraints_allow(
    speeds: Callable[[str], Path], scenario: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    """The first, 2 m/s, is not faster than the other parameter and 2 more; 6 m/s is."""
    path = speeds("4")
    given = '<ParameterDeclaration name="ego_speed"'
    least = '<ParameterDeclaration name="least" parameterType="double" value="1"/>'
    scenario((given, least + given), ('"greaterOrEqual" value="2.0"', '"greaterThan" value="${$least + 2}"'))
    assert main(["check", str(path)]) == 0
    assert "2 cases of " in capsys.readouterr().err
