"""The twins of the paper's cars: what an extension finds idle is left out, and another refusal is told."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

paper_twins = pytest.importorskip("scripts.paper_twins", reason="scripts/ is not on the path")

LOGS = ["--fit", "a.csv"]


def test_what_an_extension_finds_idle_is_left_out(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    asked: list[Sequence[str]] = []

    def dvp(words: list[str]) -> str:
        names = words[words.index("--add") + 1 : words.index("--fit")]
        asked.append(names)
        if "roll" in names:
            print("dvp extend: t.toml is not written: roll explains too little beside mass", file=sys.stderr)
        else:
            Path(words[-1]).write_text("", encoding="utf-8")
        return ""

    monkeypatch.setattr(paper_twins, "_dvp", dvp)
    paper_twins._extend(Path("bare.toml"), ["mass", "roll"], LOGS, tmp_path / "t.toml")
    assert asked == [["mass", "roll"], ["mass"]]


def test_another_refusal_is_told_and_no_twin_of_before_stays(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    twin = tmp_path / "t.toml"
    twin.write_text("of an earlier run", encoding="utf-8")
    monkeypatch.setattr(paper_twins, "_dvp", lambda words: print("mass loses on the data held out", file=sys.stderr))
    with pytest.raises(SystemExit, match="mass loses on the data held out"):
        paper_twins._extend(Path("bare.toml"), ["mass"], LOGS, twin)
    assert not twin.exists()
    paper_twins._extend(Path("bare.toml"), [], LOGS, twin)
