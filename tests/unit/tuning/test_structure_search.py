"""What an iteration asks the diagnosis: a twin's known remainder is what shall become less, not noise."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from pytest_dvp.gap.diagnose import diagnose as diagnosing
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
