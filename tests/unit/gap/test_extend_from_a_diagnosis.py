"""`dvp extend --from`: what a diagnosis found is where the fit begins, and --add names more of it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from pytest_dvp.cli.command_line import main
from pytest_dvp.gap.diagnose.diagnosis import Step
from pytest_dvp.gap.extend import extend as extend_module
from pytest_dvp.gap.extend.extension import Extension, Rung

CAR = "[model]\nname = 'car'\n[parameters]\nwheelbase = 2.5\n"
ROWS = "\n".join(f"{0.02 * k},{0.1 * k},0,0,5,0,0" for k in range(600))


@pytest.fixture
def asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """What `extend` is asked for; it answers that something explains nothing."""
    monkeypatch.chdir(tmp_path)
    Path("car.toml").write_text(CAR)
    Path("a.csv").write_text(f"t [s],x [m],y [m],yaw [rad],v [m/s],steer_cmd [rad],accel_cmd [m/s^2]\n{ROWS}\n")
    seen: dict[str, Any] = {}

    def answer(logs: Any, model: Any, **more: Any) -> Extension:
        seen.update(more)
        given = Rung("", Step("", 2.0, {"v": 0.1}, {"v": 0.1}, None))
        return Extension(model, (), {}, (given,), {"v": 0.05}, "it explains nothing", (), False, False, ())

    monkeypatch.setattr(extend_module, "extend", answer)
    return seen


def diagnosis(*effects: tuple[str, str, dict[str, float | None]]) -> None:
    """A document of `dvp diagnose --json` with (name, standing, values)."""
    entries = [
        {"name": name, "standing": standing, "parameters": {key: {"value": value} for key, value in values.items()}}
        for name, standing, values in effects
    ]
    Path("d.json").write_text(json.dumps({"verdict": "NAMED", "effects": entries}))


def extend(*words: str) -> int:
    return main(["extend", "--model", "car.toml", "--fit", "a.csv", "--out", "new.toml", *words])


def test_the_fit_begins_with_what_the_diagnosis_found(asked: dict[str, Any]) -> None:
    """Also of what is provisional, and named; a value without an end is none to begin with."""
    diagnosis(
        ("steer_delay", "confirmed", {"T": 0.21}),
        ("headwind", "provisional", {"speed": 3.0, "k": 0.0006, "heading": None}),
    )
    assert extend("--from", "d.json") == 1
    assert list(asked["add"]) == ["steer_delay"]
    assert asked["start"] == {("steer_delay", "T"): 0.21, ("headwind", "speed"): 3.0, ("headwind", "k"): 0.0006}
    assert extend("--from", "d.json", "--add", "headwind") == 1
    assert list(asked["add"]) == ["steer_delay", "headwind"]


def test_what_is_named_is_added_where_nothing_is_confirmed(asked: dict[str, Any]) -> None:
    diagnosis(("brake_gain", "provisional", {"g": 0.9}))
    assert extend("--from", "d.json", "--add", "brake_gain") == 1
    assert list(asked["add"]) == ["brake_gain"]
    assert asked["start"] == {("brake_gain", "g"): 0.9}


def test_a_refusal_of_several_tells_how_they_begin_together(
    asked: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    diagnosis(("steer_delay", "confirmed", {"T": 0.21}))
    for words, told in (
        (["--add", "steer_delay"], False),
        (["--add", "steer_delay", "brake_gain"], True),
        (["--from", "d.json", "--add", "brake_gain", "brake_lag"], False),
    ):
        assert extend(*words) == 1
        (line,) = [line for line in capsys.readouterr().err.splitlines() if "is not written" in line]
        assert ("then --from D.json beside --add" in line) is told


@pytest.mark.parametrize("value", ["fast", [], {}])
def test_a_value_that_is_no_number_is_no_diagnosis(
    asked: dict[str, Any], value: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    diagnosis(("steer_delay", "confirmed", {"T": value}))
    assert extend("--from", "d.json") == 1
    assert capsys.readouterr().err == "d.json: not a document of `dvp diagnose --json`\n"
    assert not asked
