"""Effects that are added to a set because a known remainder hides them by their size, and what they make up for."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose import quiet_effects
from pytest_dvp.gap.diagnose.beyond_remainder import shown_by
from pytest_dvp.gap.diagnose.changing_set import refined
from pytest_dvp.gap.diagnose.first_order_gain import FirstOrderGain
from pytest_dvp.gap.diagnose.held_out import Fold
from pytest_dvp.gap.diagnose.quiet_effects import quiet, single
from pytest_dvp.gap.diagnose.search import Search
from tests.unit.gap.linear_world import BRAKE, DRIVE, NEUTRAL, World, a_search, a_trial, direction, given
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.remainder_shape import RemainderShape

RATIO, LEFT, RIGHT = ("steer_ratio", "g"), ("steer_asymmetry", "g_left"), ("steer_asymmetry", "g_right")
SHARE = ("front_wheel_speed", "share")  # 0 to 1, and nothing else is possible


def hidden_by_size(does: Any, hidden: Any) -> World:
    """A drive whose twin's remainder imitates a gain of the drive of 0.9, which is named already."""
    found = World(does, hidden, excused=True)
    found.model.remainder_shape = RemainderShape(imitates={"drive_gain": {"g": 0.05}})
    return found


def town(does: Any, hidden: Any) -> tuple[Fold, ...]:
    return (Fold(None, World(does, hidden)),)  # type: ignore[arg-type]


# --- sets that grow


@pytest.mark.parametrize(
    ("here", "there", "told"),
    [
        (400.0, 0.0, "brake_gain"),  # the ratio, which gains more in all, 40^2, does nothing in town
        (300.0, 110.0, "brake_gain"),  # 30^2 + 11^2 is less than 25^2 + 25^2
        (300.0, 210.0, "steer_ratio"),  # 30^2 + 21^2 is more
    ],
)
def test_beside_a_named_effect_the_new_one_is_what_all_drives_gain_most_by(
    here: float, there: float, told: str
) -> None:
    does = {DRIVE: 500.0 * direction(0), RATIO: here * direction(1), BRAKE: 250.0 * direction(2)}
    true = {DRIVE: 0.9, RATIO: 0.9, BRAKE: 0.9}
    search = a_search(hidden_by_size(does, true), "drive_gain", "steer_ratio", "brake_gain")
    base = search.trial(("drive_gain",), {DRIVE: 0.95})
    found = quiet(search, base, town(does | {RATIO: there * direction(1)}, true))
    assert (found and found.names) == ("drive_gain", told)


@pytest.mark.parametrize(("more", "told"), [(0.0335, "steer_ratio"), (0.0371, "steer_asymmetry")])
def test_the_simpler_of_two_new_effects_may_gain_less_by_ten_standard_deviations(more: float, told: str) -> None:
    """A ratio for both sides is off by half of `more` on each: it leaves 2 x (400 x 0.01675)^2 = 90, or 110."""
    rows = [400.0 * direction(1), 400.0 * direction(2)]
    does = {DRIVE: 500.0 * direction(0), LEFT: rows[0], RIGHT: rows[1], RATIO: rows[0] + rows[1]}
    world = hidden_by_size(does, {DRIVE: 0.9, LEFT: 0.9, RIGHT: 0.9 + more})
    search = a_search(world, "drive_gain", "steer_ratio", "steer_asymmetry")
    found = quiet(search, search.trial(("drive_gain",), {DRIVE: 0.95}))
    assert (found and found.names) == ("drive_gain", told)


@pytest.mark.parametrize(("gain", "fitted"), [(98.0, 0), (102.0, 1)])
def test_what_promises_less_than_a_quarter_of_what_is_evident_is_not_fitted(gain: float, fitted: int) -> None:
    """A quarter of 20 standard deviations squared is 100."""
    world = World({BRAKE: 10.0 * np.sqrt(gain) * direction(0)}, {BRAKE: 0.9}, excused=True)
    search = a_search(world, "brake_gain")
    assert len(quiet_effects._promising(search, search.trial((), {}), ())) == fitted


def test_no_more_than_six_effects_are_fitted_and_those_that_the_remainder_imitates_do_not_count() -> None:
    """Of eight the second best is imitated, and the last one is not looked at."""
    names = ("drive_gain", "mass", "steer_ratio", "brake_gain", "gyro_bias", "aero_drag", "steer_offset", "brake_limit")
    keys = {name: find_effect(name).parameters[0] for name in names}
    options = [(100.0 * k, name, {(name, keys[name].name): 0.5}) for k, name in enumerate(names)]
    search = a_search(World({}, excused=True), *names)
    asked: list[str] = []

    def trial(self: Search, names: Any, values: Any, target: Any) -> Any:
        asked.append(names[-1])
        return a_trial(0.0, *names)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(FirstOrderGain, "__init__", lambda self, target, now: None)
        patch.setattr(
            FirstOrderGain, "promising", lambda self, of: [(left, search.known[n], p) for left, n, p in options]
        )
        patch.setattr(Search, "trial", trial)
        patch.setattr(quiet_effects, "is_imitated", lambda search, trial, name, times: name == "mass")
        found = quiet_effects._promising(search, a_trial(1e4), ())
    assert [trial.names[-1] for trial in found] == [n for n in names if n not in ("mass", "brake_limit")]
    assert asked == list(names[:-1])


