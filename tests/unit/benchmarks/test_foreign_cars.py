"""The cars in MuJoCo obey the mechanics that anyone can compute; their cases are repeatable."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="mujoco is not installed (extra foreign)")

from benchmarks.foreign_cars.ask import effective, total
from benchmarks.foreign_cars.car import CARS, data_sheet
from benchmarks.foreign_cars.case import cases
from benchmarks.foreign_cars.drive import driven
from benchmarks.foreign_cars.fleet import FLEET
from benchmarks.foreign_cars.given import given_total
from benchmarks.foreign_cars.hidden import RANGES, Controls, Values
from benchmarks.foreign_cars.tyres import FloatArray
from vehicle.model.effect_catalogue import catalogue
from vehicle.model.model_file import parse_model

HATCH = CARS["hatchback"]


def commanded(accel: float, steer: float, seconds: float, hidden: Values | None = None) -> dict[str, FloatArray]:
    n = round(seconds / 0.02)
    commands = np.column_stack([np.full(n, accel), np.full(n, steer)])
    return driven(HATCH, "rich", 1, hidden, duration=seconds, commands=commands)


@pytest.mark.nightly
def test_a_car_with_its_brakes_on_stays_where_it_is() -> None:
    log = commanded(-1.5, 0.0, 1.0)
    assert np.abs(log["x"][-1] - log["x"][10]) < 2e-3
    assert np.abs(log["v"]).max() < 0.05


@pytest.mark.parametrize(("hidden", "ratio"), [({}, 1.0), ({"mass": {"ratio": 1.25}}, 1.25)])
@pytest.mark.nightly(by_day=2)
def test_it_accelerates_by_force_over_mass(hidden: Values, ratio: float) -> None:
    """2 m/s^2 of the data sheet's mass, less rolling resistance; turning wheels add 3.7 % of the mass, and the loaded
    tyre, 15 mm flatter, gives 5 % more force: together within 4 %."""
    log = commanded(2.0, 0.0, 2.5, hidden)
    found = np.polyfit(log["t"][50:], log["v"][50:], 1)[0]
    assert found == pytest.approx(2.0 / ratio - HATCH.rolling * 9.81, rel=0.04)


def test_slowly_it_turns_as_its_geometry_says() -> None:
    log = commanded(0.6, 0.1, 4.0)
    rows = slice(100, 180)
    expected = log["v"][rows] * np.tan(0.1) / HATCH.wheelbase
    assert log["yaw_rate"][rows] == pytest.approx(expected, rel=0.04)


def test_a_van_on_trailing_arms_stands_level_and_turns_as_its_geometry_says() -> None:
    """Its wheels hang on arms and steer apart; slowly the middle of the axle rolls where the command points."""
    rests = np.column_stack([np.full(50, -1.5), np.zeros(50)])
    assert np.abs(driven(FLEET["van"], "rich", 1, duration=1.0, commands=rests)["ay"]).max() < 0.02
    commands = np.column_stack([np.full(200, 0.6), np.full(200, 0.3)])
    log = driven(FLEET["van"], "rich", 1, duration=4.0, commands=commands)
    rows = slice(100, 180)
    assert log["yaw_rate"][rows] == pytest.approx(log["v"][rows] * np.tan(0.3) / FLEET["van"].wheelbase, rel=0.04)


def test_same_seed_same_bytes() -> None:
    first, again = (driven(HATCH, "town", 5, duration=1.0) for _ in range(2))
    assert all(first[name].tobytes() == again[name].tobytes() for name in first)


def test_a_disc_that_was_braked_hot_loses_gain_and_cools() -> None:
    """1 m/s^2 at 10 m/s for 10 s: 100 J/kg, by which k = 0.01 halves the gain; after tau a 1/e of it is left."""
    controls = Controls({"brake_fade": {"k": 0.01, "tau": 1e6}})
    for _ in range(1000):
        controls.heat(1.0, 10.0, 0.01)
    assert controls.asked(-1.0, 0.0, 10.0)[0] == pytest.approx(-0.5, rel=1e-3)


def test_hidden_effects_have_the_names_and_keys_of_the_catalogue_and_lie_in_its_ranges() -> None:
    for name, keys in RANGES.items():
        effect = catalogue()[name]
        for key, (low, high) in keys.items():
            assert effect.key(key).low <= low < high <= effect.key(key).high, (name, key)


def test_the_cases_of_a_commit_are_its_own_and_every_data_sheet_is_a_model() -> None:
    assert [c.truth for c in cases("0000abcd")[:20]] == [c.truth for c in cases("0000abcd")[:20]]
    assert [c.truth for c in cases("0000abcd")[:20]] != [c.truth for c in cases("0000abce")[:20]]
    assert len({c.key for c in cases("0000abcd")}) == len(cases("0000abcd")) >= 300
    for car in CARS.values():
        assert parse_model(data_sheet(car)).car.wheelbase == car.wheelbase
        assert dataclasses.replace(car, payload=10.0) != car


def test_what_is_hidden_adds_to_what_the_twin_has_already() -> None:
    sheet = data_sheet(HATCH)
    for name, values in {"steer_delay": "T = 0.1", "drive_gain": "g = 0.9", "brake_limit": "limit = 3.0"}.items():
        sheet += f'[[effect]]\nname = "{name}"\n[effect.parameters]\n{values}\n'
    hidden = {
        "steer_delay": {"T": 0.2},
        "drive_gain": {"g": 0.8},
        "brake_limit": {"limit": 4.0},
        "mass": {"ratio": 1.2},
    }
    found = total(hidden, parse_model(sheet))
    assert found["steer_delay"]["T"] == pytest.approx(0.3)
    assert found["drive_gain"]["g"] == pytest.approx(0.72)
    assert found["brake_limit"]["limit"] == 3.0
    assert found["mass"] == {"ratio": 1.2}
    capped = parse_model(f'{data_sheet(HATCH)}[[effect]]\nname = "mass"\n[effect.parameters]\nratio = 0.8\n')
    assert total({"drive_torque_limit": {"limit": 2.0}}, capped)["drive_torque_limit"]["limit"] == pytest.approx(2.5)


def test_a_payload_counts_by_what_it_does_to_accelerations() -> None:
    """A quarter more weight on wheels that weigh 3.7 % of the car as turning mass: 1.287/1.037 = 1.241; tyres pressed
    flatter by 3 mm of 285 take 1 to 2 % of that."""
    assert effective(HATCH, {"mass": {"ratio": 1.25}})["mass"]["ratio"] == pytest.approx(1.225, abs=0.012)
    drag = effective(HATCH, {"aero_drag": {"k": 0.002}})["aero_drag"]["k"]
    assert drag == pytest.approx(0.002 / 1.037, rel=1e-3)
    assert effective(HATCH, {"gyro_bias": {"b": 0.01}}) == {"gyro_bias": {"b": 0.01}}


def test_a_dead_time_need_not_be_a_whole_number_of_samples() -> None:
    """A step of the steering that arrives 10 ms later: the yaw rate is behind by less than one of its samples of 20 ms
    changes it by, and by more than nothing."""
    commands = np.column_stack([np.full(100, 1.0), np.where(np.arange(100) < 60, 0.0, 0.1)])
    early, late = (
        driven(HATCH, "rich", 1, {"steer_delay": {"T": T}}, duration=2.0, commands=commands)["yaw_rate"]
        for T in (0.10, 0.11)
    )
    assert 0.3 < np.abs(early - late).max() / np.abs(np.diff(early)).max() < 0.7


def test_on_the_slope_of_a_hill_a_car_rolls_down_and_feels_the_slope() -> None:
    """Height 2 m, 20 m long: at its steepest place the ground falls by 2/20/sqrt(e) = 0.0607; without a command the car
    starts off by g sin less rolling resistance, of which its accelerometer shows the resistance alone."""
    hill = {"road_profile": {"height": 2.0, "x": -20.0, "y": 0.0, "length": 20.0}}
    log = commanded(0.0, 0.0, 2.0, hill)
    fall = 0.0607 / np.hypot(1.0, 0.0607)
    rolls = HATCH.rolling * 9.80665
    rate = np.polyfit(log["t"][50:], log["v"][50:], 1)[0]
    assert rate == pytest.approx(9.80665 * fall - rolls, rel=0.06)  # wheels turn with it, and the slope eases off
    assert log["ax"][50:].mean() == pytest.approx(-rolls, abs=0.05)


def test_of_a_car_that_is_given_places_and_widths_are_those_of_the_changed_car() -> None:
    added = {"gnss_lever_arm": "x = 0.6\ny = 0.1", "steer_backlash": "half_width = 0.001", "steer_delay": "T = 0.1"}
    text = "".join(f'[[effect]]\nname = "{name}"\n[effect.parameters]\n{values}\n' for name, values in added.items())
    twin = parse_model(data_sheet(HATCH) + text)
    hidden = {"gnss_lever_arm": {"x": 1.2}, "steer_backlash": {"half_width": 0.01}, "steer_delay": {"T": 0.2}}
    found = given_total(hidden, twin)
    assert found["gnss_lever_arm"] == {"x": 1.2}
    assert found["steer_backlash"] == {"half_width": 0.01}
    assert found["steer_delay"]["T"] == pytest.approx(0.3)
    assert given_total({}, twin) == {}
