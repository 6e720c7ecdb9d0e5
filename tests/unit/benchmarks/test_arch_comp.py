"""The rebuilt models answer as their originals did, requirements as by hand, and a search stops where it should."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from benchmarks.arch_comp import cars, transmission
from benchmarks.arch_comp.problems import PROBLEMS, Model, Problem
from benchmarks.arch_comp.robustness import always, eventually, implies
from benchmarks.arch_comp.table import table, written_into
from benchmarks.arch_comp.trial import METHODS, Ground, Trial, tried
from pytest_dvp.campaigns.sampling import sample
from pytest_dvp.tuning.searchers import search_names

NAMED = {problem.name: problem for problem in PROBLEMS}


def at_full_throttle(seconds: float) -> np.ndarray:
    count = round(seconds / 0.01) + 1
    return transmission.drive(np.full(count, 100.0), np.zeros(count))


def test_full_throttle_is_as_fast_as_in_the_original_model() -> None:
    """Two tools tell what the Simulink model does: STGEM's README of `at`, and FalStar's least robustness of 30 s."""
    trace = at_full_throttle(30.0)
    assert trace[0, :2001].max() == pytest.approx(120.21327149261522, rel=1e-12)
    assert trace[1].max() == pytest.approx(4768.277187862124, rel=1e-12)
    assert 120.0 - trace[0].max() == pytest.approx(-17.980199361426514, rel=1e-12)


def test_the_engine_speeds_up_as_zlscheck_traced_it() -> None:
    """Its first step by Euler's rule: from 1000 to 1105.07 rpm, and to 0.0515369 mph with friction at standstill."""
    engine, wheel = transmission.rates(1000.0, 0.0, 100.0, 0.0, 1)
    assert 1000.0 + 0.01 * engine == pytest.approx(1105.07, abs=0.01)
    friction = 40.0 / transmission.VEHICLE_INERTIA
    assert 0.01 * (wheel - friction) * transmission.MPH == pytest.approx(0.0515369, rel=1e-5)


@pytest.mark.parametrize(
    ("throttle", "speed", "torque"),
    [(50.0, 2000.0, 275.0), (45.0, 1800.0, 254.25), (0.0, 600.0, -38.0), (100.0, 5200.0, 245.0)],
    ids=["a point", "between four", "below the table", "above the table"],
)
def test_the_torque_map_goes_on_linearly(throttle: float, speed: float, torque: float) -> None:
    assert transmission.engine_torque(throttle, speed) == pytest.approx(torque)


def test_a_steady_drive_balances_torques_and_makes_no_power() -> None:
    """By hand: what the engine gives the impeller takes, and what is left after the converter carries the load."""
    trace = transmission.drive(np.full(30001, 50.0), np.zeros(30001))
    speed, engine, gear = trace[:, -1]
    wheel = speed / transmission.MPH
    assert transmission.rates(engine, wheel, 50.0, 0.0, int(gear)) == pytest.approx((0.0, 0.0), abs=1e-3)
    given = transmission.engine_torque(50.0, engine) * engine
    taken = (40.0 + 0.02 * speed * speed) * wheel
    assert 0.8 * given < taken < given


def test_more_throttle_is_faster_and_more_brake_slower() -> None:
    count = 3001
    by_throttle = [
        transmission.drive(np.full(count, u), np.zeros(count))[0, -1] for u in (10.0, 20.0, 40.0, 70.0, 100.0)
    ]
    by_brake = [transmission.drive(np.full(count, 60.0), np.full(count, u))[0, -1] for u in (0.0, 50.0, 150.0, 325.0)]
    assert by_throttle == sorted(by_throttle)
    assert by_brake == sorted(by_brake, reverse=True)


def test_gears_change_by_one_and_only_when_the_logic_looks() -> None:
    rng = np.random.default_rng(5)
    for _ in range(20):
        trace = NAMED["AT1"].trace(rng.random(12) * np.repeat([100.0, 325.0], 6))
        changed = np.flatnonzero(np.diff(trace[2])) + 1
        assert set(np.abs(np.diff(trace[2]))) <= {0.0, 1.0}
        assert (changed % transmission.TICK == 0).all()
        assert (trace[1] >= transmission.SLOWEST).all()


