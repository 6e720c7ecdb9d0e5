"""Units of columns that `dvp map` chooses together."""

from __future__ import annotations

from pytest_dvp.recognition.unit_choice import Relation, choose

FASTEST = 100.0  # m/s


def limit(fastest: float) -> Relation:
    """The largest number of the column `v`, which is a car's."""
    return Relation("", fastest, 0.3, {"v": -1.0}, FASTEST, upper=True)


def speed_by_way(ratio: float) -> Relation:
    """The numbers of `v` over the way between the numbers of `x` a second."""
    return Relation("", ratio, 0.02, {"x": 1.0, "v": -1.0})


def test_numbers_of_a_car_in_millimetres_are_in_millimetres() -> None:
    found = choose({"x": "m", "v": "m/s"}, {}, [speed_by_way(1.0), limit(18_000.0)])
    assert {name: one.unit for name, one in found.items()} == {"x": "mm", "v": "mm/s"}


def test_what_no_unit_makes_the_speed_of_a_car_is_not_decided() -> None:
    found = choose({"x": "m", "v": "m/s"}, {}, [speed_by_way(1.0), limit(1e9)])
    assert not found["v"].decided


def test_numbers_of_a_car_in_metres_stay_decided() -> None:
    found = choose({"x": "m", "v": "m/s"}, {}, [speed_by_way(1.0), limit(18.0)])
    assert {name: (one.unit, one.decided) for name, one in found.items()} == {"x": ("m", True), "v": ("m/s", True)}
