"""dvp diagnose as a user types it."""

from __future__ import annotations

import dataclasses
import json
import shlex
from pathlib import Path

import pytest
from gap_logs import drive

from pytest_dvp.cli.command_line import main
from tests.truth.generate import write_csv

CAR = "[parameters]\nwheelbase = 2.5\ncg_to_front_axle = 1.2\nmass = 1200.0\n"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "car.toml").write_text(CAR)
    for name, gain, seed in (("one.csv", 0.85, 7), ("two.csv", 0.85, 8), ("strong.csv", 1.0, 9)):
        write_csv(tmp_path / name, dict(drive(30.0, drive_gain=gain, seed=seed).columns))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_an_answered_question_is_exit_code_0_and_one_document_on_stdout(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["diagnose", "one.csv", "--held-out", "two.csv", "--model", "car.toml", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["verdict"] == "NAMED"
    assert [effect["name"] for effect in found["effects"]] == ["drive_gain"]
    estimate = found["effects"][0]["parameters"]["g"]
    assert set(estimate) == {"value", "low", "high", "unit"}
    assert estimate["low"] <= 0.85 <= estimate["high"]


def test_nothing_missing_is_an_answer_too(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["diagnose", "strong.csv", "--model", "car.toml", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["verdict"], found["effects"]) == ("NOTHING_MISSING", [])


def test_what_loses_on_the_log_held_out_is_vetoed(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["diagnose", "one.csv", "--held-out", "strong.csv", "--model", "car.toml", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["effects"], found["vetoed"]) == ([], ["drive_gain"])


@pytest.mark.parametrize(
    "words", [["none.csv", "--model", "car.toml"], ["one.csv", "--model", "none.toml"], ["one.csv"]]
)
def test_a_missing_file_or_option_is_exit_code_2_and_one_line(
    here: Path, words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        code = main(["diagnose", *words])
    except SystemExit as told:  # argparse
        code = int(told.code or 0)
    assert code == 2
    shown = capsys.readouterr()
    assert not shown.out
    assert "Traceback" not in shown.err


OWN = (
    "from vehicle.model.effect import Key, effect\n\n\n"
    '@effect(name="flag_drag", slot="command", physics="a flag in the wind", equation="a = a_c - k v v",\n'
    '        source="test", parameters=(Key("k", "1/m", low=0.001, high=0.1, neutral=0.0, least=0.001),),\n'
    '        reveals="drive fast")\n'
    "def flag_drag(x, p, m):\n"
    "    x.accel = x.accel - p.k * x.vx * x.vx\n"
)
MAP = '[[signal]]\nname = "accel_cmd"\nfield = "wunsch"\nunit = "m/s^2"\n'


def test_the_next_command_runs_as_it_is_printed(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("one", "two"):  # without the mapping no column says what was asked for
        text = (here / f"{name}.csv").read_text().replace("accel_cmd [m/s^2]", "wunsch [m/s^2]", 1)
        (here / f"{name} of mine.csv").write_text(text)
    (here / "my map.toml").write_text(MAP)
    (here / "own.py").write_text(OWN)
    words = ["diagnose", "one of mine.csv", "--held-out", "two of mine.csv", "--model", "car.toml"]
    assert main([*words, "--map", "my map.toml", "--effects", "own.py"]) == 0
    (command,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("next: ")]
    again = shlex.split(command.removeprefix("next: "))
    assert again[0] == "dvp"
    assert main(again[1:]) == 0, capsys.readouterr().err
    assert "drive_gain" in (here / "car.extended.toml").read_text()


@pytest.mark.parametrize("words", [["diagnose"], ["plan", "--out", "drives"]])
def test_a_log_that_is_fitted_on_does_not_judge_itself_under_another_name(
    here: Path, words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "copy.csv").write_text((here / "one.csv").read_text() + "\n")
    for judge, said in (("copy.csv", "the same drive as one.csv"), ("one.csv@5:", "it is fitted on as well")):
        assert main([*words, "one.csv", "--held-out", judge, "--model", "car.toml"]) == 2
        told = capsys.readouterr().err
        assert told.startswith(f"--held-out {judge}: {said}")
        assert told.count("\n") == 1


@pytest.mark.nightly
def test_of_a_run_of_the_twin_it_is_said_that_it_logs_the_true_motion(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    dataclasses.replace(drive(30.0, seed=7), meta={"stage": "dt"}).save("twin.mcap")
    assert main(["diagnose", "twin.mcap", "--model", "car.toml"]) == 0
    assert capsys.readouterr().out.startswith("twin.mcap: run of the twin, which logs the true motion: ")
    assert main(["diagnose", "strong.csv", "--model", "car.toml"]) == 0
    assert "true motion" not in capsys.readouterr().out


def test_a_twin_that_saw_otherwise_than_the_model_is_refused(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What comes on top of its detections would be no value of this model."""
    text = (here / "car.toml").read_text()
    seeing = text + '[[effect]]\nname = "detection_offset"\n[effect.parameters.x]\nvalue = 0.5\nunit = "m"\n'
    meta = {"scenario": "a.xosc", "stage": "dt", "model": {"toml": seeing}}
    dataclasses.replace(drive(30.0, seed=7), meta=meta).save("twin.mcap")
    dataclasses.replace(drive(30.0, seed=8), meta={**meta, "stage": "rw-surrogate"}).save("car.mcap")
    for command in (["diagnose", "car.mcap"], ["extend", "--fit", "car.mcap", "--out", "new.toml"]):
        assert main([*command, "--model", "car.toml", "--twin", "twin.mcap"]) == 2
        told = capsys.readouterr().err.splitlines()[-1]
        assert "driven with detection_offset (x = 0.5, y = 0), and car.toml has none; drive a.xosc" in told
    (here / "seeing.toml").write_text(seeing)
    assert main(["diagnose", "car.mcap", "--model", "seeing.toml", "--twin", "twin.mcap"]) == 0
