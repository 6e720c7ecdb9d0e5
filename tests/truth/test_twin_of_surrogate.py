"""The story of `make demo`: the surrogate's twin explains it, until something is hidden, which is then named."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

import scenarios
from pytest_dvp.gap.diagnose.diagnose import diagnose
from pytest_dvp.gap.diagnose.experiment import experiment_set
from pytest_dvp.logs.log import Log
from vehicle.model.model_file import read_model
from vehicle.model.vehicle_model import VehicleModel
from vehicle.surrogate.hidden import Hidden
from vehicle.surrogate.recorder import record


@pytest.fixture(scope="module")
def twin() -> VehicleModel:
    return read_model(Path(scenarios.__file__).parent / "models" / "surrogate.toml")


def drive(seed: int, effects: Mapping[str, Mapping[str, float]] | None = None) -> Log:
    return Log(record(Hidden(effects=effects or {}), "urban", seed))


def test_the_twin_explains_the_car_that_hides_nothing(twin: VehicleModel) -> None:
    """Written from the data sheet: 1 would be sensor noise alone; ax is off a little where it comes to rest."""
    levels = experiment_set({"urban": drive(3)}, twin).by_channel({})
    assert max(levels[c] for c in ("x", "y", "yaw", "v", "yaw_rate", "ay")) < 1.5
    assert levels["ax"] < 2.0


def test_what_is_hidden_is_named_and_the_error_on_another_drive_falls(twin: VehicleModel) -> None:
    late = {"steer_delay": {"T": 0.25}}
    found = diagnose({"one": drive(3, late)}, twin, held_out={"two": drive(2, late)})
    assert found.names == ("steer_delay",)
    assert found.effects[0].parameters["T"].value == pytest.approx(0.25, abs=0.01)
    before, after = found.ladder[0].held_out_rmse["yaw_rate"], found.ladder[-1].held_out_rmse["yaw_rate"]
    assert after < 0.3 * before
    assert after == pytest.approx(0.005, rel=0.1)  # rad/s, the noise of the surrogate's gyroscope
