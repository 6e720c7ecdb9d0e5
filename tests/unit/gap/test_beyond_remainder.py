"""What both drives, or one of them alone, must show of an effect beside a known remainder: bounds from both sides."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.beyond_remainder import FAR, is_beyond_remainder, is_clear, is_evident, is_evident_apart
from pytest_dvp.gap.diagnose.held_out import Fold
from tests.unit.gap.linear_world import BRAKE, DRIVE, MOTOR, Limited, World, a_search, a_trial, direction
from vehicle.model.remainder_shape import RemainderShape

ALONE = a_trial(0.0, "drive_gain", values={DRIVE: 0.9})


@pytest.mark.parametrize(("alike", "evident"), [(0.55, True), (0.56, False)])
def test_what_its_companion_could_do_as_well_is_no_evidence(alike: float, evident: bool) -> None:
    """30 standard deviations with the companion as it is; 900 (1 - 0.556) are 20 once it may make up for it."""
    overlap = np.sqrt(alike)
    does = {DRIVE: 300.0 * direction(0), BRAKE: 300.0 * direction(1, 0, overlap)}
    world = World(does, {DRIVE: 0.9, BRAKE: 0.9}, excused=True)
    search = a_search(world, "drive_gain", "brake_gain")
    both = a_trial(0.0, "drive_gain", "brake_gain", values={DRIVE: 0.9, BRAKE: 0.9, MOTOR: 0.0})
    assert is_evident(search, both, "drive_gain", world) is evident  # type: ignore[arg-type]


@pytest.mark.parametrize(("gain", "evident"), [(401.0, True), (399.0, False)])
def test_an_effect_is_evident_twenty_standard_deviations_from_nothing(gain: float, evident: bool) -> None:
    world = World({DRIVE: 10.0 * np.sqrt(gain) * direction(0)}, {DRIVE: 0.9}, excused=True)
    search = a_search(world, "drive_gain")
    assert is_evident(search, ALONE, "drive_gain", world) is evident  # type: ignore[arg-type]
    less = World({DRIVE: 1000.0 * direction(0)}, {DRIVE: 0.92})  # it asks for 0.8 of the size, and gains 0.6 by all
    judges = (Fold(None, less),)  # type: ignore[arg-type]
    trial = search.trial(("drive_gain",), {DRIVE: 0.9})
    assert is_evident_apart(search, trial, "drive_gain", judges) is evident
    assert is_evident_apart(search, trial, "drive_gain", ()) is False
    other = Fold(world, world)  # type: ignore[arg-type]
    assert is_evident_apart(search, trial, "drive_gain", (other,)) is False
    for ten, enough in ((9.9, False), (10.1, True)):  # data held out may show it half as clearly
        town = World({DRIVE: 10.0 * ten / np.sqrt(0.6) * direction(0)}, {DRIVE: 0.92})
        told = is_evident_apart(search, trial, "drive_gain", (*judges, Fold(None, town)))  # type: ignore[arg-type]
        assert told is (evident and enough)
    world.model.effects = [SimpleNamespace(name="drive_gain", values={"g": 0.9})]  # the twin has it already
    assert is_evident(search, ALONE, "drive_gain", world) is False  # type: ignore[arg-type]


@pytest.mark.parametrize(("gain", "there", "told"), [(101.0, 0.907, True), (99.0, 0.907, False), (101.0, 0.908, False)])
def test_drives_that_ask_for_the_same_size_may_each_show_it_less_clearly(gain: float, there: float, told: bool) -> None:
    """Of 0.1 that is found, 0.093 there takes away 0.86 of what 0.1 changes, 0.092 takes 0.84."""
    world = World({DRIVE: 10.0 * np.sqrt(gain) * direction(0)}, {DRIVE: 0.9}, excused=True)
    search = a_search(world, "drive_gain")
    town = (Fold(None, World({DRIVE: 150.0 * direction(0)}, {DRIVE: there})),)  # type: ignore[arg-type]
    assert is_evident_apart(search, ALONE, "drive_gain", town) is told


@pytest.mark.parametrize(("imitated", "evident"), [(0.0232, True), (0.0233, False)])
def test_and_it_is_beyond_what_the_remainder_imitates(imitated: float, evident: bool) -> None:
    """4.3 times a root mean square of 0.0232 is 0.0998."""
    world = World({DRIVE: 1000.0 * direction(0)}, {DRIVE: 0.9}, excused=True)
    world.model.remainder_shape = RemainderShape(imitates={"drive_gain": {"g": imitated}})
    search = a_search(world, "drive_gain")
    assert is_evident(search, ALONE, "drive_gain", world) is evident  # type: ignore[arg-type]


@pytest.mark.parametrize(("imitated", "far"), [(0.0046, True), (0.0047, False), (0.0, False)])
def test_far_beyond_is_five_times_what_the_remainder_imitates(imitated: float, far: bool) -> None:
    """5 times 4.3 times 0.0047 is 0.101. Of an effect that no drive was asked for nothing is known."""
    world = World({DRIVE: 899.0 * direction(0)}, {DRIVE: 0.9}, excused=True)
    world.model.remainder_shape = RemainderShape(imitates={"drive_gain": {"g": imitated}})
    search = a_search(world, "drive_gain")
    assert is_clear(search, ALONE, "drive_gain", FAR) is far
    quiet_town = (Fold(None, World({DRIVE: direction(0)}, {DRIVE: 0.9})),)  # type: ignore[arg-type]
    assert is_beyond_remainder(search, ALONE, "drive_gain", quiet_town) is far
    telling = (Fold(None, world),)  # type: ignore[arg-type]
    assert is_beyond_remainder(search, ALONE, "drive_gain", telling) is True  # both data show it


@pytest.mark.parametrize(("there", "told"), [(0.924, True), (0.926, False)])
def test_data_held_out_must_ask_for_three_quarters_of_the_size(there: float, told: bool) -> None:
    """Of 0.1 that is found, 0.075 there takes away half of what 0.1 changes: 2 x 0.075 x 0.1 - 0.1^2 of 0.1^2."""
    world = World({DRIVE: 299.0 * direction(0)}, {DRIVE: 0.9}, excused=True)
    search = a_search(world, "drive_gain")
    town = (Fold(None, World({DRIVE: 1000.0 * direction(0)}, {DRIVE: there})),)  # type: ignore[arg-type]
    assert is_evident_apart(search, ALONE, "drive_gain", town) is told
    world.model.remainder_shape = RemainderShape(imitates={"drive_gain": {"g": 0.0046}})
    assert is_clear(search, ALONE, "drive_gain", FAR)
    assert is_beyond_remainder(search, ALONE, "drive_gain", town) is told
    parts = (Fold(world, town[0].judge),)  # a part of the drive is no other drive
    assert is_beyond_remainder(search, ALONE, "drive_gain", parts) is True


@pytest.mark.parametrize(("deviations", "told"), [(30.1, True), (29.9, False)])
def test_of_what_is_sure_where_it_is_fitted_data_held_out_may_ask_for_another_size(
    deviations: float, told: bool
) -> None:
    """Of 0.1 that is found, 0.06 there takes away a fifth of what 0.1 changes, 20 standard deviations squared."""
    world = World({DRIVE: 10.0 * deviations * direction(0)}, {DRIVE: 0.9}, excused=True)
    search = a_search(world, "drive_gain")

    def town(amount: float) -> tuple[Fold, ...]:
        return (Fold(None, World({DRIVE: amount * direction(0)}, {DRIVE: 0.94})),)  # type: ignore[arg-type]

    assert is_evident_apart(search, ALONE, "drive_gain", town(450.0)) is told
    assert is_evident_apart(search, ALONE, "drive_gain", town(226.0)) is told  # 10.1 standard deviations
    assert is_evident_apart(search, ALONE, "drive_gain", town(221.0)) is False
    other = World({DRIVE: 10.0 * deviations * direction(0)}, {DRIVE: 0.924}, excused=True)  # the fitted data agree
    assert is_evident_apart(a_search(other, "drive_gain"), ALONE, "drive_gain", town(450.0)) is False


@pytest.mark.parametrize(("deviations", "asks", "told"), [(90.1, 0.9, True), (89.9, 0.9, False), (150.0, 0.926, False)])
def test_what_is_far_beyond_doubt_data_held_out_need_not_show(deviations: float, asks: float, told: bool) -> None:
    """0.0077 is exceeded by three times 4.3, and so not far. What asks for 0.074 of 0.1 does not agree with itself."""
    world = World({DRIVE: 10.0 * deviations * direction(0)}, {DRIVE: asks}, excused=True)
    world.model.remainder_shape = RemainderShape(imitates={"drive_gain": {"g": 0.0077}})
    search = a_search(world, "drive_gain")

    def town(there: float) -> tuple[Fold, ...]:
        return (Fold(None, World({DRIVE: 110.0 * direction(0)}, {DRIVE: there})),)  # type: ignore[arg-type]

    assert is_beyond_remainder(search, ALONE, "drive_gain", town(0.949)) is told  # gains, but not by 10 deviations
    assert is_beyond_remainder(search, ALONE, "drive_gain", town(0.951)) is False  # loses
    assert is_beyond_remainder(search, ALONE, "drive_gain", ()) is told
    world.model.remainder_shape = RemainderShape()
    assert is_beyond_remainder(search, ALONE, "drive_gain", town(0.949)) is False


@pytest.mark.parametrize(("deviations", "told"), [(9.9, True), (10.1, False)])
def test_only_data_that_would_show_an_effect_contradict_it(deviations: float, told: bool) -> None:
    world = World({DRIVE: 1000.0 * direction(0)}, {DRIVE: 0.9}, excused=True)
    world.model.remainder_shape = RemainderShape(imitates={"drive_gain": {"g": 0.0046}})
    search = a_search(world, "drive_gain")
    none_there = World({DRIVE: 10.0 * deviations * direction(0)}, {DRIVE: 1.0})
    judges = (Fold(None, none_there),)  # type: ignore[arg-type]
    assert is_beyond_remainder(search, ALONE, "drive_gain", judges) is told


@pytest.mark.parametrize(("found", "evident"), [(7.6, True), (7.4, False), (None, True)])
def test_a_limit_is_beyond_the_remainder_if_it_is_lower_by_half(found: float | None, evident: bool) -> None:
    """On the drives that the twin was learnt from a fit found a limit of 7.5 m/s^2, say: 5 m/s^2 times 1.5."""
    lower = ("brake_limit", "limit")
    world = Limited({lower: 1000.0 * direction(0)}, {lower: 5.0}, excused=True)
    world.model.remainder_shape = RemainderShape(limits={"brake_limit": {"limit": found}} if found else {})
    trial = a_trial(1000.0, "brake_limit", values={lower: 5.0})
    assert is_evident(a_search(world, "brake_limit"), trial, "brake_limit", world) is evident  # type: ignore[arg-type]
