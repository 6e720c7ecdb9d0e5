"""diagnose: what is missing, what is too much, what cannot be told; on a car whose truth is written in the test."""

from __future__ import annotations

import json
from types import SimpleNamespace
from typing import Any

import numba
import numpy as np
import pytest
from gap_logs import NOISE, baseline, drive

from pytest_dvp.gap.compare.compared_model import CompareError, command_at_stamps
from pytest_dvp.gap.diagnose import all_cores
from pytest_dvp.gap.diagnose.all_cores import cores
from pytest_dvp.gap.diagnose.diagnose import _together, diagnose
from pytest_dvp.gap.diagnose.diagnosis import Diagnosis
from pytest_dvp.gap.diagnose.least_squares import Coordinate
from pytest_dvp.gap.diagnose.removal import price
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from vehicle.model.effect_catalogue import catalogue, find_effect
from vehicle.model.model_file import parse_model
from vehicle.model.vehicle_model import VehicleModel

CAR = "[parameters]\nwheelbase = 2.5\ncg_to_front_axle = 1.2\nmass = 1200.0\n"


def with_columns(log: Log, **columns: FloatArray) -> Log:
    return Log({**log.columns, **columns})


def with_effect(name: str, values: str) -> VehicleModel:
    return parse_model(f"[model]\nname = 'car'\n{CAR}[[effect]]\nname = '{name}'\nparameters = {{{values}}}\n")


@pytest.fixture(scope="module")
def weak_drive() -> Diagnosis:
    """All that the car does wrong: it accelerates at 85 %."""
    return diagnose({"log": drive(drive_gain=0.85, seed=3)}, baseline())


def test_the_effect_is_named_alone_and_its_interval_holds_the_truth(weak_drive: Diagnosis) -> None:
    assert (weak_drive.verdict, weak_drive.names) == ("NAMED", ("drive_gain",))
    (effect,) = weak_drive.effects
    estimate = effect.parameters["g"]
    assert estimate.low <= 0.85 <= estimate.high
    assert estimate.value == pytest.approx(0.85, rel=0.005)
    assert estimate.unit == "-"
    assert effect.action == "add"
    assert effect.rivals == ()


def test_the_effect_explains_all_that_was_beyond_the_noise_here_and_on_the_end_that_was_held_out(
    weak_drive: Diagnosis,
) -> None:
    before, after = weak_drive.ladder
    assert (before.added, after.added) == ("", "drive_gain")
    assert before.chi2_per_n > 5.0
    assert after.chi2_per_n == pytest.approx(1.0, abs=0.08)
    assert weak_drive.effects[0].gain == pytest.approx(1.0, abs=0.02)
    assert before.held_out_chi2_per_n is not None
    assert before.held_out_chi2_per_n > 5.0
    assert after.held_out_chi2_per_n == pytest.approx(1.0, abs=0.1)
    assert after.rmse["v"] == pytest.approx(NOISE["v"], rel=0.05)
    assert after.held_out_rmse["v"] == pytest.approx(NOISE["v"], rel=0.1)


@pytest.mark.nightly
def test_in_a_log_without_noise_what_no_sensor_could_show_is_not_named() -> None:
    """A simulator's own log: half a milliradian of heading and 0.03 % of steering are finer than any gyro's."""
    found = diagnose({"log": drive(drive_gain=0.85, steer_ratio=0.9997, yaw_bias=0.0005, noise=0.0)}, baseline())
    assert (found.verdict, found.names) == ("NAMED", ("drive_gain",))
    assert found.effects[0].parameters["g"].value == pytest.approx(0.85, rel=0.002)
    trifles = diagnose({"log": drive(steer_ratio=0.9997, yaw_bias=0.0005, noise=0.0)}, baseline())
    assert trifles.verdict == "NOTHING_MISSING"


def test_of_two_answers_within_the_noise_that_with_fewer_changes_is_taken() -> None:
    """What is missing elsewhere can make an effect of the model look as if it were too much."""

    def answer(chi2: float, values: int) -> Any:
        plain = [Coordinate("mass", find_effect("mass").key("ratio"))] * values
        return SimpleNamespace(final=SimpleNamespace(chi2=chi2, fit=SimpleNamespace(coordinates=plain), values={}))

    assert price(answer(350.0, 1), 1000, 0) < price(answer(300.0, 2), 1000, 0)
    assert price(answer(350.0, 1), 1000, 0) < price(answer(300.0, 1), 1000, 1)
    assert price(answer(1100.0, 2), 1000, 1) < price(answer(1400.0, 1), 1000, 0)


