"""A vehicle model with an effect of the user's own, driven: `dvp run --effects`, and what a wrong file says."""

from __future__ import annotations

import json
import shlex
from collections.abc import Callable
from pathlib import Path

import pytest

from pytest_dvp.cli.command_line import main
from scenarios import path as shipped

Write = Callable[..., Path]

MINE = """
from vehicle.model.effect import Key, effect

@effect(
    name="anchor", slot="force", physics="an anchor that was not weighed", equation="a = -c", source="none",
    parameters=(Key("c", "m/s^2", 0.1, 20.0, neutral=0.0, least=0.05, minimum=0.0, meaning="hold"),),
    reveals="driving off",
)
def anchor(x, p, m):
    x.resistance += p.c * x.mass_ref
"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    (tmp_path / "mine.py").write_text(MINE)
    car = shipped("models/tabby_evo.toml").read_text()
    (tmp_path / "car.toml").write_text(car + '\n[[effect]]\nname = "anchor"\nparameters = { c = 9.0 }\n')
    monkeypatch.chdir(tmp_path)


def test_run_drives_a_model_with_an_effect_of_the_users_own(
    scenario: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["run", str(scenario()), "--model", "car.toml", "--effects", "mine.py", "--duration", "3", "--json"]
    main(words)
    result = json.loads(capsys.readouterr().out)
    assert shlex.split(result["replay"])[-4:] == ["--effects", "mine.py", "--duration", "3"]
    from pytest_dvp.logs.log import Log

    log = Log.load(Path(result["folder"]) / "log.mcap")
    assert log["v"][0] == pytest.approx(5.0, abs=0.1)
    assert log["v"][-1] == 0.0  # 9 m/s^2 hold a car that starts at 5 m/s
    assert list(log.meta["model"]["effects"]) == ["mine.py"]


def test_without_the_file_the_effect_is_unknown(scenario: Write, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(scenario()), "--model", "car.toml", "--no-report"]) != 0
    assert "anchor" in capsys.readouterr().err


def test_missing_file_is_a_usage_error(scenario: Write, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(scenario()), "--effects", "yours.py"]) == 2
    assert capsys.readouterr().err.startswith("--effects: no file ")
