"""dvp tune and dvp iterate: one document, one line for a slip."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pytest_dvp.cli import main

STUDY = """[study]
budget = 1

[[scenario]]
file = "follow.xosc"

[parameters]
"P.LQR_q11" = [20, 30]
"""


@pytest.fixture
def study(tmp_path: Path) -> str:
    file = tmp_path / "study.toml"
    file.write_text(STUDY, encoding="utf-8")
    return str(file)


def test_json_is_one_document_and_the_folder_can_be_read(
    study: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folders = ["--out", str(tmp_path / "out"), "--cache", str(tmp_path / "cache")]
    main(["tune", study, "--json", "--jobs", "1", *folders])
    document = json.loads(capsys.readouterr().out)
    assert document["best"]["point"] == {"P.LQR_q11": 30.0}
    assert document["simulations"] == 1
    assert document["ended"] == "budget"
    assert json.loads((tmp_path / "out" / "result.json").read_text(encoding="utf-8")) == document
    assert (tmp_path / "out" / "best.txt").read_text(encoding="utf-8") == "--set P.LQR_q11=30\n"
    assert (
        (tmp_path / "out" / "trials.csv").read_text(encoding="utf-8").startswith("trial,simulations,score,broken,P.LQR")
    )


@pytest.mark.parametrize(
    ("words", "code", "told"),
    [
        (["tune", "nothing.toml"], 2, "nothing.toml: no such study"),
        (["iterate", "nothing.toml"], 2, "nothing.toml: no such plan"),
        (["tune", "{study}", "--search", "gradient"], 2, "unknown search 'gradient'"),
        (["tune", "{study}", "--budget", "0"], 2, "--budget is 0"),
        (["tune", "{study}", "--jobs", "0"], 2, "--jobs is 0"),
        (["iterate", "{study}"], 1, "unknown table 'study'"),
    ],
)
def test_a_slip_is_one_line(
    study: str, words: list[str], code: int, told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([word.format(study=study) for word in words]) == code
    shown = capsys.readouterr()
    assert told in shown.err
    assert len(shown.err.strip().splitlines()) == 1
    assert shown.out == ""
