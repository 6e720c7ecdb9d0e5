"""What the model of a failed `model` gate lacks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.logs.log import Log

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import VehicleModel
from pytest_dvp.gap.words.failure_explanation import explanation


def gate_explanation(log: Log, verdicts: Sequence[Mapping[str, Any]], log_name: str) -> list[str]:
    """The same for the verdicts of a run's gates: each model file that a failed gate names, once."""
    try:
        models = _models(verdicts)
    except Exception as error:
        return [f"no diagnosis: {type(error).__name__}: {' '.join(str(error).split())[:200]}"]
    return [line for name, model in models.items() for line in explanation(log, model, log_name=log_name,
                                                                         model_name=name)]  # fmt: skip


def _models(verdicts: Sequence[Mapping[str, Any]]) -> dict[str, VehicleModel]:
    """Models of failed gates by the name of their file; black boxes are left out, as nothing can be added to them."""
    from pytest_dvp.text.paths import shown
    from pytest_dvp.verdicts.judging import read_gates
    from pytest_dvp.verdicts.verdict_changes import KIND_OF
    from vehicle.model.model_file import read_model

    failed = {
        (v["file"], v["line"], v["metric"])
        for v in verdicts
        if v["status"] == "FAIL" and v["metric"] in KIND_OF and v["value"] is not None  # no effect explains no number
    }
    named: dict[str, Path] = {}
    for file in sorted({file for file, _, _ in failed}):
        for gate in read_gates(file).gates:
            if (file, gate.line, gate.metric) in failed and str(gate.options.get("model", "")).endswith(".toml"):
                path = Path(str(gate.options["model"]))
                named[shown(path)] = path
    return {name: read_model(path) for name, path in named.items()}
