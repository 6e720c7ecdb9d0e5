"""What an iteration asks the diagnosis: a twin's known remainder is what shall become less, not noise."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose import diagnose as diagnosing
from pytest_dvp.gap.extend import extend as extending
from pytest_dvp.logs.log import Log
from pytest_dvp.tuning import structure_search
from vehicle.model.model_file import read_model
from vehicle.model.remainder_shape import RemainderShape

TWIN = """[parameters]
wheelbase = 2.5
[remainder]
v.cruise = 0.1
[remainder.memory]
v = 1.0
"""


def test_a_diagnosis_of_an_iteration_does_not_excuse_what_the_twin_is_known_to_leave(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    twin = tmp_path / "twin.toml"
    twin.write_text(TWIN)
    log = tmp_path / "log.mcap"
    log.write_bytes(b"")
    assert read_model(twin).remainder
    asked: list[Any] = []

    def diagnosed(logs: Any, model: Any, tick: Any) -> Any:
        asked.append(model)
        return SimpleNamespace(effects=(), as_dict=lambda: {"verdict": "NOTHING_MISSING"})

    monkeypatch.setattr(diagnosing, "diagnose", diagnosed)
    monkeypatch.setattr(structure_search, "thinned", lambda path: SimpleNamespace())
    monkeypatch.setattr(
        structure_search, "reset_to_data_sheet", lambda model, sheet, logs, allowed: SimpleNamespace(
            model=model, changes=("EGO_mass 1000 -> 730",)),
    )  # fmt: skip
    found = structure_search._looked_for([log], twin, twin, lambda text: None, presets=False)
    (model,) = asked
    assert (model.remainder, model.remainder_shape) == ({}, RemainderShape())
    assert model.car.wheelbase == 2.5
    assert found.pruned == ("EGO_mass 1000 -> 730",)
    assert found.model is not None
    assert "remainder" not in found.model


def test_an_extension_loses_its_least_idle_effect_and_keeps_the_great_ones(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The refusal of a whole set once took out the effects that stand beside the idle one, the greatest first."""
    twin, log = tmp_path / "twin.toml", tmp_path / "log.mcap"
    twin.write_text(TWIN)
    log.write_bytes(b"")
    names = ["rolling_resistance", "steer_ratio", "roll", "steer_servo"]
    effects = [SimpleNamespace(name=name, gain=0.1, action="add", parameters={}) for name in names]
    asked: list[list[str]] = []

    def extended(logs: Any, model: Any, *, add: list[str], **more: Any) -> Any:
        asked.append(list(add))
        idle = [name for name in ("roll", "steer_servo") if name in add and len(add) > 2]
        beside = ", ".join(name for name in add if name not in idle)
        refusal = "; ".join(f"{name} explains too little beside {beside}; leave it out" for name in idle)
        kept = [each for each in effects if each.name in add]
        return SimpleNamespace(refusal=refusal, refused=tuple(idle), effects=kept, model=model, as_dict=dict)

    found = SimpleNamespace(effects=effects, values={}, as_dict=dict, ladder=ladder(10.0, 1.0))
    monkeypatch.setattr(diagnosing, "diagnose", lambda logs, model, tick: found)
    monkeypatch.setattr(extending, "extend", extended)
    monkeypatch.setattr(structure_search, "thinned", lambda path: SimpleNamespace())
    monkeypatch.setattr(
        structure_search, "reset_to_data_sheet",
        lambda model, sheet, logs, allowed: SimpleNamespace(model=model, changes=()),
    )  # fmt: skip
    result = structure_search._looked_for([log], twin, twin, lambda text: None, presets=False)
    assert asked == [names, names[:3], names[:2]]
    assert [each.split()[1] for each in result.taken] == names[:2]
    assert result.model is not None


def test_an_effect_is_worth_what_it_explains_of_what_is_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a chi^2/N of 700, a ten-thousandth is much beside the 1.8 that is left, and a millionth is not."""
    twin, log = tmp_path / "twin.toml", tmp_path / "log.mcap"
    twin.write_text(TWIN)
    log.write_bytes(b"")
    gains = {"mass": 0.9, "understeer": 1e-4, "roll": 1e-6}
    effects = [SimpleNamespace(name=name, gain=gain, action="add", parameters={}) for name, gain in gains.items()]
    found = SimpleNamespace(effects=effects, values={}, as_dict=dict, ladder=ladder(700.0, 1.8))
    asked: list[list[str]] = []

    def extended(logs: Any, model: Any, *, add: list[str], **more: Any) -> Any:
        asked.append(list(add))
        return SimpleNamespace(refusal="", refused=(), effects=effects[:2], model=model, as_dict=dict)

    monkeypatch.setattr(diagnosing, "diagnose", lambda logs, model, tick: found)
    monkeypatch.setattr(extending, "extend", extended)
    monkeypatch.setattr(structure_search, "thinned", lambda path: SimpleNamespace())
    monkeypatch.setattr(
        structure_search, "reset_to_data_sheet",
        lambda model, sheet, logs, allowed: SimpleNamespace(model=model, changes=()),
    )  # fmt: skip
    structure_search._looked_for([log], twin, twin, lambda text: None, presets=False)
    assert asked == [["mass", "understeer"]]


def ladder(*chi2: float) -> tuple[Any, ...]:
    return tuple(SimpleNamespace(chi2_per_n=each) for each in chi2)


def test_pedals_below_the_gate_are_thinned_to_their_mean_as_well(tmp_path: Path) -> None:
    t = 0.01 * np.arange(200)
    pedal = np.where(np.arange(200) % 2 == 0, 1.0, 0.0)
    columns = {"t": t, "throttle_cmd": pedal, "gate.throttle_cmd": pedal, "arrived.brake_cmd": pedal, "v": pedal}
    Log(columns).save(tmp_path / "a.mcap")
    found = structure_search.thinned(tmp_path / "a.mcap").columns
    for name in ("throttle_cmd", "gate.throttle_cmd", "arrived.brake_cmd"):
        assert found[name] == pytest.approx(0.5)
    assert found["v"] == pytest.approx(1.0)
