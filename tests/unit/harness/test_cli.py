"""The command line: what goes to stdout, what to stderr, and which exit code."""

from __future__ import annotations

import dataclasses
import json
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from pytest_dvp.cli.command_line import main
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import LogEvent

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
    assert capsys.readouterr().err == f"nowhere.xosc: no such file; looked in {Path.cwd()}\n"


def test_check_imports_neither_numba_nor_pandas(scenario: Write) -> None:
    path = scenario()
    path.with_name("x.gates.toml").write_text('[[gate]]\nmetric = "collision"\nmax = 0\n')
    code = (
        "import sys; from pytest_dvp.cli.command_line import main; done = main(['check', '.']);"
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


def libraries(runs: str = "runs") -> list[Path]:
    return sorted(Path(runs).rglob("plotly-*.min.js"))


def test_reports_of_a_folder_share_the_library_that_draws(scenario: Write) -> None:
    for _ in range(2):
        assert main(["run", str(scenario())]) == 0
    (library,) = libraries()
    for folder in ("0001-x-dt", "0002-x-dt"):
        page = Path("runs", folder, "report.html")
        assert page.stat().st_size <= 400_000
        (address,) = re.findall(r'<script src="([^"]+)"', page.read_text())
        assert (page.parent / address).resolve() == library.resolve()


def test_a_single_file_needs_no_other(scenario: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    assert main(["run", str(scenario()), "--single-file"]) == 0
    assert libraries() == []
    assert "<script src" not in Path("runs/0001-x-dt/report.html").read_text()
    monkeypatch.setenv("DVP_SINGLE_FILE", "1")
    assert main(["run", str(scenario())]) == 0
    assert libraries() == []


def test_report_shares_the_library_only_among_runs_that_do(scenario: Write) -> None:
    def loads(page: str) -> bool:
        return "<script src" in Path(page).read_text()

    main(["run", str(scenario())])
    shutil.copytree("runs/0001-x-dt", "mailed/0001-x-dt")
    for words, page, shared in (
        (["runs/0001-x-dt"], "runs/0001-x-dt/report.html", True),
        (["runs/0001-x-dt", "--single-file"], "runs/0001-x-dt/report.html", False),
        (["runs/0001-x-dt", "--out", "runs/mine.html"], "runs/mine.html", False),
        (["mailed/0001-x-dt"], "mailed/0001-x-dt/report.html", False),
    ):
        assert main(["report", *words]) == 0
        assert loads(page) is shared
    assert len(libraries(".")) == 1


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
        (["run", "x.xosc", "--out", "x.html"], "did you mean --runs?"),
        (["run"], "X.xosc"),
        (["run", "nowhere.xosc"], "nowhere.xosc: no such scenario"),
        (["run", "x.xosc", "--stage", "dtt"], "did you mean 'dt'?"),
        (["run", "x.xosc", "--stage", "pe", "--vehicle", "tesla"], "--stage pe: unknown vehicle 'tesla'"),
        (["run", "x.xosc", "--stage", "rw", "--require-real"], "--stage rw: rw-surrogate ERROR: a real vehicle is req"),
        (["run", "x.xosc", "--ego", "Hero"], "--ego Hero: unknown entity 'Hero'"),
        (["run", "x.xosc", "--gate", "max_jrk"], "--gate: unknown metric 'max_jrk'; nearest is 'max_jerk'"),
        (["run", "x.xosc", "--seed", "1.5"], "--seed is '1.5', expected a whole number"),
        (["run", "x.xosc", "--duration", "1_0"], "--duration is '1_0', expected a number"),
        (["run", "x.xosc", "--seed", "\u0663"], "--seed is '\u0663', expected a whole number"),
        (["run", "x.xosc", "--runs", "x.xosc/runs"], "x.xosc is no folder"),
        (["run", "x.xosc", "--gates", ""], "--gates is empty, expected FILE"),
        (["run", ""], "no name, expected a scenario"),
        (["check", ""], "no name, expected a file or a folder"),
        (["doctor", ""], "no name, expected a log"),
        (["check", "x" * 300], "File name too long"),
        (["run", "x.xosc", "--model", "m.toml"], "m.toml"),
        (["run", "x.xosc", "--set", "ego_sped=3"], "did you mean 'ego_speed'?"),
        (["run", "x.xosc", "--set", "ego_speed=7"], "found 7; allowed: >= 2.0 and <= 6.0"),
        (
            ["run", "x.xosc", "--set", "ego_speed=abc"],
            "--set ego_speed: found 'abc', not a number; allowed: a number, >=",
        ),
        (["play", "x.xosc", "--set", "ego_speed=nan"], "--set ego_speed: found 'nan', not a finite number; allowed: "),
    ],
)
def test_a_wrong_option_is_one_line_and_exit_2(
    scenario: Write, words: list[str], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    scenario()
    assert main(words) == 2
    (line,) = [line for line in capsys.readouterr().err.splitlines() if not line.startswith("dvp run: x.xosc")]
    assert says in line
    assert not Path("runs").exists()


def test_with_json_an_error_is_a_document_too(scenario: Write, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(scenario(UNKNOWN)), "--json"]) == 1
    document = json.loads(capsys.readouterr().out)
    assert document["findings"][0]["line"] is not None


