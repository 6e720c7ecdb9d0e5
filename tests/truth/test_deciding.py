"""An advised manoeuvre, driven by a truth car that shares nothing with the kernel, leaves the truth alone."""

from __future__ import annotations

import pytest

from benchmarks.hidden_effects.case import Case
from benchmarks.hidden_effects.deciding import ENVELOPE, advised, driven, sets
from benchmarks.hidden_effects.truth import question
from pytest_dvp.gap.diagnose.diagnose import diagnose
from pytest_dvp.gap.manoeuvres.advice import advise
from pytest_dvp.gap.manoeuvres.catalogue import MANOEUVRES, chosen
from pytest_dvp.gap.manoeuvres.simulated_drive import perform
from tests.truth.effects import TruthCar
from vehicle.model.car import make_car
from vehicle.model.vehicle_model import Inputs, VehicleModel


@pytest.mark.nightly
def test_a_delay_taken_for_a_lag_in_town_is_alone_after_the_advised_drive() -> None:
    asked = question(Case("urban", ("steer_delay",), 3, "low", base_seed=3000))
    assert asked is not None
    town = diagnose(asked.logs, asked.model)
    (before,) = sets(town)
    assert {"steer_delay", "steer_lag"} <= before, "else there is nothing to decide"
    drives = chosen(["sine_sweep", "circles_left", "full_throttle"])
    advice = advise(town, asked.logs, asked.model, ENVELOPE, exciting=False, manoeuvres=drives)
    (choice,) = advice.deciding.values()
    after = diagnose({**asked.logs, **advised(asked.truth, choice, "low", 11)}, asked.model)
    assert sets(after) == [{"steer_delay"}]


@pytest.mark.parametrize("name", ["circles_left", "brake_ramps"])
def test_the_truth_car_and_the_model_drive_the_same_manoeuvre_alike(name: str) -> None:
    """Nothing hidden, no noise: two integrators, one driver. Within 5 cm and 2 cm/s all along, in the closed loop."""
    car = TruthCar()
    known = {key: getattr(car, key) for key in ("wheelbase", "cg_to_front_axle", "mass", "yaw_inertia")}
    manoeuvre = next(m for m in MANOEUVRES if m.name == name)
    truth = driven({}, manoeuvre, "none", 1)
    model = perform(manoeuvre, VehicleModel("kinematic_bicycle", Inputs(), make_car(known)), {}, ENVELOPE)
    assert model is not None
    n = min(len(truth.t), len(model.t))
    assert abs(len(truth.t) - len(model.t)) <= 5
    for k, (column, most) in enumerate({"x": 0.05, "y": 0.05, "yaw": 0.02, "v": 0.02}.items()):
        assert abs(truth.columns[column][:n] - model.motion[:n, k]).max() < most
