"""The command line: what goes to stdout, what to stderr, and which exit code."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from pytest_dvp.cli import main

Write = Callable[..., Path]
UNKNOWN = ('<Private entityRef="Ego">', '<Private entityRef="Egon">')


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    monkeypatch.chdir(tmp_path)


def table(name: str) -> list[list[str]]:
    return [line.split(",") for line in Path(name).read_text().splitlines()]


def test_check_of_a_good_file_is_silent_on_stdout(scenario: Write, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(scenario())]) == 0
    assert capsys.readouterr().out == ""


def test_check_finds_everything_in_a_folder(scenario: Write, capsys: pytest.CaptureFixture[str]) -> None:
    folder = scenario(UNKNOWN).parent
    (folder / "x.gates.toml").write_text('[[gate]]\nmetric = "tetx"\nmax = 1\n')
    (folder / "broken.xodr").write_text("<OpenDRIVE>")
    assert main(["check", ".", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)["findings"]
    assert {Path(finding["file"]).name for finding in found} == {"x.xosc", "x.gates.toml", "broken.xodr"}
    assert set(found[0]) == {"code", "severity", "file", "line", "element", "message"}


def test_check_of_a_missing_file_is_a_usage_error(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "nowhere.xosc"]) == 2
    assert capsys.readouterr().err == "nowhere.xosc: no such file\n"


def test_check_imports_neither_numba_nor_pandas(scenario: Write) -> None:
    path = scenario()
    path.with_name("x.gates.toml").write_text('[[gate]]\nmetric = "collision"\nmax = 0\n')
    code = (
        "import sys; from pytest_dvp.cli import main; done = main(['check', '.']);"
        "assert not {'numba', 'pandas'} & set(sys.modules), 'heavy'; sys.exit(done)"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=path.parent, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "")


def test_play_writes_rows_every_50_ms_in_file_order(scenario: Write) -> None:
    assert main(["play", str(scenario()), "--csv", "rows.csv", "--events", "events.csv"]) == 0
    rows = table("rows.csv")
    assert rows[:3] == [
        ["time", "entity", "x", "y", "h", "speed"],
        ["0.000000", "Ego", "10.000000", "-1.750000", "0.000000", "5.000000"],
        ["0.050000", "Ego", "10.250000", "-1.750000", "0.000000", "5.000000"],
    ]
    assert rows[-1][0] == "3.000000"
    events = table("events.csv")
    assert events[0] == ["time", "element", "from", "transition", "to"]
    assert events[-1][1:] == ["storyBoard", "runningState", "stopTransition", "completeState"]


def test_play_ends_after_the_duration(scenario: Write) -> None:
    assert main(["play", str(scenario()), "--csv", "rows.csv", "--duration", "1"]) == 0
    assert table("rows.csv")[-1][0] == "1.000000"


@pytest.mark.parametrize("dt", ["0", "nan", "0.03", "1", "x"])
def test_play_refuses_a_step_that_does_not_divide_50_ms(
    scenario: Write, dt: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["play", str(scenario()), "--dt", dt]) == 2
    assert capsys.readouterr().err.startswith(f"--dt is {dt}, expected a step")


def test_play_leaves_no_file_behind_when_the_scenario_is_broken(scenario: Write) -> None:
    assert main(["play", str(scenario(UNKNOWN)), "--csv", "rows.csv"]) == 1
    assert not Path("rows.csv").exists()


def test_run_prints_one_json_document(scenario: Write, capsys: pytest.CaptureFixture[str]) -> None:
    code = main(["run", str(scenario()), "--json", "--no-report"])
    result = json.loads(capsys.readouterr().out)
    assert code == 0
    assert (result["status"], result["seed"], result["folder"]) == ("PASS", 7, None)
    assert {verdict["metric"] for verdict in result["verdicts"]} == {"collision", "road_departure", "scenario_ended"}


def test_run_leaves_a_numbered_folder(scenario: Write, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(scenario())]) == 0
    folder = Path("runs/0001-x-dt")
    assert {file.name for file in folder.iterdir()} == {"log.mcap", "result.json", "report.html"}
    assert f"report: {folder}/report.html" in capsys.readouterr().out


def test_run_exits_with_1_for_a_verdict_that_is_not_pass(scenario: Write) -> None:
    assert main(["run", str(scenario()), "--duration", "0.5", "--no-report"]) == 1


def test_run_says_how_to_do_it_again(scenario: Write, capsys: pytest.CaptureFixture[str]) -> None:
    scenario()
    main(["run", "x.xosc", "--set", "ego_speed=3.5", "--set", "P.LQR_q11=20", "--seed", "3", "--no-report"])
    replay = capsys.readouterr().out.strip().splitlines()[-1]
    assert replay == "  replay: dvp run x.xosc --seed 3 --set P.LQR_q11=20 --set ego_speed=3.5"


def test_settings_come_from_the_environment_too(
    scenario: Write, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("DVP_SEED", "21")
    main(["run", str(scenario()), "--json", "--no-report"])
    assert json.loads(capsys.readouterr().out)["seed"] == 21


def test_report_is_made_again_from_the_log(scenario: Write, capsys: pytest.CaptureFixture[str]) -> None:
    main(["run", str(scenario())])
    Path("runs/0001-x-dt/report.html").unlink()
    assert main(["report", "runs/0001-x-dt"]) == 0
    assert Path("runs/0001-x-dt/report.html").stat().st_size > 1000


def test_report_of_a_damaged_log_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    Path("log.mcap").write_bytes(b"no log")
    assert main(["report", "log.mcap"]) == 1
    assert len(capsys.readouterr().err.strip().splitlines()) == 1


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["rum"], "did you mean 'run'?"),
        (["run", "x.xosc", "--sed", "3"], "did you mean --seed?"),
        (["run"], "X.xosc"),
        (["run", "nowhere.xosc"], "nowhere.xosc: no such scenario"),
        (["run", "x.xosc", "--stage", "dtt"], "did you mean 'dt'?"),
        (["run", "x.xosc", "--seed", "1.5"], "--seed is '1.5', expected a whole number"),
        (["run", "x.xosc", "--model", "m.toml"], "m.toml"),
        (["run", "x.xosc", "--set", "ego_sped=3"], "did you mean 'ego_speed'?"),
        (["run", "x.xosc", "--set", "ego_speed=7"], "found 7; allowed: >= 2.0 and <= 6.0"),
    ],
)
def test_a_wrong_option_is_one_line_and_exit_2(
    scenario: Write, words: list[str], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    scenario()
    assert main(words) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert says in line
    assert not Path("runs").exists()


def test_with_json_an_error_is_a_document_too(scenario: Write, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(scenario(UNKNOWN)), "--json"]) == 1
    document = json.loads(capsys.readouterr().out)
    assert document["findings"][0]["line"] is not None