def test_run_says_that_the_default_limit_ended_it(scenario: Write, capsys: pytest.CaptureFixture[str]) -> None:
    never = ('value="3" rule="greaterThan"', 'value="900" rule="greaterThan"')
    assert main(["run", str(scenario(never)), "--no-report"]) == 1
    assert "ended by the default limit of 60 s (--duration)" in capsys.readouterr().out


def test_run_notes_what_is_bad_and_not_judged(scenario: Write, capsys: pytest.CaptureFixture[str]) -> None:
    scenario().with_name("x.gates.toml").write_text('[[gate]]\nmetric = "collision"\nmax = 0\n')
    assert main(["run", "x.xosc", "--duration", "0.5"]) == 0
    said = "not judged: scenario_ended 0 (no gate on it)"
    assert f"  !! {said}" in capsys.readouterr().out.splitlines()
    assert json.loads(Path("runs/0001-x-dt/result.json").read_text())["notes"] == [said]
    assert said in Path("runs/0001-x-dt/report.html").read_text()


def test_run_takes_several_scenarios_and_fails_if_one_does(scenario: Write, capsys: pytest.CaptureFixture[str]) -> None:
    scenario()
    scenario(('value="3" rule="greaterThan"', 'value="2" rule="greaterThan"'), name="y.xosc")
    scenario(UNKNOWN, name="z.xosc")
    assert main(["run", "x.xosc", "y.xosc", "--no-report"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines() if "[dt]" in line] == ["x.xosc", "y.xosc"]
    assert main(["run", "x.xosc", "z.xosc", "y.xosc", "--no-report", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert [(one["scenario"], one["status"]) for one in found] == [
        ("x.xosc", "PASS"), ("z.xosc", "ERROR"), ("y.xosc", "PASS"),
    ]  # fmt: skip
    assert found[1]["findings"][0]["line"] is not None


def test_run_by_one_gate_alone(scenario: Write, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["run", str(scenario()), "--no-report", "--duration", "0.5"]  # too short to end by itself
    assert main([*words, "--gate", "collision"]) == 0
    assert capsys.readouterr().out.strip().endswith("--duration 0.5 --gate collision")
    assert main([*words, "--gate", "scenario_ended"]) == 1


def test_all_metrics_are_in_the_result(scenario: Write, capsys: pytest.CaptureFixture[str]) -> None:
    main(["run", str(scenario()), "--json", "--no-report"])
    assert {"max_jerk", "max_yaw_rate", "lateral_rmse", "tet"} <= set(json.loads(capsys.readouterr().out)["metrics"])


def test_report_by_other_gates_rewrites_the_result_too(scenario: Write) -> None:
    main(["run", str(scenario()), "--seed", "3"])
    Path("other.toml").write_text('[[gate]]\nmetric = "max_jerk"\nmax = 0.0\n')
    assert main(["report", "runs/0001-x-dt", "--gates", "other.toml"]) == 1
    result = json.loads(Path("runs/0001-x-dt/result.json").read_text())
    assert (result["status"], result["seed"], [v["metric"] for v in result["verdicts"]]) == ("FAIL", 3, ["max_jerk"])
    assert result["replay"].endswith("--seed 3 --gates other.toml")
    assert "<title>FAIL" in Path("runs/0001-x-dt/report.html").read_text()


@pytest.mark.parametrize("what", ["wire", "dry run", "run"])
def test_no_gates_let_a_spoilt_run_pass(scenario: Write, what: str) -> None:
    """Faults on the wire, a car that was not armed, a stack that broke: judged again, and without its result.json."""
    main(["run", str(scenario())])
    folder = Path("runs/0001-x-dt")
    log = Log.load(folder)
    if what == "dry run":
        log.meta["vehicle"] = {"armed": False}
    told = {"wire": ("wire", "/vehicle/odom", "lost: 12 messages"), "run": ("fault", "stack", "it raised ValueError")}
    more = (LogEvent(0.2, *told[what]),) if what in told else ()
    dataclasses.replace(log, events=(*log.events, *more)).save(folder / "log.mcap")
    Path("other.toml").write_text('[[gate]]\nmetric = "collision"\nmax = 0\n')
    status = "ERROR" if what == "run" else "INCONCLUSIVE"
    if what == "run":
        (folder / "result.json").unlink()
    for words in (["--gates", "other.toml"], []):
        assert main(["report", str(folder), *words]) == 1
        result = json.loads((folder / "result.json").read_text())
        assert (result["status"], result["verdicts"][0]["gate"]) == (status, what)
        (folder / "result.json").unlink()


def test_report_of_a_log_without_its_result_says_that_the_default_gates_judged(
    scenario: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    path = scenario()
    path.with_suffix(".gates.toml").write_text('[[gate]]\nmetric = "max_jerk"\nmax = -1.0\n')
    assert main(["run", str(path)]) == 1
    Path("runs/0001-x-dt/result.json").unlink()
    said = "dvp report: PASS, judged by the default gates: there was no result.json beside the log, and no --gates FILE"
    for _ in range(2):  # the second time there is a result.json: that of the first one
        assert main(["report", "runs/0001-x-dt"]) == 0
        assert said in capsys.readouterr().err
    assert "judged by the default gates" in Path("runs/0001-x-dt/report.html").read_text()
    assert main(["report", "runs/0001-x-dt", "--gates", str(path.with_suffix(".gates.toml"))]) == 1
    assert capsys.readouterr().err == "dvp report: FAIL\n"
    assert "judged by the default gates" not in Path("runs/0001-x-dt/result.json").read_text()


def test_play_without_a_file_says_what_happened(scenario: Write, capsys: pytest.CaptureFixture[str]) -> None:
    path = scenario()
    assert main(["play", str(path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].endswith("s played, ended by the stop trigger")
    assert lines[1].strip().startswith("Ego: 15.0 m, up to 5.00 m/s")
    assert main(["play", str(path), "--csv", "-"]) == 0
    assert capsys.readouterr().out.splitlines()[0] == "time,entity,x,y,h,speed"


def test_metrics_are_listed_with_unit_direction_and_definition(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["metrics"]) == 0
    text = capsys.readouterr().out
    assert "max_ttc_inverse [1/s], bigger is worse\n    Greatest inverse of the time to collision" in text
    assert "goal_reached [-], smaller is worse; a miss is INCONCLUSIVE" in text
    assert main(["metrics", "max_jrk"]) == 2
    assert "nearest is 'max_jerk'" in capsys.readouterr().err


def test_run_says_which_options_it_does_not_use(scenario: Write, capsys: pytest.CaptureFixture[str]) -> None:
    path = scenario()
    Path("gates.toml").write_text('[[gate]]\nmetric = "collision"\nmax = 0\n')
    main(["run", str(path), "--no-report", "--duration", "0.1", "--fault", "drop@1+1", "--stage-gates", "gates.toml"])
    told = capsys.readouterr().err
    assert "dvp run: --fault drop@1+1 is not used: stage dt drives the twin; --stage pe or rw drives a car" in told
    assert "dvp run: --stage-gates gates.toml is not used: one stage, and no --stage-logs of another" in told


def test_a_damaged_log_of_another_stage_is_told_before_the_drive(
    scenario: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    path = scenario()
    Path("log.mcap").write_bytes(b"")
    assert main(["run", str(path), "--stage-logs", "log.mcap"]) == 1
    out, err = capsys.readouterr()
    assert (out, err) == ("", f"{Path('log.mcap').absolute()}: not an MCAP file\n")


def test_version_is_that_of_the_package(capsys: pytest.CaptureFixture[str]) -> None:
    from importlib.metadata import version

    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"dvp {version('pytest-dvp')}\n"
