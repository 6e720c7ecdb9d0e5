"""Effects that are often confused, asked in each other's place on all drives together."""

from __future__ import annotations

from math import sqrt
from typing import Any

import pytest

from pytest_dvp.gap.diagnose import tied_effects as module
from pytest_dvp.gap.diagnose.held_out import Fold
from pytest_dvp.gap.diagnose.tied_effects import best_of_tied, gained_apart
from tests.unit.gap.linear_world import BRAKE, DRIVE, NEUTRAL, World, a_search, direction

MASS = ("mass", "ratio")
NAMES = {"mass": MASS, "drive_gain": DRIVE}
RATIO = ("steer_ratio", "g")
LEFT, RIGHT = ("steer_asymmetry", "g_left"), ("steer_asymmetry", "g_right")


@pytest.fixture(autouse=True)
def one_drive(monkeypatch: pytest.MonkeyPatch) -> None:
    """All data together are those fitted on; the experiments of a world are the world."""
    monkeypatch.setattr(module, "ExperimentSet", lambda experiments, lasts: experiments[0])
    monkeypatch.setattr(module, "all_data", lambda search, judges: [search.target])


def a_world(does: Any, hidden: Any) -> World:
    found = World(does, hidden, excused=True)
    found.experiments = [found]  # type: ignore[list-item]
    return found


def judges() -> tuple[Fold, ...]:
    return (Fold(None, World({})),)  # type: ignore[arg-type]


def told(alike: float, named: str, hidden: Any, *, apart: bool = True) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """What is told of a car with a hidden mass or drive, where one explains `alike` of what the other does."""
    does = {MASS: 1000.0 * direction(1), DRIVE: -1000.0 * direction(0, 1, sqrt(alike))}
    search = a_search(a_world(does, hidden), "drive_gain", "mass", "brake_gain")
    final = search.trial((named,), NEUTRAL)
    found = best_of_tied(search, final, judges() if apart else ())
    return found.final.names, found.rivals


@pytest.mark.parametrize(("alike", "name"), [(1.0 / 1.04, "mass"), (1.0 / 1.02, "drive_gain")])
def test_what_is_tied_to_the_name_takes_its_place_if_it_explains_clearly_more(alike: float, name: str) -> None:
    names, rivals = told(alike, "drive_gain", {MASS: 1.1})
    assert names == (name,)
    assert rivals == (() if name == "mass" else ("mass",))


@pytest.mark.parametrize(("alike", "rivals"), [(0.987, ("drive_gain",)), (0.983, ())])
def test_what_explains_nearly_as_much_is_a_rival(alike: float, rivals: tuple[str, ...]) -> None:
    assert told(alike, "mass", {MASS: 1.1}) == (("mass",), rivals)


@pytest.mark.parametrize("simpler", ["mass", "drive_gain"])
@pytest.mark.parametrize(("alike", "near"), [(0.975, True), (0.965, False)])
def test_fewer_values_may_explain_three_per_cent_less(alike: float, near: bool, simpler: str) -> None:
    """The inertia of gears, which has two values, contains a mass, and no gain of the drive."""
    share = ("gear_inertia", "share")
    does = {share: 1000.0 * direction(1), NAMES[simpler]: 1000.0 * direction(0, 1, sqrt(alike))}
    search = a_search(a_world(does, {share: 0.1}), "gear_inertia", simpler)
    found = best_of_tied(search, search.trial(("gear_inertia",), NEUTRAL), judges())
    instead = near and simpler == "mass"
    assert found.final.names == ("mass" if instead else "gear_inertia",)
    assert found.rivals == (("gear_inertia" if instead else simpler,) if near else ())


