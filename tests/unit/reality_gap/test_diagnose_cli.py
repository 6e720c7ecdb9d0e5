"""dvp diagnose as a user types it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from gap_logs import drive

from pytest_dvp.cli import main
from tests.truth.generate import write_csv

CAR = "[parameters]\nwheelbase = 2.5\ncg_to_front_axle = 1.2\nmass = 1200.0\n"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "car.toml").write_text(CAR)
    for name, gain in (("one.csv", 0.85), ("two.csv", 0.85), ("strong.csv", 1.0)):
        write_csv(tmp_path / name, dict(drive(30.0, drive_gain=gain, seed=len(name)).columns))
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
