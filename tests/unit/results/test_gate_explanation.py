"""Which models of failed gates are explained: each file once, and black boxes and gates without a number not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from pytest_dvp.verdicts import gate_explanation as module
from pytest_dvp.verdicts.gate_explanation import _models, gate_explanation

CAR = "[model]\nname = '{name}'\n[parameters]\nwheelbase = 2.5\n"
GATE = '[[gate]]\nmetric = "{metric}"\nmodel = "{model}"\nsignal = "{signal}"\nmax = 0.1\n'


@pytest.fixture
def gates(tmp_path: Path) -> str:
    """Gates at lines 1, 6, 11 and 16: two of a.toml, one of b.toml, one of a black box."""
    for name in ("a", "b"):
        (tmp_path / f"{name}.toml").write_text(CAR.format(name=name))
    (tmp_path / "box.py").write_text("def step(state, commands, dt):\n    return state\n")
    file = tmp_path / "drive.gates.toml"
    chosen = (("v", "a.toml"), ("yaw_rate", "a.toml"), ("v", "b.toml"), ("v", "box.py"))
    file.write_text("".join(GATE.format(metric="open_loop_error", model=m, signal=s) for s, m in chosen))
    return str(file)


def verdict(file: str, line: int, **more: Any) -> dict[str, Any]:
    return {"file": file, "line": line, "metric": "open_loop_error", "status": "FAIL", "value": 0.3, **more}


def names(found: Any) -> list[str]:
    return [model.name for model in found.values()]


def test_each_model_of_a_failed_gate_is_meant_once(gates: str) -> None:
    every = [verdict(gates, line) for line in (1, 6, 11, 16)]
    found = _models(every)
    assert names(found) == ["a", "b"]
    assert [Path(name).name for name in found] == ["a.toml", "b.toml"]
    assert names(_models(every[2:])) == ["b"]
    assert names(_models(every[1:2])) == ["a"]
    assert _models([]) == {}


@pytest.mark.parametrize(
    "more",
    [{"status": "PASS"}, {"status": "INCONCLUSIVE"}, {"value": None}, {"metric": "min_ttc"}, {"line": 2}, {"line": 16}],
)
def test_what_no_effect_could_explain_is_left_out(gates: str, more: dict[str, Any]) -> None:
    assert _models([verdict(gates, 1) | more]) == {}


def test_lines_of_all_models_stand_one_after_the_other(gates: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "explanation", lambda log, model, log_name, model_name: [
        f"{log} {model.name} {log_name} {Path(model_name).name}", "more"])  # fmt: skip
    log: Any = "LOG"
    lines = gate_explanation(log, [verdict(gates, 11), verdict(gates, 1)], "d.mcap")
    assert lines == ["LOG a d.mcap a.toml", "more", "LOG b d.mcap b.toml", "more"]
    assert gate_explanation(log, [verdict(gates, 16)], "d.mcap") == []


def test_what_goes_wrong_is_one_line_of_two_hundred_letters_at_most(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(verdicts: Any) -> Any:
        raise ValueError("no\n  such   " + "x" * 300)

    monkeypatch.setattr(module, "_models", broken)
    log: Any = None
    assert gate_explanation(log, [], "d.mcap") == ["no diagnosis: ValueError: no such " + "x" * 192]