def test_the_first_car_moves_by_its_equation() -> None:
    t = np.arange(1001) * cars.STEP
    pushed = cars.drive(np.ones(1001), np.zeros(1001))[0]
    braked = cars.drive(np.ones(1001), np.ones(1001))[0]
    assert pushed == pytest.approx(-t * t / 2.0, abs=1e-9)
    assert braked == pytest.approx(-(t - 1.0 + np.exp(-t)), abs=1e-9)


def test_the_second_car_starts_when_the_gap_is_15() -> None:
    """The first is t^2 / 4 away, so after the root of 20 s."""
    trace = cars.drive(np.full(1001, 0.5), np.zeros(1001))
    start = np.flatnonzero(trace[1] < 10.0)[0] * cars.STEP
    assert math.sqrt(20.0) <= start <= math.sqrt(20.0) + cars.STEP
    assert (trace[2, : round(start / cars.STEP)] == 20.0).all()


def pieces(*given: tuple[float, float, float]) -> tuple[np.ndarray, np.ndarray]:
    t = np.arange(10001) * cars.STEP
    first = np.searchsorted([begin for begin, _, _ in given], t + 1e-9, side="right") - 1
    return np.array([u for _, u, _ in given])[first], np.array([b for _, _, b in given])[first]


@pytest.mark.parametrize(
    ("given", "robustness"),
    [
        ([(0.0, 0.5, 0.0), (50.0, 1.0, 1.0)], -44.12514924482045),
        ([(0.0, 0.625, 0.0), (100.0 / 3.0, 1.0, 1.0)], -50.6333863126072),
        ([(0.0, 0.0, 0.75), (100.0 / 3.0, 1.0, 0.0), (250.0 / 3.0, 0.625, 1.0)], -126.66473561055363),
    ],
)
def test_cars_fall_apart_as_in_the_original_model(given: list[tuple[float, float, float]], robustness: float) -> None:
    """FalStar's results of CC1 on cars.mdl, whose solver has a relative tolerance of 1e-3."""
    trace = cars.drive(*pieces(*given))
    assert 40.0 - (trace[4] - trace[3]).max() == pytest.approx(robustness, rel=3e-3)


def test_cars_that_stand_violate_cc2_by_5_as_in_the_original_model() -> None:
    margin = NAMED["CC2"].margin(cars.drive(*pieces((0.0, 0.0, 1.0), (50.0, 0.5, 0.0))))
    assert 15.0 * margin[0] == pytest.approx(-5.0)


def test_windows_by_hand() -> None:
    margin = np.array([3.0, 1.0, 4.0, 1.5, -2.0, 6.0])
    assert always(margin, 0.0, 2.0, 1.0).tolist() == [1.0, 1.0, -2.0, -2.0, -2.0, 6.0]
    assert eventually(margin, 1.0, 2.0, 1.0).tolist() == [4.0, 4.0, 1.5, 6.0, 6.0, -math.inf]
    assert implies(np.array([1.0, -3.0]), np.array([0.5, -1.0])).tolist() == [0.5, 3.0]


def test_windows_are_those_of_the_definition() -> None:
    rng = np.random.default_rng(1)
    for _ in range(50):
        margin = rng.normal(size=rng.integers(1, 40))
        begin, length = rng.integers(0, 12, 2)
        expected = [min(margin[k + begin : k + begin + length + 1], default=math.inf) for k in range(len(margin))]
        assert always(margin, begin * 0.1, (begin + length) * 0.1, 0.1).tolist() == expected


