"""The null line: what the search would find where there is nothing to find."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.candidates import Candidate, candidates
from pytest_dvp.gap.diagnose.chance_gain import _pieces, _surrogates, chance_gain
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, experiment_set
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from tests.truth.effects import Effects, TruthCar
from tests.truth.generate import make_log
from vehicle.model.effect_catalogue import catalogue
from vehicle.model.model_file import read_model
from vehicle.model.vehicle_model import VehicleModel

CAR = TruthCar()


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> VehicleModel:
    path: Path = tmp_path_factory.mktemp("null") / "model.toml"
    path.write_text(
        f'[model]\nbase = "kinematic_bicycle"\n[parameters]\nwheelbase = {CAR.wheelbase}\nmass = {CAR.mass}\n'
        f"cg_to_front_axle = {CAR.cg_to_front_axle}\nyaw_inertia = {CAR.yaw_inertia}\n"
    )
    return read_model(path)


def target(model: VehicleModel, effects: Effects) -> ExperimentSet:
    return experiment_set({"urban": Log(make_log(effects, "urban", 4, "mid"))}, model)


def tried(model: VehicleModel) -> tuple[Candidate, ...]:
    """A tenth of the catalogue would do for the principle; these act on every channel."""
    some = ("drive_lag", "brake_gain", "aero_drag", "road_grade", "steer_delay", "steer_offset", "understeer",
            "gyro_bias", "accelerometer_bias", "roll", "gnss_lever_arm", "wheel_radius")  # fmt: skip
    return candidates(model, [catalogue()[name] for name in some])


@pytest.fixture(scope="module")
def noise(model: VehicleModel) -> ExperimentSet:
    return target(model, {})


def test_of_white_noise_next_to_nothing_can_be_bought(model: VehicleModel, noise: ExperimentSet) -> None:
    """The best of m independent directions takes the largest of m squares of standard normals away: with m from 5 to
    100 its 95 % quantile is 6.6 to 12.1, of N samples. Drift of the positions is a little more than noise: 4 to 40."""
    line = chance_gain(noise, {}, tried(model))
    assert 4.0 / noise.count < line < 40.0 / noise.count


def test_a_real_effect_gains_more_than_luck(model: VehicleModel) -> None:
    late = target(model, {"steer_delay": {"T": 0.2}})
    before, after = late.whitened({}), late.whitened({("steer_delay", "T"): 0.2})
    gain = float(before @ before - after @ after) / late.count
    assert gain > 3.0 * chance_gain(late, {}, tried(model))


def test_a_slow_error_of_the_same_size_buys_more_than_a_white_one(model: VehicleModel) -> None:
    """What is left of a fading brake is slow, like what effects do."""
    slow = target(model, {"brake_fade": {"drop": 0.6, "heat": 60.0}})
    chi2 = float(slow.whitened({}) @ slow.whitened({})) / slow.count
    assert chance_gain(slow, {}, tried(model)) > 3.0 * chi2 * 12.1 / slow.count


def test_surrogate_keeps_the_spectrum_of_every_channel_and_segment(noise: ExperimentSet) -> None:
    r = noise.whitened({})
    pieces = _pieces(noise)
    twins = _surrogates(r, pieces, 3)
    for piece in pieces[:20]:
        own = piece[r[piece] != 0.0]
        assert np.abs(np.fft.rfft(twins[1, own])) == pytest.approx(np.abs(np.fft.rfft(r[own])), rel=1e-6, abs=1e-9)
    assert not twins[:, r == 0.0].any()


def test_surrogates_differ_from_the_error_and_from_each_other(noise: ExperimentSet) -> None:
    r = noise.whitened({})
    twins = _surrogates(r, _pieces(noise), 2)

    def alike(a: FloatArray, b: FloatArray) -> float:
        return abs(float(a @ b)) / float(r @ r)

    assert max(alike(twins[0], r), alike(twins[1], r), alike(twins[0], twins[1])) < 0.05


def test_fitted_parameters_are_taken_out(model: VehicleModel, noise: ExperimentSet) -> None:
    """A direction that is fitted already can buy nothing more."""
    point = {("steer_offset", "offset"): 0.01}
    (whole,) = (c for c in tried(model) if c.name == "steer_offset")
    only = [dataclasses.replace(whole, points=(point,), coarse=(point,))]
    along = noise.whitened(point) - noise.whitened({})
    assert chance_gain(noise, {}, only, jacobian=along[None, :]) < 1e-6 * chance_gain(noise, {}, only)


def test_same_question_same_answer(model: VehicleModel, noise: ExperimentSet) -> None:
    some = tried(model)
    assert chance_gain(noise, {}, some) == chance_gain(noise, {}, some) > 0.0
