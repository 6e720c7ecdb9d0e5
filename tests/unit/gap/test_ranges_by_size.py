"""Which values are usual on vehicles that are smaller than a car."""

from __future__ import annotations

import math

import pytest

from pytest_dvp.gap.diagnose.candidates import candidates, is_usual
from pytest_dvp.gap.diagnose.ranges_by_size import SHORTEST_CAR, usual_range
from vehicle.model.car import make_car
from vehicle.model.effect import Key
from vehicle.model.effect_catalogue import catalogue, find_effect
from vehicle.model.vehicle_model import Inputs, VehicleModel


@pytest.mark.parametrize("wheelbase", [SHORTEST_CAR, 2.7, 6.0])
def test_ranges_of_a_car_and_a_lorry_are_those_of_the_catalogue(wheelbase: float) -> None:
    for effect in catalogue().values():
        assert all(usual_range(key, wheelbase) == key for key in effect.parameters)


@pytest.mark.parametrize(
    ("unit", "low", "high"),
    [
        ("1/s^2", 1.0, 16.0),
        ("1/s", 1.0, 8.0),
        ("s", 0.5, 4.0),
        ("m", 0.25, 4.0),
        ("m/s^2", 1.0, 4.0),
        ("rad", 1.0, 4.0),
    ],
)
def test_of_a_quarter_of_the_length_times_are_half_as_long(unit: str, low: float, high: float) -> None:
    """Froude: a time goes with the root of a length. What is usual on a car stays so."""
    found = usual_range(Key("k", unit, 1.0, 4.0, neutral=0.0, least=0.1), 0.25 * SHORTEST_CAR)
    assert (found.low, found.high) == pytest.approx((low, high))


def test_no_range_goes_beyond_what_the_equation_allows_or_to_the_other_side_of_nothing() -> None:
    for effect in catalogue().values():
        for key in effect.parameters:
            found = usual_range(key, 0.1)
            assert min(key.minimum, key.low) <= found.low <= key.low
            assert key.high <= found.high <= max(key.maximum, key.high)
            if math.isfinite(key.neutral):
                assert (key.neutral <= key.low) == (key.neutral <= found.low)
                assert (key.neutral >= key.high) == (key.neutral >= found.high)


def test_a_search_looks_where_the_controller_of_a_small_robot_is() -> None:
    """5 /s^2 of a robot of 0.33 m, where the catalogue ends at 2 /s^2."""
    controller = find_effect("speed_controller")
    usual = {}
    for wheelbase in (0.33, 2.7):
        car = make_car({"wheelbase": wheelbase, "cg_to_front_axle": 0.5 * wheelbase, "mass": 4.0})
        model = VehicleModel("kinematic_bicycle", Inputs(longitudinal=("speed_cmd",)), car)
        (found,) = candidates(model, [controller])
        usual[wheelbase] = [is_usual(c.key, 5.0) for c in found.coordinates if c.key.name == "ki"]
    assert usual == {0.33: [True], 2.7: [False]}
