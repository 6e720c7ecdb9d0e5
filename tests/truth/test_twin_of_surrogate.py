"""The surrogate and the kernel: two physics agree where a twin knows the car's inside, and what is hidden is named.

From the data sheet alone, which is what a user has, a diagnosis takes a minute: `make demo-gap` shows it.
"""

from __future__ import annotations

import tomllib
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
    """A twin by one who knows the car's inside."""
    return read_model(Path(__file__).parent / "surrogate_inside.toml")


def drive(seed: int, effects: Mapping[str, Mapping[str, float]] | None = None) -> Log:
    return Log(record(Hidden(effects=effects or {}), "urban", seed))


def test_the_twin_explains_the_car_that_hides_nothing(twin: VehicleModel) -> None:
    """1 would be sensor noise alone; ax is off a little where it comes to rest."""
    levels = experiment_set({"urban": drive(3)}, twin).by_channel({})
    assert max(levels[c] for c in ("x", "y", "yaw", "v", "yaw_rate", "ay")) < 1.5
    assert levels["ax"] < 2.0


PRINTED = {"length", "width", "height", "wheelbase", "track", "wheel_radius", "mass"}


@pytest.mark.parametrize("name", ["surrogate.toml", "surrogate_can.toml"])
def test_the_data_sheet_that_ships_holds_what_a_manufacturer_prints_and_no_more(name: str) -> None:
    content = tomllib.loads(scenarios.path(f"models/{name}").read_text(encoding="utf-8"))
    assert set(content) == {"model", "inputs", "parameters"}
    assert set(content["parameters"]) == PRINTED


def test_a_data_sheet_does_not_explain_the_car() -> None:
    """Its tyres, resistances and turning parts are not printed: far from the noise, where the inside is at it."""
    sheet = read_model(scenarios.path("models/surrogate.toml"))
    levels = experiment_set({"urban": drive(3)}, sheet).by_channel({})
    assert levels["x"] > 10.0
    assert levels["v"] > 10.0


@pytest.mark.nightly
def test_what_is_hidden_is_named_and_the_error_on_another_drive_falls(twin: VehicleModel) -> None:
    late = {"steer_delay": {"T": 0.25}}
    found = diagnose({"one": drive(3, late)}, twin, held_out={"two": drive(2, late)})
    assert found.names == ("steer_delay",)
    assert found.effects[0].parameters["T"].value == pytest.approx(0.25, abs=0.01)
    before, after = found.ladder[0].held_out_rmse["yaw_rate"], found.ladder[-1].held_out_rmse["yaw_rate"]
    assert after < 0.3 * before
    assert after == pytest.approx(0.005, rel=0.1)  # rad/s, the noise of the surrogate's gyroscope