def test_what_the_command_gate_did_is_not_the_cars() -> None:
    """The car got commands that the gate had made weaker; the car itself does as it is told."""
    log = drive(drive_gain=0.85, seed=3)
    passed = np.where(log.columns["accel_cmd"] > 0.0, 0.85, 1.0) * log.columns["accel_cmd"]
    passed[:5] = np.nan  # before its first decision
    found = diagnose({"log": with_columns(log, **{"gate.accel_cmd": passed})}, baseline())
    assert found.verdict == "NOTHING_MISSING"


def test_the_noise_floor_is_the_noise(weak_drive: Diagnosis) -> None:
    for name, sigma in NOISE.items():
        assert weak_drive.noise_floor[name] == pytest.approx(sigma, rel=0.12)


def test_the_document_has_the_keys_of_the_contract(weak_drive: Diagnosis) -> None:
    document = json.loads(json.dumps(weak_drive.as_dict(), allow_nan=False))
    contract = {"verdict", "effects", "not_excited", "error", "noise_floor", "signature"}
    more = {"chi2_per_n", "vetoed", "set_up", "input_map", "car", "votes", "ladder", "null_line", "remainder"}
    assert set(document) == contract | more | {"samples", "chosen_by_held_out", "may_hide", "scale_notes"}
    assert document["samples"]["independent"] == pytest.approx(document["samples"]["count"])
    (effect,) = document["effects"]
    contract = {"name", "parameters", "rivals", "deciding_manoeuvre", "gain"}
    assert set(effect) == contract | {"action", "held_out_gain", "standing", "doubts", "second_engine", "depends_on"}
    assert (effect["standing"], effect["doubts"], effect["depends_on"]) == ("confirmed", [], None)
    assert set(effect["parameters"]["g"]) == {"value", "low", "high", "unit"}
    assert effect["deciding_manoeuvre"] is None
    for data in ("fit", "held_out"):
        assert set(document["error"][data]) == {"before", "after"}
        assert set(document["error"][data]["before"]) == set(NOISE)


def test_same_log_same_bytes_on_any_number_of_cores(weak_drive: Diagnosis, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numba.config, "NUMBA_NUM_THREADS", 3 if cores() < 3 else 1)
    all_cores._pool.cache_clear()
    again = diagnose({"log": drive(drive_gain=0.85, seed=3)}, baseline())
    assert json.dumps(again.as_dict()) == json.dumps(weak_drive.as_dict())


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.nightly(by_day=3)
def test_nothing_is_missing_where_there_is_only_noise(seed: int) -> None:
    found = diagnose({"log": drive(seed=seed)}, baseline())
    assert (found.verdict, found.names, found.vetoed) == ("NOTHING_MISSING", (), ())
    assert found.ladder[-1].chi2_per_n == pytest.approx(1.0, abs=0.08)


def at_rest() -> Log:
    """A minute at standstill: only noise is seen, nothing is asked of the car."""
    t = drive().t
    rng = np.random.default_rng(0)
    still = {"t": t, "accel_cmd": 0.0 * t, "steer_cmd": 0.0 * t}
    return Log(still | {name: rng.normal(0.0, sigma, len(t)) for name, sigma in NOISE.items()})


def straight_on() -> Log:
    """A minute straight on at 10 m/s."""
    log = at_rest()
    return with_columns(log, x=log.columns["x"] + 10.0 * log.t, v=log.columns["v"] + 10.0)


@pytest.mark.parametrize("log", [at_rest(), straight_on()], ids=["at rest", "straight on"])
def test_a_log_in_which_nothing_happens_says_so(log: Log) -> None:
    found = diagnose({"log": log}, baseline())
    assert (found.verdict, found.names) == ("NOT_EXCITED", ())
    assert {"steer_delay", "steer_ratio", "brake_gain", "understeer", "drive_delay"} <= set(found.not_excited)


