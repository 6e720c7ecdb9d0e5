"""Cars that somebody else has made: the folder is read before anything is asked, and answers are not asked twice."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from benchmarks.foreign_cars.given import main

CASE = {"car": "coupe", "noise": "mid", "names": [], "truth": {}, "detectable": False}


def folder_of(place: Path, case: dict[str, object]) -> Path:
    for name in ("cars/coupe/sheet.toml", "cars/coupe/learn_rich.csv", "cars/coupe/learn_town.csv",
                 "cases/c1/rich.csv", "cases/c1/town.csv"):  # fmt: skip
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        (place / name).write_text("", encoding="utf-8")
    (place / "truth.json").write_text(json.dumps({"c1": case}), encoding="utf-8")
    return place


def said(place: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setattr(sys, "argv", ["given", str(place), "--json", str(place / "answers.jsonl")])
    with pytest.raises(SystemExit) as ended:
        main()
    return str(ended.value)


def test_what_is_missing_is_one_line_with_its_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert said(tmp_path, monkeypatch).startswith(f"{tmp_path}/truth.json: cannot be read as JSON: ")
    folder_of(tmp_path, {"car": "coupe", "names": []})
    assert said(tmp_path, monkeypatch).startswith(f"{tmp_path}/truth.json: case c1 lacks detectable, truth; ")
    folder_of(tmp_path, CASE)
    (tmp_path / "cars/coupe/learn_town.csv").unlink()
    text = said(tmp_path, monkeypatch)
    assert (
        text
        == f"{tmp_path}/cars/coupe/learn_town.csv: there is no such file, which case c1 of {tmp_path}/truth.json needs"
    )


@pytest.mark.parametrize("part", ["1", "a/b", "2/2", "0/0", "-1/2"])
def test_a_part_that_is_none_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, part: str) -> None:
    monkeypatch.setattr(sys, "argv", ["given", str(tmp_path), "--json", "x.jsonl", f"--part={part}"])
    with pytest.raises(SystemExit) as told:
        main()
    assert str(told.value) == f"--part: must be K/N with K from 0 to N - 1 (found {part!r})"


def test_answers_that_are_there_are_counted_and_not_asked_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The logs are empty: whatever would be asked would be refused."""
    folder_of(tmp_path, CASE)
    change = {"before": 9.0, "after": 1.0}
    bare = {"key": "bare/coupe", "category": "bare", "car": "coupe", "names": [], "truth": {}, "verdict": "PARTIAL",
            "effects": [], "chi2_per_n": {"fit": change, "held_out": change}, "cpu": 7.0}  # fmt: skip
    null = {"key": "c1", "category": "null", **CASE, "verdict": "NOTHING_MISSING", "effects": [], "cpu": 2.0}
    text = "".join(json.dumps(line) + "\n" for line in (bare, null))
    (tmp_path / "answers.jsonl").write_text(text, encoding="utf-8")
    monkeypatch.setattr(sys, "argv", ["given", str(tmp_path), "--json", str(tmp_path / "answers.jsonl")])
    assert main() == 0
    printed = capsys.readouterr().out
    assert "| nothing new: NOTHING_MISSING | 1.000 (1/1) |" in printed
    assert "| coupe | 9 | 1 | 9 | 1 | 7 s |" in printed
    assert (tmp_path / "answers.jsonl").read_text(encoding="utf-8") == text