def test_what_was_found_of_the_car_itself_holds_for_all_that_are_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where an accelerometer sits was fitted along; 200 standard deviations are off where that is forgotten."""
    place = ("parameters", "ay_x")
    monkeypatch.setitem(NEUTRAL, place, 0.0)
    does = {
        MASS: 1000.0 * direction(1),
        DRIVE: -1000.0 * direction(0, 1, sqrt(1.0 / 1.04)),
        place: 400.0 * direction(2),
    }
    search = a_search(a_world(does, {MASS: 1.1, place: 0.5}), "drive_gain", "mass")
    final = search.trial(("drive_gain",), NEUTRAL | {place: 0.5})
    found = best_of_tied(search, final, judges())
    assert (found.final.names, found.final.values[place]) == (("mass",), 0.5)


def test_nothing_is_asked_without_another_drive_or_of_a_set() -> None:
    assert told(0.9, "drive_gain", {MASS: 1.1}, apart=False) == (("drive_gain",), ())
    search = a_search(a_world({MASS: 1000.0 * direction(1), BRAKE: 500.0 * direction(2)}, {}), "mass", "brake_gain")
    both = search.trial(("mass", "brake_gain"), NEUTRAL)
    assert best_of_tied(search, both, judges()) == (both, ())


def test_what_is_not_tied_to_the_name_is_not_asked() -> None:
    does = {BRAKE: 1000.0 * direction(1), ("gyro_bias", "b"): 1e5 * direction(1)}
    search = a_search(a_world(does, {BRAKE: 0.9}), "brake_gain", "gyro_bias")
    final = search.trial(("brake_gain",), NEUTRAL)
    assert best_of_tied(search, final, judges()) == (final, ())


def test_what_lies_somewhere_or_means_nothing_takes_no_place(monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(module, "is_placed", lambda candidate: candidate.name == "mass")
        assert told(0.9, "drive_gain", {MASS: 1.1}) == (("drive_gain",), ())
    assert told(0.9, "drive_gain", {MASS: 1.1})[0] == ("mass",)
    monkeypatch.setattr(module.Search, "is_credible", lambda search, trial, name, target: False)
    assert told(0.9, "drive_gain", {MASS: 1.1}) == (("drive_gain",), ())


@pytest.mark.parametrize(
    ("right", "named", "names", "rivals"),
    [
        (0.9, "steer_asymmetry", ("steer_ratio",), ("steer_asymmetry",)),  # both sides alike: the simpler one
        (0.9, "steer_ratio", ("steer_ratio",), ()),  # what has more values explains a little more
        (0.95, "steer_asymmetry", ("steer_asymmetry",), ()),
        (0.95, "steer_ratio", ("steer_asymmetry",), ()),
    ],
)
def test_of_two_that_contain_each_other_the_simpler_one_is_told_if_it_explains_as_much(
    right: float, named: str, names: tuple[str, ...], rivals: tuple[str, ...]
) -> None:
    rows = [400.0 * direction(0), 400.0 * direction(1)]
    does = {LEFT: rows[0], RIGHT: rows[1], RATIO: rows[0] + rows[1]}
    search = a_search(a_world(does, {LEFT: 0.9, RIGHT: right}), "steer_ratio", "steer_asymmetry")
    found = best_of_tied(search, search.trial((named,), NEUTRAL), judges())
    assert (found.final.names, found.rivals) == (names, rivals)


def test_a_simpler_one_that_means_nothing_is_not_told(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = [400.0 * direction(0), 400.0 * direction(1)]
    does = {LEFT: rows[0], RIGHT: rows[1], RATIO: rows[0] + rows[1]}
    search = a_search(a_world(does, {LEFT: 0.9, RIGHT: 0.9}), "steer_ratio", "steer_asymmetry")
    monkeypatch.setattr(module.Search, "is_credible", lambda search, trial, name, target: name != "steer_ratio")
    final = search.trial(("steer_asymmetry",), NEUTRAL)
    assert best_of_tied(search, final, judges()) == (final, ())


def test_the_gain_of_other_drives_is_counted_on_all_of_them() -> None:
    search = a_search(a_world({DRIVE: 1000.0 * direction(0)}, {DRIVE: 0.9}), "drive_gain")
    trial = search.trial(("drive_gain",), NEUTRAL)
    apart = tuple(
        Fold(None, World({DRIVE: row * direction(0)}, {DRIVE: 0.9}))  # type: ignore[arg-type]
        for row in (300.0, 100.0)
    )
    assert gained_apart(trial, apart) == pytest.approx((30.0**2 + 10.0**2) / 2000.0, rel=0.01)
    assert gained_apart(trial, ()) == 0.0
