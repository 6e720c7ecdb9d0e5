"""diagnose on logs of the truth car, which shares nothing with the model that is diagnosed."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.diagnose import diagnose
from pytest_dvp.gap.diagnose.diagnosis import Diagnosis
from pytest_dvp.logs.log import Log
from tests.truth.effects import Effects, TruthCar, typical
from tests.truth.generate import make_log
from vehicle.model.model_file import parse_model
from vehicle.surrogate.driver import Drive

CAR = TruthCar()
MODEL = parse_model(
    f"[model]\nname = 'car'\n[parameters]\nwheelbase = {CAR.wheelbase}\nmass = {CAR.mass}\n"
    f"cg_to_front_axle = {CAR.cg_to_front_axle}\nyaw_inertia = {CAR.yaw_inertia}\n"
)
DELAY: Effects = {"steer_delay": {"T": 0.15}}
GAIN: Effects = {"drive_gain": {"g": 0.85}}


def told(effects: Effects, drive: Drive = "rich", *, seconds: float = 120.0) -> Diagnosis:
    """What one drive of this car says."""
    columns = make_log(effects, drive, 5, "mid")
    rows = columns["t"] < seconds
    log = Log({name: np.ascontiguousarray(values[rows]) for name, values in columns.items()})
    return diagnose({drive: log}, MODEL)


@pytest.mark.nightly
def test_two_hidden_effects_are_named_in_the_order_of_what_they_explain() -> None:
    found = told({**DELAY, **GAIN})
    assert (found.verdict, found.names) == ("NAMED", ("steer_delay", "drive_gain"))
    assert found.ladder[-1].chi2_per_n == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("left", [DELAY, GAIN], ids=lambda effects: next(iter(effects)))
@pytest.mark.nightly(by_day=2)
def test_an_effect_switched_off_in_the_car_disappears_from_the_answer(left: Effects) -> None:
    found = told(left, seconds=80.0)
    assert (found.verdict, found.names) == ("NAMED", tuple(left))


@pytest.mark.nightly
def test_a_gentle_town_drive_tells_a_delay_from_nothing_but_not_from_a_lag() -> None:
    found = told(DELAY, "urban")
    assert found.verdict == "AMBIGUOUS"
    (effect,) = found.effects
    assert {effect.name, *effect.rivals} == {"steer_delay", "steer_lag"}


@pytest.mark.nightly
def test_tyres_that_slip_come_with_the_place_that_had_to_be_assumed_for_the_accelerometer() -> None:
    """The truth car measures at the rear axle; a model that does not say where is tried at both usual places."""
    found = told({"understeer": {"K": 0.004}})
    assert (found.verdict, found.names) == ("NAMED", ("understeer",))
    estimate = found.effects[0].parameters["K"]
    assert estimate.low <= 0.004 <= estimate.high
    assert found.car == {"ay_x": 0.0}


@pytest.mark.nightly
def test_effects_that_need_no_tyres_assume_nothing_about_the_car() -> None:
    assert told(GAIN, "urban").car == {}


@pytest.mark.nightly
def test_an_effect_of_no_library_leaves_a_misfit_that_is_said_and_described() -> None:
    found = told({"converter_gain": typical("converter_gain")})
    assert found.verdict in ("UNKNOWN", "PARTIAL")
    assert found.ladder[-1].chi2_per_n > 1.3
    assert found.signature