def test_at5_counts_a_gear_that_is_left_too_soon() -> None:
    gear = np.full(3261, 1.0)
    gear[1000:1251] = 2.0  # 2.5 s and a sample: long enough
    assert NAMED["AT52"].margin(np.vstack([gear, gear, gear]))[0] == 0.5
    gear[1250] = 1.0
    gear[1240:1250] = 1.0
    assert NAMED["AT52"].margin(np.vstack([gear, gear, gear]))[0] == -0.5


@pytest.mark.parametrize(("rpm", "margin"), [(2999.0, -1.0 / 3000.0), (2400.0, -0.1), (3300.0, 0.1)])
def test_at6_holds_where_the_engine_was_loud_or_the_car_slow(rpm: float, margin: float) -> None:
    """38.5 mph within 4 s are a tenth too many; the greater of both margins counts."""
    trace = np.vstack([np.full(3001, 38.5), np.full(3001, rpm), np.ones(3001)])
    assert NAMED["AT6a"].margin(trace)[0] == pytest.approx(margin)
    assert NAMED["AT6abc"].margin(trace)[0] == pytest.approx(margin)


def test_a_piece_of_an_input_lasts_5_s_and_the_last_one_to_the_end() -> None:
    seen: list[np.ndarray] = []

    def remember(throttle: np.ndarray, brake: np.ndarray) -> np.ndarray:
        seen.extend((throttle, brake))
        return np.vstack([throttle, brake])

    problem = Problem("", Model(remember, (1.0, 1.0), 2), 12.0, "", lambda x: x[0])
    problem.trace(np.array([0.1, 0.2, 0.3, 0.4]))
    throttle, brake = seen
    assert (throttle[499], throttle[500], throttle[1200], brake[0], brake[1000]) == (0.1, 0.2, 0.2, 0.3, 0.4)


def corner(share: float) -> Problem:
    """Fails where both inputs are in the upper share of their ranges; a slope leads there."""
    model = Model(lambda throttle, brake: np.vstack([throttle, brake]), (1.0, 2.0), 1)
    return Problem("corner", model, 0.0, "", lambda x: 1.0 - share - np.minimum(x[0], x[1] / 2.0))


def test_chance_stops_at_its_first_failure() -> None:
    points = sample("random", Ground(corner(0.2), 1).space.axes, 100, 3)
    first = next(k for k, at in enumerate(points, 1) if min(at) > 0.8)
    one = tried(corner(0.2), "random", 3, 100)
    assert (one.found, one.least < 0.0) == (first, True)


@pytest.mark.parametrize("alone", [False, True])
@pytest.mark.parametrize("method", ["cross_entropy", "descent", "bandit"])  # the others load packages of seconds
def test_a_search_repeats_itself_and_keeps_its_budget(method: str, alone: bool) -> None:
    driven: list[int] = []

    def margin(trace: np.ndarray) -> np.ndarray:
        driven.append(1)
        return corner(-0.5).margin(trace)

    never = dataclasses.replace(corner(-0.5), margin=margin)
    one = tried(never, method, 4, 30, alone=alone)
    assert (len(driven), one.found, one.least > 0.0) == (30, None, True)
    found = [tried(corner(0.3), method, 4, 60, alone=alone).found for _ in range(2)]
    assert found[0] == found[1] is not None


def test_the_methods_are_searchers_of_a_campaign() -> None:
    assert {*METHODS} - {"random"} <= {*search_names()}


def test_the_table_counts_only_what_falsified() -> None:
    trials = [Trial("AT1", "random", k, found, -0.1, 1.0) for k, found in enumerate((10, None, 30, 50))]
    rows = table([*trials, Trial("AT1", "bandit", 0, None, 0.1, 1.0)]).splitlines()
    assert rows[2] == "| AT1 | 3 of 4; 30.0, 30 | 0 of 1 | 50 of 50; 2.3 |"
    assert rows[3] == "| falsified in all | 3 of 4 | 0 of 1 |  |"


def test_the_table_replaces_what_stands_between_its_marks() -> None:
    assert written_into("a\n<!-- x -->\nold\n<!-- /x -->\nb", "x", "new") == "a\n<!-- x -->\nnew\n<!-- /x -->\nb"