def test_what_a_drive_does_not_reach_is_not_excited_and_the_rest_is(weak_drive: Diagnosis) -> None:
    # the wheels turn by 0.08 rad, where the catalogue's limits only begin, and no pedal is pressed lightly
    assert "steer_angle_limit" in weak_drive.not_excited
    assert "pedal_deadband" in weak_drive.not_excited
    assert not {"steer_delay", "brake_gain", "steer_ratio", "gyro_bias"} & set(weak_drive.not_excited)


@pytest.mark.nightly
def test_two_effects_are_both_named_and_each_takes_its_share() -> None:
    found = diagnose({"log": drive(steer_delay=0.2, drive_gain=0.85, seed=5)}, baseline())
    assert (found.verdict, set(found.names)) == ("NAMED", {"steer_delay", "drive_gain"})
    gains = [effect.gain for effect in found.effects]
    assert gains == sorted(gains, reverse=True)
    assert sum(gains) == pytest.approx(1.0, abs=0.03)
    values = {effect.name: next(iter(effect.parameters.values())) for effect in found.effects}
    assert values["steer_delay"].low <= 0.2 <= values["steer_delay"].high
    assert values["drive_gain"].low <= 0.85 <= values["drive_gain"].high


def test_without_a_single_braking_the_mass_cannot_be_told_from_the_gain_of_the_drive() -> None:
    """a = g a_c and a = a_c/m are one equation as long as a_c is positive."""
    log = drive(seed=7, drive_gain=0.8)
    found = diagnose({"log": Log({name: values[: 11 * 50] for name, values in log.columns.items()})}, baseline())
    assert found.verdict == "AMBIGUOUS"
    (effect,) = found.effects
    assert {effect.name, *effect.rivals} >= {"drive_gain", "mass"}


def test_an_effect_that_the_car_lacks_is_to_be_removed() -> None:
    found = diagnose({"log": drive(seed=6)}, with_effect("steer_delay", "T = 0.3"))
    assert found.verdict == "NAMED"
    assert [(e.name, e.action) for e in found.effects] == [("steer_delay", "remove")]
    assert found.effects[0].parameters["T"].value == 0.0
    assert found.effects[0].gain == pytest.approx(1.0, abs=0.02)
    assert found.ladder[-1].chi2_per_n == pytest.approx(1.0, abs=0.08)


def test_an_effect_that_is_right_stays() -> None:
    found = diagnose({"log": drive(seed=6, steer_delay=0.2)}, with_effect("steer_delay", "T = 0.2"))
    assert (found.verdict, found.names) == ("NOTHING_MISSING", ())


def test_an_effect_with_a_wrong_value_is_to_be_changed() -> None:
    found = diagnose({"log": drive(seed=6, drive_gain=0.7)}, with_effect("drive_gain", "g = 0.8"))
    assert [(e.name, e.action) for e in found.effects] == [("drive_gain", "change")]
    estimate = found.effects[0].parameters["g"]
    assert estimate.low <= 0.7 <= estimate.high


@pytest.mark.nightly
def test_what_wins_on_its_own_run_and_loses_on_another_is_taken_back() -> None:
    """Only the first car is weak: on the other one the gain would do harm."""
    found = diagnose({"own": drive(seed=1, drive_gain=0.9)}, baseline(), {"other": drive(seed=2)})
    assert found.vetoed == ("drive_gain",)
    assert found.names == ()
    assert found.verdict == "UNKNOWN"
    assert found.ladder[-1].held_out_chi2_per_n == pytest.approx(1.0, abs=0.08)


@pytest.mark.nightly
def test_zero_that_another_run_has_elsewhere_is_taken_from_the_beginning_of_that_run() -> None:
    """One car, whose wheels turn by 90 % of what is asked; its steering stood 0.02 rad to the left that day, 0.015 rad
    to the right on another. The ratio is the car's, either zero its run's."""
    own = drive(seed=1, steer_ratio=0.9, steer_offset=0.02)
    found = diagnose({"own": own}, baseline(), {"other": drive(seed=2, steer_ratio=0.9, steer_offset=-0.015)})
    assert set(found.names) == {"steer_ratio", "steer_offset"}
    assert found.set_up == ("steer_offset",)
    assert found.vetoed == ()
    (run,) = found.ladder[-1].held_out_setups
    assert run["steer_offset", "offset"] == pytest.approx(-0.015, abs=0.001)
    assert found.ladder[-1].held_out_chi2_per_n == pytest.approx(1.0, abs=0.1)


