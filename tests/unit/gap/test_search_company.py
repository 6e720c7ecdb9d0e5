"""What a search makes of effects beside others, on residuals that are linear in the values."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.unit.gap.linear_world import World, a_search, direction

DRIVE, BRAKE, MASS = ("drive_gain", "g"), ("brake_gain", "g"), ("mass", "ratio")


@pytest.mark.parametrize(("worst", "kept"), [(0.99, 1), (1.01, 2)])
def test_an_effect_is_dropped_if_no_more_than_noise_is_left_without_it(worst: float, kept: int) -> None:
    """A fragment of a twin's known remainder pays, too: 60 of 1,000 are more than 5 %."""
    world = World({DRIVE: 200.0 * direction(0), BRAKE: np.sqrt(60.0) * 10.0 * direction(1)}, {DRIVE: 0.9, BRAKE: 0.9},
                  channels={"v": worst})  # fmt: skip
    search = a_search(world, "drive_gain", "brake_gain")
    both = search.trial(("brake_gain", "drive_gain"), {DRIVE: 0.9, BRAKE: 0.9})
    assert len(search.pruned(both).names) == kept


def test_beside_another_effect_a_known_remainder_is_not_named_by_a_small_value() -> None:
    """It gains 101 of 1,000, which is worth a name for a value below the least size where there is no remainder."""
    world = World({DRIVE: np.sqrt(101.0) / 0.01 * direction(0), BRAKE: 100.0 * direction(1)}, {DRIVE: 0.99, BRAKE: 0.8})
    search = a_search(world, "drive_gain", "brake_gain")
    trial = search.trial(("brake_gain", "drive_gain"), {DRIVE: 0.99, BRAKE: 0.8})
    assert search._matters(trial, "drive_gain", world)  # type: ignore[arg-type]
    world.excused = True
    assert not search._matters(trial, "drive_gain", world)  # type: ignore[arg-type]


@pytest.mark.parametrize(("alike", "named"), [(0.95, "mass"), (0.85, "drive_gain")])
def test_of_two_that_do_nearly_the_same_the_one_with_a_value_that_is_met(alike: float, named: str) -> None:
    """Nobody meets a drive that gives 0.66 of what is asked, its range ends at 0.7. A payload does alike^2 of the same:
    of what is lost without the drive, 10 % may stay lost, not 28 %."""
    strong = 400.0
    world = World({DRIVE: strong * direction(0), MASS: -2.0 * strong * direction(1, 0, alike)}, {DRIVE: 0.66})
    found = a_search(world, "drive_gain", "mass").run()
    assert found.final.names == (named,)


def test_of_what_may_take_a_place_only_those_asked_for_are_fitted() -> None:
    """Both do in part what the drive does; asked for the mass, the brake is not fitted."""
    does = {DRIVE: 300.0 * direction(0), MASS: 300.0 * direction(1, 0, 0.8), BRAKE: 300.0 * direction(2, 0, 0.7)}
    search = a_search(World(does, {DRIVE: 0.9}), "drive_gain", "mass", "brake_gain")
    best = search.trial(("drive_gain",), {DRIVE: 0.9})
    every = {trial.names: trial for trial in search.in_place_of(best, "drive_gain")}
    assert set(every) == {("mass",), ("brake_gain",)}
    (only,) = search.in_place_of(best, "drive_gain", ("mass",))
    assert only.names == ("mass",)
    assert only.chi2 == pytest.approx(every[only.names].chi2)


@pytest.mark.parametrize(("motor", "values"), [(0.0, 1), (0.19, 1), (0.21, 2)])
def test_a_value_that_comes_late_has_a_price_once_it_is_worth_a_name(motor: float, values: int) -> None:
    """A motor that takes over 0.2 m/s^2 is; each value costs 0.005 of chi^2/N."""
    search = a_search(World({BRAKE: 300.0 * direction(0)}, {BRAKE: 0.9}), "brake_gain")
    trial = search.trial(("brake_gain",), {BRAKE: 0.9})
    trial = dataclasses.replace(trial, values={**trial.values, ("brake_gain", "motor"): motor})
    assert search.cost(trial) - trial.chi2 == pytest.approx(0.005 * max(1000.0, trial.chi2) * values)
