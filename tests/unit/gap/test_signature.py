"""The signature of an error that no effect of the catalogue explains points at what is behind it.

Behind each log here is a truth car with one effect that no catalogue has; names, values and units of them are those of
tests/truth/effects.py.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.experiment import Values, experiment_set
from pytest_dvp.gap.diagnose.residual_signature import signature
from pytest_dvp.logs.log import Log
from tests.truth.effects import Effects, TruthCar, typical
from tests.truth.generate import make_log
from vehicle.model.model_file import read_model
from vehicle.model.vehicle_model import VehicleModel

CAR = TruthCar()


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> VehicleModel:
    path = tmp_path_factory.mktemp("signature") / "model.toml"
    path.write_text(
        f'[model]\nbase = "kinematic_bicycle"\n[parameters]\nwheelbase = {CAR.wheelbase}\nmass = {CAR.mass}\n'
        f"cg_to_front_axle = {CAR.cg_to_front_axle}\nyaw_inertia = {CAR.yaw_inertia}\n"
    )
    return read_model(path)


def logs(effects: Effects, seed: int = 3) -> dict[str, Log]:
    return {"rich": Log(make_log(effects, "rich", seed, "mid"))}


def told(model: VehicleModel, effects: Effects, values: Values | None = None) -> dict[str, Any]:
    return signature(experiment_set(logs(effects), model), values or {})


@pytest.mark.parametrize(
    ("hidden", "axis", "key", "coefficient"),
    [
        ("torque_ripple", "longitudinal", "wave_distance", None),
        ("speed_dependent_ratio", "lateral", "steer_by_speed", None),
        ("brake_fade", "longitudinal", "brake_heat", -0.5),  # drops by half
        ("cross_wind", "lateral", "wave_time", None),
        ("steer_resonance", "lateral", "steer_rings", 1.0),  # all of the command passes the resonance
        ("battery_sag", "longitudinal", "drive_energy", -0.4),  # drops by 40 %
        ("converter_gain", "longitudinal", "creeping", 0.6),  # m/s^2 at standstill
    ],
)
@pytest.mark.nightly(by_day=2)
def test_first_term_points_at_hidden_effect(
    model: VehicleModel, hidden: str, axis: str, key: str, coefficient: float | None
) -> None:
    found = told(model, {hidden: typical(hidden)})["axes"][0]
    assert found["axis"] == axis
    assert found["regressors"][0]["key"] == key
    assert found["regressors"][0]["held_out_share"] > 0.6
    if coefficient is not None:
        assert found["regressors"][0]["coefficient"] == pytest.approx(
            coefficient, rel=0.4
        )  # the scale of a fade is a guess


@pytest.mark.nightly(by_day=2)
def test_a_drive_that_stops_for_a_while_at_a_speed_points_at_that_speed(model: VehicleModel) -> None:
    once = {"T": 0.6, "v1": 6.0, "step": 3.0, "demand": 0.0, "cut": 1.0}
    found = told(model, {"gear_changes": once})["axes"][0]
    assert (found["axis"], found["regressors"][0]["key"]) == ("longitudinal", "speed_passed")
    assert found["regressors"][0]["held_out_share"] > 0.6


def test_rhythm_is_sharper_over_distance_for_a_ripple_of_the_wheels(model: VehicleModel) -> None:
    first, second = told(model, {"torque_ripple": typical("torque_ripple")})["axes"][0]["rhythm"]
    assert (first["over"], first["unit"]) == ("distance", "1/m")
    assert first["frequency"] == pytest.approx(0.35, rel=0.01)
    assert first["share"] > 5.0 * second["share"]


def test_waves_of_two_logs_need_not_be_in_step(model: VehicleModel) -> None:
    """Each log has a phase of its own: the same gusts, met 3 s later."""
    columns = make_log({"cross_wind": typical("cross_wind")}, "rich", 4, "mid")
    late = {name: values[150:] for name, values in columns.items()} | {"t": columns["t"][:-150]}
    both = experiment_set({"one": Log(columns), "other": Log(late)}, model)
    first = signature(both, {})["axes"][0]["regressors"][0]
    assert first["key"] == "wave_time"
    assert first["held_out_share"] > 0.95


def test_rhythm_is_sharper_over_time_for_gusts(model: VehicleModel) -> None:
    first = told(model, {"cross_wind": typical("cross_wind")})["axes"][0]["rhythm"][0]
    assert first["over"] == "time"
    assert first["frequency"] == pytest.approx(1.0 / 7.0, rel=0.02)


def test_wrong_effect_in_the_model_does_not_hide_what_is_behind(model: VehicleModel) -> None:
    """A power limit is what fits a sagging battery best; with it in, the error has another shape."""
    found = told(model, {"battery_sag": typical("battery_sag")}, {("power_limit", "limit"): 7.7})["axes"][0]
    assert found["basis"] == "model as given"
    assert found["regressors"][0]["key"] == "drive_energy"
    assert "battery sag?" in found["reading"]


def test_error_of_speed_is_not_told_as_an_error_of_steering(model: VehicleModel) -> None:
    """A drive of half the strength makes the modelled car too fast in turns: speed explains the yaw rate."""
    found = told(model, {"drive_gain": {"g": 0.5}})
    lateral = [entry for entry in found["axes"] if entry["axis"] == "lateral"]
    assert lateral
    assert "follows from the wrong speed" in lateral[0]["reading"]


def test_sliding_car_is_told(model: VehicleModel) -> None:
    """Of tyres that give 1.2 m/s^2, those behind first, 4 is asked: the car leaves its heading by more than 0.1 rad."""
    found = told(model, {"tyre_saturation": {"limit": 1.2}, "understeer": {"K": -0.002}})
    assert found["axes"][0]["slip"] > 0.12


def test_nothing_left_has_no_signature(model: VehicleModel) -> None:
    assert told(model, {}) == {}


def test_trend_grows_for_a_fade_that_never_levels_off(model: VehicleModel) -> None:
    found = told(model, {"brake_fade": {"drop": 0.9, "heat": 1000.0}})["axes"][0]
    assert found["trend"]["share_in_second_half"] > 0.8


def test_document_is_json_and_deterministic(model: VehicleModel) -> None:
    effects = {"converter_gain": typical("converter_gain")}
    first, second = (json.dumps(told(model, effects), allow_nan=False) for _ in range(2))
    assert first == second


def test_without_accelerometer_and_yaw_rate(model: VehicleModel) -> None:
    """Speed and yaw alone, through their integrals, tell the same."""
    columns = make_log({"brake_fade": typical("brake_fade")}, "rich", 3, "mid")
    for name in ("ax", "ay", "yaw_rate"):
        columns[name] = np.full(len(columns["t"]), np.nan)
    found = signature(experiment_set({"rich": Log(columns)}, model), {})["axes"][0]
    assert found["regressors"][0]["key"] == "brake_heat"


def test_terms_of_noise_are_not_told(model: VehicleModel, tmp_path: Path) -> None:
    """Speed with slow noise that nothing of the list explains: no term passes on segments left out."""
    columns = make_log({}, "rich", 3, "mid")
    rng = np.random.default_rng(1)
    walk = np.cumsum(rng.normal(0.0, 0.02, len(columns["t"])))
    columns["v"] = columns["v"] + walk
    found = signature(experiment_set({"rich": Log(columns)}, model), {})
    assert found["channels"]["v"] > 1.5
    entry = next(e for e in found["axes"] if e["axis"] == "longitudinal")
    assert all(r["held_out_share"] < 0.15 for r in entry["regressors"][:1])
    assert "no term of the list" in entry["reading"] or "same places" in entry["reading"]
