"""The second opinion names hidden effects of a truth car from measured derivatives alone."""

from __future__ import annotations

import ast
import dataclasses
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from pytest_dvp.gap.diagnose import equation_error, regression_signals, regressors, tyre_regressors
from pytest_dvp.gap.diagnose.equation_error import opinions, votes
from pytest_dvp.gap.diagnose.regression_signals import signals
from pytest_dvp.gap.diagnose.regressors import FORMS
from pytest_dvp.gap.diagnose.tyre_regressors import on_tyres
from pytest_dvp.logs.log import Log
from tests.truth.effects import Effects, TruthCar, typical
from tests.truth.generate import make_log
from vehicle.model.effect_catalogue import catalogue
from vehicle.model.model_file import read_model
from vehicle.model.vehicle_model import VehicleModel

CAR = TruthCar()
NOT_ALONE = ("cornering_compliance", "tyre_relaxation")  # the first is no effect of the truth, the second comes with it


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> VehicleModel:
    path = tmp_path_factory.mktemp("votes") / "model.toml"
    path.write_text(
        f'[model]\nbase = "kinematic_bicycle"\n[parameters]\nwheelbase = {CAR.wheelbase}\nmass = {CAR.mass}\n'
        f"cg_to_front_axle = {CAR.cg_to_front_axle}\nyaw_inertia = {CAR.yaw_inertia}\n"
    )
    return read_model(path)


@cache
def log(*hidden: str) -> Log:
    effects: Effects = {name: typical(name) for name in hidden}
    return Log(make_log(effects, "rich", 5, "mid"))


@pytest.mark.parametrize("hidden", [form.name for form in FORMS if form.name not in NOT_ALONE][::4])
@pytest.mark.nightly(by_day=3)
def test_hidden_effect_gets_the_first_vote(model: VehicleModel, hidden: str) -> None:
    found = votes({"rich": log(hidden)}, model)
    assert found["first"] == hidden, found["ranking"][:3]


def test_nothing_is_named_when_nothing_is_missing(model: VehicleModel) -> None:
    assert votes({"rich": log()}, model)["first"] is None


def test_score_is_the_share_of_the_misfit(model: VehicleModel) -> None:
    """A delay of 0.15 s is all there is: it takes everything away, a constant angle nothing."""
    score = dict(votes({"rich": log("steer_delay")}, model)["ranking"])
    assert score["steer_delay"] > 0.98
    assert score["steer_offset"] < 0.02


def test_commands_that_nobody_obeyed_and_a_pause_have_no_vote(model: VehicleModel) -> None:
    """From 20 to 40 s somebody else drives, as `engaged` says; then nothing is recorded for 10 s, nor a fix for 5 s."""
    columns = dict(log("steer_delay").columns)
    t = columns["t"]
    hands, kept = (t >= 20.0) & (t < 40.0), (t < 40.0) | (t >= 50.0)
    columns["engaged"] = np.where(hands, 0.0, 1.0)
    columns["steer_cmd"] = np.where(hands, 0.3 * np.sin(t), columns["steer_cmd"])
    columns["x"] = np.where((t >= 60.0) & (t < 65.0), np.nan, columns["x"])
    whole = Log({name: values[kept] for name, values in columns.items()})
    score = dict(votes({"rich": whole}, model)["ranking"])
    assert score["steer_delay"] > 0.98
    judged = whole.t[0] + signals(whole, model).step * signals(whole, model).rows
    for begin, end in ((20.0, 50.0), (60.0, 65.0)):
        assert not ((judged > begin - 0.1) & (judged < end + 0.1)).any()


@pytest.mark.parametrize("hidden", ["understeer", "tyre_saturation"])
def test_tyres_are_not_mistaken_for_a_slow_steering(model: VehicleModel, hidden: str) -> None:
    assert votes({"rich": log(hidden)}, model)["first"] == hidden


def test_soft_tyres_are_told_as_slip_of_both_axles(model: VehicleModel) -> None:
    """The truth's car with another yaw inertia has soft tyres, too: 17.4 1/rad of their load instead of 48."""
    assert votes({"rich": log("yaw_inertia")}, model)["first"] == "cornering_compliance"