@pytest.mark.nightly
def test_logs_that_contradict_each_other_name_nothing() -> None:
    """No one bias is that of both gyros; each log judges what the other says."""
    one, other = drive(40.0, seed=1), drive(40.0, seed=2)
    one = with_columns(one, yaw_rate=one.columns["yaw_rate"] + 0.03)
    found = diagnose({"one": one, "other": other}, baseline())
    assert found.names == ()
    assert found.verdict == "UNKNOWN"


@pytest.mark.parametrize("delay", [pytest.param(0.0, marks=pytest.mark.nightly), 0.2])
def test_a_scale_that_nobody_knows_is_fitted_and_is_no_effect(delay: float) -> None:
    """Steering in -1..1 of 0.6 rad: the scale comes out, with or without a delay that is really missing."""
    log = drive(seed=8, steer_delay=delay)
    columns = dict(log.columns)
    columns["steering_norm"] = columns.pop("steer_cmd") / 0.6
    model = parse_model(f"[model]\nname = 'car'\n[inputs]\nsteer = 'steering_norm'\nlongitudinal = 'accel_cmd'\n{CAR}")
    found = diagnose({"log": Log(columns)}, model)
    assert found.names == (("steer_delay",) if delay else ())
    scale = found.input_map["steer_scale"]
    assert scale.low <= 0.6 <= scale.high
    assert scale.value == pytest.approx(0.6, rel=0.005)


def test_an_input_that_the_log_does_not_have_is_said_in_one_line() -> None:
    columns = dict(drive().columns)
    del columns["steer_cmd"]
    with pytest.raises(CompareError, match="steer_cmd") as told:
        diagnose({"log": Log(columns)}, baseline())
    assert "\n" not in str(told.value)


def test_every_name_of_an_answer_is_one_of_the_catalogue(weak_drive: Diagnosis) -> None:
    known = set(catalogue())
    assert set(weak_drive.names) <= known
    assert set(weak_drive.not_excited) <= known


@pytest.mark.nightly
def test_an_offset_of_the_lateral_accelerometer_is_named_beside_a_banked_road() -> None:
    log = drive()
    off = Log({**log.columns, "ay": log.columns["ay"] - 0.65})
    found = diagnose({"a.csv": off}, baseline())
    (effect,) = found.effects
    assert {effect.name, *effect.rivals} == {"lateral_accelerometer_bias", "road_bank"}
    bias = effect.parameters["b"]
    assert bias.low <= -0.65 <= bias.high


def on_a_circuit(*without: str, **effects: float) -> Log:
    columns = drive(seed=11, **effects).columns
    return Log({name: values for name, values in columns.items() if name not in without})


@pytest.mark.parametrize("without", [("yaw",), ("v",)])
def test_a_right_model_is_right_whatever_tells_the_motion(without: tuple[str, ...]) -> None:
    found = diagnose({"log": on_a_circuit(*without)}, baseline())
    assert (found.verdict, found.names) == ("NOTHING_MISSING", ())
    assert found.ladder[0].chi2_per_n < 1.2


def test_a_log_that_tells_no_speed_is_refused() -> None:
    with pytest.raises(CompareError, match="log: no speed for a model to start with"):
        diagnose({"log": on_a_circuit("v", "x", "y")}, baseline())


def test_a_measured_input_of_a_lower_rate_runs_straight_between_its_samples() -> None:
    t = 0.02 * np.arange(6)
    steer = np.array([0.1, np.nan, np.nan, 0.4, np.nan, np.nan])
    log = Log({"t": t, "steer": steer, "steer_cmd": steer})
    assert command_at_stamps(log, "steer", "it") == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.4, 0.4])
    assert command_at_stamps(log, "steer_cmd", "it") == pytest.approx([0.1, 0.1, 0.1, 0.4, 0.4, 0.4])


def test_logs_of_one_name_in_two_folders_are_two() -> None:
    a, b, c = (drive(seed=seed) for seed in (1, 2, 3))
    assert list(_together({"drive.csv": a}, {"drive.csv": b, "town.csv": c}).values()) == [a, b, c]