def test_a_hill_is_fitted_from_the_three_places_that_promise_most(monkeypatch: pytest.MonkeyPatch) -> None:
    """The fading of the brakes stands for a hill here, and nobody says whether hills are looked for. Between the places
    that are passed lies the one that promises most, 0.0005; beside it 0.0004 and 0.0006 are the best."""
    fade = ("brake_fade", "k")
    world = World({fade: 1e6 * direction(0)}, {fade: 0.0005}, excused=True)
    search = a_search(world, refiners=("brake_fade",))
    places = [{fade: value, ("brake_fade", "tau"): 120.0} for value in (0.003, 0.0006, 0.001, 0.0004, 0.002)]
    monkeypatch.setattr(quiet_effects, "is_placed", lambda candidate: True)
    monkeypatch.setattr(quiet_effects, "along_the_way", lambda search, candidate: places)
    begun: list[float] = []
    whole = Search.trial

    def trial(self: Search, names: Any, start: Any, **more: Any) -> Any:
        begun.extend([start[fade]] if names else [])
        return whole(self, names, start, **more)

    monkeypatch.setattr(Search, "trial", trial)
    found = quiet(search, search.trial((), {}))
    assert (found and found.names) == ("brake_fade",)
    assert sorted(begun[:3]) == pytest.approx([0.0004, 0.0005, 0.0006])
    assert begun[3:] == [pytest.approx(0.0005, rel=0.01)]  # the best of the three, fitted as a search does


@pytest.mark.parametrize(("left", "told"), [(0.95, True), (1.05, False)])
def test_in_the_place_of_three_an_effect_may_leave_twice_the_square_of_ten(left: float, told: bool) -> None:
    """It leaves 200 times `left` of 50 standard deviations squared."""
    aside = np.sqrt(200.0 * left) / 50.0
    does = {DRIVE: 500.0 * direction(0), BRAKE: 500.0 * direction(1), LEFT: 500.0 * direction(3)}
    together = (direction(0) + direction(1) + direction(3)) / np.sqrt(3.0)
    does[RATIO] = 500.0 * (np.sqrt(1.0 - aside**2) * together + aside * direction(2))
    each = 1.0 - 0.1 / np.sqrt(3.0)
    world = World(does, {DRIVE: each, BRAKE: each, LEFT: each}, excused=True)
    search = a_search(world, "drive_gain", "brake_gain", "steer_asymmetry", "steer_ratio")
    three = search.trial(("drive_gain", "brake_gain", "steer_asymmetry"), NEUTRAL)
    found = single(search, three, ())
    assert (found is not None) is told


# --- what the others make up for


@pytest.mark.parametrize("end", [0.0, 1.0])
def test_an_effect_at_an_end_of_what_is_possible_makes_up_for_another_one(
    end: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A share of 0 or 1 can be moved one way only; what it does is what the drive's gain does: 50 standard deviations
    alone, and nothing that the share could not do."""
    monkeypatch.setitem(NEUTRAL, SHARE, 0.0)
    world = World({DRIVE: 500.0 * direction(0), SHARE: 300.0 * direction(0)}, {DRIVE: 0.9, SHARE: end})
    trial = a_trial(1000.0, "drive_gain", "front_wheel_speed", values={DRIVE: 0.9, SHARE: end})
    found = shown_by(a_search(world, "drive_gain", "front_wheel_speed"), trial, "drive_gain", world)  # type: ignore[arg-type]
    assert found.alone == pytest.approx(50.0**2)
    assert found.gain == pytest.approx(0.0, abs=1e-6)


# --- what changes while driving


def test_what_changes_while_driving_takes_the_place_of_all_that_it_is_confused_with(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Fading brakes refine a gain of the brakes, and are often confused with a limit of them."""
    monkeypatch.setattr(FirstOrderGain, "__init__", lambda self, target, now: None)
    monkeypatch.setattr(FirstOrderGain, "remaining_chi2", lambda self, candidate, points, *needed: [(1.0, points[0])])
    leaves = {"": 4000.0, "brake_gain brake_limit": 2000.0, "brake_fade": 1000.0}
    search = given(leaves, "brake_gain", "brake_limit", refiners=("brake_fade",))
    assert refined(search, search.trial(("brake_gain", "brake_limit"), {}), {}).names == ("brake_fade",)
