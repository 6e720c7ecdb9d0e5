"""What `dvp check` says of a model file that cannot be read."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pytest_dvp.cli.command_line import main

CAR = """[model]
base = "kinematic_bicycle"
[parameters]
wheelbase = 2.7
mass = 1500.0
[[effect]]
name = "gear_changes"
[effect.parameters]
cut = 3
"""


def test_a_finding_says_file_line_and_key_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "car.toml"
    path.write_text(CAR)
    assert main(["check", str(path)]) != 0
    first = capsys.readouterr().out.splitlines()[0]
    assert first == (f"{path}:9: error model.invalid gear_changes.cut: value not allowed (found 3; allowed: 0 to 1)")


def test_the_same_stands_in_the_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "car.toml"
    path.write_text(CAR)
    main(["check", str(path), "--json"])
    text = capsys.readouterr().out
    assert '"message": "value not allowed (found 3; allowed: 0 to 1)"' in json.dumps(json.loads(text))
