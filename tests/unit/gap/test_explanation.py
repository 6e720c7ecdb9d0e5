"""What a failing test says of a model that does not match, by the verdict of the diagnosis."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.diagnosis import Diagnosis, Estimate, NamedEffect, Step, Verdict
from pytest_dvp.gap.words import failure_explanation as module
from pytest_dvp.gap.words.failure_explanation import explanation
from pytest_dvp.logs.log import Log
from vehicle.model.model_file import parse_model
from vehicle.model.vehicle_model import VehicleModel

LAG = NamedEffect(
    "steer_lag", {"tau": Estimate(0.101, 0.097, 0.105, "s")}, rivals=("steer_delay", "understeer"), gain=0.94,
    standing="confirmed",
)  # fmt: skip
GONE = NamedEffect("brake_lag", {"tau": Estimate(0.0, 0.0, 0.0, "s")}, action="remove", standing="confirmed")


@pytest.fixture
def model() -> VehicleModel:
    return parse_model("[model]\nname = 'twin'\n[parameters]\nwheelbase = 2.5\ncg_to_front_axle = 1.2\nmass = 1200.0\n")


def log(rows: int = 100) -> Log:
    return Log({"t": np.arange(rows) * 0.02, "v": np.ones(rows)})


def answered(monkeypatch: pytest.MonkeyPatch, verdict: Verdict, *effects: NamedEffect) -> None:
    step = Step("", 4.0, {"v": 4.0}, {"v": 0.1})
    found = Diagnosis(verdict, effects, ("aero_drag",), (step, step), {"v": 0.05}, {})
    monkeypatch.setattr(module, "_answer", lambda question: found)


def said(model: VehicleModel, **more: str) -> list[str]:
    return explanation(log(), model, log_name="drive.csv", model_name="models/car.toml", **more)  # type: ignore[arg-type]


def test_effect_rivals_and_command(model: VehicleModel, monkeypatch: pytest.MonkeyPatch) -> None:
    answered(monkeypatch, "AMBIGUOUS", LAG)
    first, effect, command, *_ = said(model)
    assert first.startswith("diagnosis: AMBIGUOUS: car.toml lacks steer_lag")
    assert effect == (
        "  steer_lag: tau = 0.101 s (0.097 to 0.105), explains 94 % of the error, rivals: steer_delay, understeer"
    )
    assert command.startswith("  add it: dvp extend --model models/car.toml --add steer_lag --fit drive.csv --out ")


def test_what_the_car_lacks_is_removed(model: VehicleModel, monkeypatch: pytest.MonkeyPatch) -> None:
    answered(monkeypatch, "NAMED", GONE)
    lines = said(model)
    assert "  remove brake_lag" in lines
    assert "--remove brake_lag" in lines[2]


def test_detections_do_not_explain_motion(model: VehicleModel, monkeypatch: pytest.MonkeyPatch) -> None:
    late = NamedEffect("detection_latency", {"T": Estimate(0.2, 0.1, 0.3, "s")})
    answered(monkeypatch, "NAMED", LAG, late)
    assert "detection_latency" not in "".join(said(model))
    answered(monkeypatch, "NAMED", late)
    assert said(model)[0].startswith("diagnosis: NOTHING_MISSING: ")


def test_unknown_names_the_command_that_looks_closer(model: VehicleModel, monkeypatch: pytest.MonkeyPatch) -> None:
    answered(monkeypatch, "UNKNOWN")
    assert said(model)[-1] == "  look closer: dvp diagnose drive.csv --model models/car.toml"


def test_bound_below_the_noise_is_said_to_be_one(model: VehicleModel, monkeypatch: pytest.MonkeyPatch) -> None:
    answered(monkeypatch, "NOTHING_MISSING")
    assert said(model)[-1] == "  a bound that fails now is tighter than the noise of the sensors"


def test_options_with_which_the_log_was_read_are_in_the_command(
    model: VehicleModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    answered(monkeypatch, "NAMED", LAG)
    lines = explanation(log(), model, log_name="a b.csv", model_name="car.toml", options=["--map", "m.toml"])
    assert "--fit 'a b.csv'" in lines[2]
    assert lines[2].endswith("--map m.toml")


def test_objects_without_a_file_are_said_to_need_one(model: VehicleModel, monkeypatch: pytest.MonkeyPatch) -> None:
    answered(monkeypatch, "NAMED", LAG)
    lines = explanation(log(), model)
    assert "twin lacks steer_lag" in lines[0]
    assert "dvp extend --model M.toml --add steer_lag --fit LOG " in lines[2]
    assert lines[2].endswith("(LOG and M.toml: to be written to a file first)")


def test_of_a_long_log_the_beginning_is_looked_at(model: VehicleModel, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []
    answered(monkeypatch, "NAMED", LAG)
    answer = module._answer
    monkeypatch.setattr(module, "_answer", lambda question: asked.append(len(question.log.t)) or answer(question))
    monkeypatch.setattr(module, "LONGEST", 1001)
    lines = explanation(log(5000), model)
    assert asked == [1001]
    assert lines[0].startswith("diagnosis (of its first 20 s): ")
