"""Two effects that hide each other: braking in bends loads the front axle and lets its wheels brake across the car."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.candidates import candidates
from pytest_dvp.gap.diagnose.experiment import experiment_set
from pytest_dvp.gap.diagnose.first_order_gain import FirstOrderGain
from pytest_dvp.gap.diagnose.masked_pairs import masked_pair, tied_pairs
from pytest_dvp.gap.diagnose.search import Search
from pytest_dvp.logs.log import Log
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.model_file import parse_model
from vehicle.model.open_loop import Replay

MODEL = parse_model(
    '[model]\nbase = "dynamic_bicycle"\n[parameters]\nwheelbase = 2.5\ncg_to_front_axle = 1.1\nmass = 1200.0\n'
    "yaw_inertia = 1500.0\ncornering_stiffness_front = 60000.0\ncornering_stiffness_rear = 60000.0\n"
)
TRUTH = {("axle_load_shift", "c"): 0.25, ("steered_wheel_forces", "brake"): 0.8}
NAMES = ("axle_load_shift", "steered_wheel_forces", "understeer", "load_transfer", "parallel_steering")
NOISE = {"x": 0.02, "y": 0.02, "yaw": 0.005, "v": 0.03, "yaw_rate": 0.005, "ax": 0.1, "ay": 0.1}


@pytest.fixture(scope="module")
def search() -> Search:
    """Drives and brakes by 3 m/s^2 every other four seconds while it steers to and fro."""
    t = np.arange(0.0, 40.0, 0.02)
    commands = {
        "accel_cmd": np.where(t % 8.0 < 4.0, 2.5, -2.5),
        "steer_cmd": 0.25 * np.sin(2.0 * np.pi * t / 5.3),
    }
    rows = Replay(MODEL, t, commands).run(TRUTH)
    rng = np.random.default_rng(5)
    measured = {name: rows[:, k] + sigma * rng.normal(size=len(t)) for k, (name, sigma) in enumerate(NOISE.items())}
    target = experiment_set({"log": Log({"t": t, **commands, **measured})}, MODEL)
    return Search(target, candidates(MODEL, [find_effect(name) for name in NAMES], ay=True))


def test_the_pair_is_found_together(search: Search) -> None:
    base = search.trial((), {})
    (found,) = masked_pair(search, base)
    assert set(found.names[-2:]) == {name for name, _ in TRUTH}
    for key, value in TRUTH.items():
        assert found.values[key] == pytest.approx(value, rel=0.15)
    assert not search.misfit(found)


def test_only_effects_that_are_alike_are_paired_and_one_of_them_is_a_detail(search: Search) -> None:
    pairs = {frozenset((a.name, b.name)) for a, b in tied_pairs(search.tried, ("parallel_steering",))}
    assert frozenset(("axle_load_shift", "steered_wheel_forces")) in pairs
    assert frozenset(("load_transfer", "understeer")) not in pairs  # alike, and both plain
    assert not any("parallel_steering" in pair for pair in pairs)  # it is in the set already


def test_an_effect_that_promises_nothing_is_looked_at_once(search: Search) -> None:
    look = FirstOrderGain(search.target, search.trial((), {}))
    candidate = search.tried["load_transfer"]
    every = look.remaining_chi2(candidate, candidate.points)
    assert look.remaining_chi2(candidate, candidate.points, needed=1.0) == every  # any gain will do
    once = look.remaining_chi2(candidate, candidate.points, needed=1e9)
    assert len(once) == 2 < len(every)  # with the accelerometer at the rear axle and at the centre of gravity
    assert [point for _, point in once] == list(candidate.points[-2:])
