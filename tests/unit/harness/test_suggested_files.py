"""A file that is not there: only one of the kind that was asked for is suggested."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_dvp.cli.command_line import main

MODEL = "[model]\nbase = 'dynamic_bicycle'\n"
GATES = "[[gate]]\nmetric = 'collision'\nmax = 0\n"


@pytest.mark.parametrize(
    ("there", "option", "meant"),
    [
        ({"town.toml": MODEL, "tour.toml": GATES}, "--gates", "tour.toml"),  # both are as near
        ({"town.toml": MODEL, "tour.toml": GATES}, "--model", "town.toml"),
        ({"town.toml": MODEL}, "--gates", None),
        ({"tour.toml": GATES}, "--model", None),
    ],
)
def test_gates_are_no_model_and_a_model_is_no_gates(
    there: dict[str, str], option: str, meant: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    for name, text in {"x.xosc": "<OpenSCENARIO/>", **there}.items():
        (tmp_path / name).write_text(text)
    assert main(["run", "x.xosc", option, "towr.toml"]) == 2
    hint = "" if meant is None else f"; did you mean {meant!r}?"
    said = f"{option}: no file {tmp_path / 'towr.toml'}; looked in {tmp_path}{hint}\n"
    assert capsys.readouterr().err.endswith(said)
