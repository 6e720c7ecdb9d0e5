"""A part of an actuator that stands for all of it is parted, and what stood for a missing part goes."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.candidates import candidates
from pytest_dvp.gap.diagnose.experiment import experiment_set
from pytest_dvp.gap.diagnose.search import Search
from pytest_dvp.gap.diagnose.whole_actuators import whole_actuators
from pytest_dvp.logs.log import Log
from tests.unit.gap.test_masked_pairs import MODEL, NOISE
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.open_loop import Replay

STEERING = {("steer_delay", "T"): 0.05, ("steer_lag", "tau"): 0.15, ("steer_rate_limit", "limit"): 0.6}


def steers(truth: dict[tuple[str, str], float], *more: str) -> Search:
    """Steps of the wheel angle by up to 0.25 rad, two seconds each, at 5 to 9 m/s."""
    t = np.arange(0.0, 60.0, 0.02)
    steps = np.random.default_rng(3).uniform(-0.25, 0.25, 30)
    commands = {"accel_cmd": np.where(t % 8.0 < 4.0, 1.0, -1.0), "steer_cmd": steps[(t // 2.0).astype(int)]}
    rows = Replay(MODEL, t, commands).run(truth)
    rng = np.random.default_rng(6)
    measured = {name: rows[:, k] + sigma * rng.normal(size=len(t)) for k, (name, sigma) in enumerate(NOISE.items())}
    target = experiment_set({"log": Log({"t": t, **commands, **measured})}, MODEL)
    names = [*(name for name, _ in STEERING), *more]
    return Search(target, candidates(MODEL, [find_effect(name) for name in names], ay=True))


def test_a_dead_time_that_stands_for_a_whole_actuator_is_parted() -> None:
    search = steers(STEERING)
    alone = search.trial(("steer_delay",), {("steer_delay", "T"): 0.15})
    assert search.misfit(alone)
    (found,) = whole_actuators(search, alone)
    assert set(found.names) == {name for name, _ in STEERING}
    for key, value in STEERING.items():
        assert found.values[key] == pytest.approx(value, rel=0.1)


def test_where_the_actuator_has_no_more_nothing_is_added() -> None:
    search = steers({("steer_delay", "T"): 0.15})
    assert list(whole_actuators(search, search.trial(("steer_delay",), {("steer_delay", "T"): 0.15}))) == []
    assert list(whole_actuators(search, search.trial((), {}))) == []  # nothing of it is named


def test_what_stood_for_the_missing_part_goes() -> None:
    """A yaw rate that is shown late looks like a steering that is late, but for the position."""
    search = steers({("steer_delay", "T"): 0.2, ("steer_rate_limit", "limit"): 0.6}, "yaw_rate_latency")
    start = {("yaw_rate_latency", "T"): 0.15, ("steer_rate_limit", "limit"): 0.6}
    stood = search.trial(("yaw_rate_latency", "steer_rate_limit"), start)
    (found,) = whole_actuators(search, stood)
    assert set(found.names) == {"steer_delay", "steer_rate_limit"}
    assert found.values["steer_delay", "T"] == pytest.approx(0.2, abs=0.02)  # a sample