def test_car_on_tyres_turns_as_the_steady_state_says(model: VehicleModel) -> None:
    """r = v d/(L + K v^2), and the rear axle drifts by -D v^2 r, K and D the slip over lateral acceleration."""
    s = signals(log(), model)
    n = len(s.t)
    steady = dataclasses.replace(s, v=np.full(n, 10.0), steer=np.full(n, 0.03))
    rate, side = on_tyres(steady, 0.006, 0.004)
    expected = 10.0 * 0.03 / (CAR.wheelbase + 0.002 * 100.0)
    assert rate[-1] == pytest.approx(expected, rel=1e-6)
    assert side[-1] == pytest.approx(-0.004 * 100.0 * expected, rel=1e-6)


def test_sensor_is_not_mistaken_for_the_car(model: VehicleModel) -> None:
    """A late gyro and a late steering differ in the yaw angle alone."""
    late_gyro = votes({"rich": log("yaw_rate_latency")}, model)
    late_steering = votes({"rich": log("steer_delay")}, model)
    assert (late_gyro["first"], late_steering["first"]) == ("yaw_rate_latency", "steer_delay")


def test_unmeasured_signals_leave_their_effects_unjudged(model: VehicleModel) -> None:
    columns = dict(log("drive_lag").columns)
    for name in ("x", "y", "ax", "ay"):
        columns[name] = np.full(len(columns["t"]), np.nan)
    found = votes({"rich": Log(columns)}, model)
    assert found["first"] == "drive_lag"
    assert {"accelerometer_bias", "pitch", "road_bank", "gnss_lever_arm", "heading_bias"} <= set(found["not_judged"])


def test_every_effect_is_judged_or_listed_as_not_judged(model: VehicleModel) -> None:
    found = votes({"rich": log("mass")}, model)
    named = [name for name, _ in found["ranking"]] + found["not_judged"]
    assert sorted(named) == sorted(name for name, effect in catalogue().items() if effect.slot != "perception")


def test_model_with_effects_gets_no_vote(model: VehicleModel) -> None:
    found = votes({"rich": log("mass")}, model.with_effect("steer_delay", {"T": 0.1}))
    assert (found["first"], found["ranking"]) == (None, [])


def test_it_is_independent_of_the_main_engine() -> None:
    """Neither search nor fit nor replay: a common error cannot make the two agree."""
    for module in (equation_error, regressors, regression_signals, tyre_regressors):
        assert module.__file__ is not None
        tree = ast.parse(Path(module.__file__).read_text(encoding="utf-8"))
        imported = {node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
        own = {f"pytest_dvp.gap.{name}" for name in ("search", "fit", "experiment", "candidates")}
        assert not imported & (own | {"vehicle.model.open_loop", "vehicle.model.kernel"})


def test_late_steering_of_a_car_on_tyres_votes_for_nothing_else(tmp_path: Path) -> None:
    """Its yaw rate is no equation here: its steering's part would go to whatever else touches the yaw rate."""
    path = tmp_path / "model.toml"
    path.write_text(
        f'[model]\nbase = "dynamic_bicycle"\n[parameters]\nwheelbase = {CAR.wheelbase}\nmass = {CAR.mass}\n'
        f"cg_to_front_axle = {CAR.cg_to_front_axle}\nyaw_inertia = {CAR.yaw_inertia}\n"
    )
    named = {"steer_delay": {"T": 0.15}, "mass": {"ratio": 1.02}, "rolling_resistance": {"c": 0.1}}
    found = opinions({"rich": log("steer_delay", "understeer", "steer_ratio")}, read_model(path), named)
    assert [o.instead for o in found.values()] == ["", "", ""]


def test_what_moves_another_signal_is_no_vote_against_an_effect(model: VehicleModel) -> None:
    """A body that rolls is all there is to see; it says nothing for or against a drive, and of the accelerometer's
    place only where it is not named already, in whatever form."""
    logs = {"rich": log("roll")}
    assert opinions(logs, model, {"power_limit": {"limit": 39.0}})["power_limit"].instead == ""
    turned = {"imu_misalignment": {"angle": 0.0}}
    assert opinions(logs, model, turned)["imu_misalignment"].instead == "roll"
    assert opinions(logs, model, {**turned, "body_roll": {"gain": 0.12}})["imu_misalignment"].instead == ""
