"""Options of compare, diagnose, plan and extend that mean nothing: one line before any log is fitted, exit code 2."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pytest_dvp.cli.command_line import main

CSV = "t [s],accel_cmd [m/s^2],steer_cmd [rad],x [m],y [m],yaw [rad],v [m/s]\n"
LOG = CSV + "".join(f"{k / 50},0,0,{k / 10},0,0,5\n" for k in range(200))
MODEL = '[model]\nbase = "kinematic_bicycle"\n[parameters]\nwheelbase = 2.5\n'


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.csv").write_text(LOG)
    Path("m.toml").write_text(MODEL)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["compare", "a.csv", "--channels", ""], "--channels: unknown channel ''"),
        (["diagnose", "a.csv", "a.csv"], "a.csv: named 2 times: name it once"),
        (["diagnose", "a.csv", "--max-steer", "30"], "--max-steer is 30, expected less than 1.57 [rad at the road wh"),
        (["diagnose", "a.csv", "--max-speed", "1_0"], "--max-speed is 1_0, expected more than 0 [m/s]"),
        (["diagnose", "a.csv", "--plan", "a.csv/plan"], "--plan a.csv/plan: "),
        (["diagnose", "a.csv", "--plan", ""], "--plan: no name, expected a folder"),
        (["plan", "a.csv", "--out", "a.csv"], "a.csv is no folder"),
        (["plan", "a.csv", "--out", ""], "--out: no name, expected a folder"),
        (["plan", "--excite", ","], "--excite: no name in it"),
        (["plan", "--excite", "steer_delay", "--only", ""], "--only: no name in it"),
    ],
)
def test_it_is_one_line(words: list[str], says: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*words, "--model", "m.toml"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert says in line
    assert sorted(path.name for path in Path().iterdir()) == ["a.csv", "m.toml"]


@pytest.mark.parametrize("coding", ["utf-8-sig", "utf-16"])
def test_a_diagnosis_that_a_shell_of_windows_wrote_is_read(coding: str, capsys: pytest.CaptureFixture[str]) -> None:
    document = {"verdict": "NAMED", "effects": [{"name": "steer_dely"}]}
    Path("d.json").write_bytes(json.dumps(document).encode(coding))
    assert main(["extend", "--model", "m.toml", "--fit", "a.csv", "--out", "o.toml", "--from", "d.json"]) == 1
    assert capsys.readouterr().err == "d.json: unknown effect 'steer_dely', did you mean 'steer_delay'?" + (
        " (dvp effects lists them)\n"
    )


def test_an_action_that_is_none_is_not_taken_for_another(capsys: pytest.CaptureFixture[str]) -> None:
    Path("d.json").write_text(json.dumps({"effects": [{"name": "steer_delay", "action": "remve"}]}))
    assert main(["extend", "--model", "m.toml", "--fit", "a.csv", "--out", "o.toml", "--from", "d.json"]) == 1
    assert capsys.readouterr().err == "d.json: steer_delay: action is 'remve', allowed: add, change, remove\n"
