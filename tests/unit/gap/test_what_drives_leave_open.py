"""Limits that the drives of a twin would not have noticed, and what is asked for beside what a remainder could be."""

from __future__ import annotations

from math import inf
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose import beyond_remainder, fitted_twin
from pytest_dvp.gap.diagnose.beyond_remainder import all_show, as_told, is_evident, is_imitated
from pytest_dvp.gap.diagnose.candidates import candidates, sizes
from pytest_dvp.gap.diagnose.diagnosis import Estimate, NamedEffect
from pytest_dvp.gap.diagnose.fitted_twin import Drives
from pytest_dvp.gap.diagnose.held_out import Fold
from pytest_dvp.gap.diagnose.imitation import unseen
from pytest_dvp.gap.diagnose.quiet_effects import quiet, single
from pytest_dvp.gap.diagnose.standing import _unseen
from pytest_dvp.gap.extend import twin_remainder as module
from tests.unit.gap.linear_world import BRAKE, DRIVE, NOISE, ROWS, World, a_search, a_trial, direction, tried
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.model_file import parse_model
from vehicle.model.remainder_shape import RemainderShape

LOWER = ("brake_limit", "limit")
RATIO = ("steer_ratio", "g")


class Limited(World):
    """What a limit does is in proportion to its inverse; the car has none."""

    def whitened(self, values: Any) -> Any:
        return self.noise + sum((row / values.get(key, inf) for key, row in self.does.items()), start=0.0 * self.noise)


def drives(*reached: float) -> Any:
    """Drives that show a limit, by ten standard deviations, where it is below these values."""
    return [Limited({LOWER: 10.0 * value * direction(0)}) for value in reached]


def without(*effects: str) -> Any:
    return SimpleNamespace(effects=[SimpleNamespace(name=name) for name in effects])


def test_a_limit_is_open_above_the_highest_value_that_any_drive_refutes() -> None:
    for reached in ((5.0,), (5.0, 3.0), (3.0, 5.0)):
        found = unseen(drives(*reached), tried("brake_limit", "drive_gain"), without())
        assert found == {"brake_limit": {"limit": pytest.approx(5.0, abs=0.05)}}


def test_nothing_is_open_where_the_highest_limit_would_have_been_noticed() -> None:
    assert unseen(drives(1000.0), tried("brake_limit"), without()) == {}
    assert unseen(drives(1000.0, 3.0), tried("brake_limit"), without()) == {}
    assert unseen(drives(5.0), tried("brake_limit"), without("brake_limit")) == {}  # the twin knows it
    assert unseen((), tried("brake_limit"), without()) == {}


def test_where_no_drive_shows_a_limit_all_are_open() -> None:
    (candidate,) = tried("brake_limit")
    found = unseen(drives(1e-3), (candidate,), without())
    assert found["brake_limit"]["limit"] == pytest.approx(candidate.coordinates[0].key.low, rel=0.01)


def test_a_limit_is_open_where_the_others_of_its_effect_hardly_limit() -> None:
    """Drives that show a torque below 100 N m and a power below 50 kW: beside a torque of 500 N m, which does 2 of
    their ten standard deviations, a power is open from 500 / sqrt(100 - 4) kW on, beside a power of 200 kW, which does
    2.5, a torque from 1000 / sqrt(100 - 6.25) N m on. No drive comes near any greatest speed."""
    train = "[[effect]]\nname = 'motor_inertia'\nparameters = {J = 0.05}\n"
    driven = parse_model(f"[parameters]\nwheelbase = 2.5\nmass = 1000.0\nwheel_radius = 0.3\ngear_ratio = 6.0\n{train}")
    (motor,) = candidates(driven, [find_effect("motor_torque")])
    does = {("motor_torque", "torque"): 1000.0 * direction(0), ("motor_torque", "power"): 500e3 * direction(1)}
    found: Any = unseen([Limited(does)], (motor,), without())  # type: ignore[list-item]
    assert found["motor_torque"] == {
        "torque": pytest.approx(1000.0 / np.sqrt(93.75), rel=0.02),
        "power": pytest.approx(500e3 / np.sqrt(96.0), rel=0.02),
        "max_speed": pytest.approx(100.0),
    }


@pytest.mark.parametrize(("found", "imitated"), [(3.99, False), (4.01, True), (5.5, True)])
def test_a_limit_that_drives_leave_open_has_to_be_lower_by_a_fifth(found: float, imitated: bool) -> None:
    """Open from 5 on: 5 / 1.25."""
    world = World({LOWER: 1000.0 * direction(0)}, excused=True)
    world.model.remainder_shape = RemainderShape(unseen={"brake_limit": {"limit": 5.0}})
    trial = a_trial(1000.0, "brake_limit", values={LOWER: found})
    assert is_imitated(a_search(world, "brake_limit"), trial, "brake_limit") is imitated


@pytest.mark.parametrize(("value", "older"), [(4.9, False), (5.0, True)])
def test_a_limit_that_no_drive_came_to_may_be_older(value: float, older: bool) -> None:
    e = NamedEffect("brake_limit", {"limit": Estimate(value, value, value, "m/s^2")}, (), 0.5)
    doubts = _unseen(e, {"limit": 5.0})
    assert bool(doubts) is older
    assert all("do not come to limit = 5" in doubt for doubt in doubts)
    assert _unseen(e, {}) == []
    assert _unseen(e, {"other": 1.0}) == []


def test_where_a_hill_lies_is_no_size() -> None:
    """Else the place alone, tens of metres from nought, would always be more than a remainder imitates."""
    (hill,) = tried("road_profile")
    assert [c.key.name for c in sizes(hill.coordinates)] == ["height"]
    world = World({}, excused=True)
    world.model.remainder_shape = RemainderShape(imitates={"road_profile": {"height": 0.4}})
    search = a_search(world, refiners=("road_profile",))
    for height, imitated in ((1.71, True), (1.73, False)):  # 4.3 times 0.4 is 1.72
        values = {("road_profile", key): value for key, value in zip("xy", (80.0, -90.0), strict=True)}
        values |= {("road_profile", "height"): height, ("road_profile", "length"): 90.0}
        assert is_imitated(search, a_trial(0.0, "road_profile", values=values), "road_profile") is imitated


@pytest.mark.parametrize(("imitated", "asked"), [(0.05, True), (0.01, False)])
def test_a_quiet_effect_is_asked_for_beside_what_a_remainder_could_be(imitated: float, asked: bool) -> None:
    """Of the drive's gain 0.1 is named already: 4.3 times 0.05 is more than that, 4.3 times 0.01 less."""
    does = {DRIVE: 500.0 * direction(0), BRAKE: 250.0 * direction(1)}
    world = World(does, {DRIVE: 0.9, BRAKE: 0.9}, excused=True)
    world.model.remainder_shape = RemainderShape(imitates={"drive_gain": {"g": imitated}})
    search = a_search(world, "drive_gain", "brake_gain")
    found = quiet(search, search.trial(("drive_gain",), {DRIVE: 0.95}))
    assert (found and found.names) == (("drive_gain", "brake_gain") if asked else None)


@pytest.mark.parametrize(
    ("size", "imitated", "there", "town", "new"),
    [(101.0, 0.0, 0.9, 101.0, True), (99.0, 0.0, 0.9, 101.0, False), (101.0, 0.034, 0.9, 101.0, False),
     (101.0, 0.0, 1.0, 101.0, False), (101.0, 0.0, 0.9, 99.0, False)],
)  # fmt: skip
def test_a_rival_of_what_all_drives_show_is_shown_by_all_of_them(
    size: float, imitated: float, there: float, town: float, new: bool
) -> None:
    """By ten standard deviations on each drive, as more than the remainder imitates, and refuted by none."""
    world = World({DRIVE: 10.0 * np.sqrt(size) * direction(0)}, {DRIVE: 0.9}, excused=True)
    world.model.remainder_shape = RemainderShape(imitates={"drive_gain": {"g": imitated}})
    apart = World({DRIVE: 10.0 * np.sqrt(town) * direction(0)}, {DRIVE: there})
    search = a_search(world, "drive_gain")
    trial = a_trial(0.0, "drive_gain", values={DRIVE: 0.9})
    assert all_show(search, trial, (Fold(None, apart),)) is new  # type: ignore[arg-type]


@pytest.mark.parametrize(("gain", "evident"), [(300.0, True), (299.0, False)])
def test_data_must_gain_the_share_of_what_an_effect_changes_that_is_asked_for(
    gain: float, evident: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A quarter of 1200; ten standard deviations are less."""
    monkeypatch.setattr(beyond_remainder, "is_imitated", lambda *given: False)
    monkeypatch.setattr(beyond_remainder, "shown_by", lambda *given: beyond_remainder.Shown(2000.0, gain, 1200.0))
    search, trial, data = a_search(World({}), "drive_gain"), a_trial(0.0, "drive_gain"), World({})
    assert is_evident(search, trial, "drive_gain", data, least=10.0, agrees=0.25) is evident  # type: ignore[arg-type]


def test_values_are_told_as_they_are_where_the_remainder_lasts() -> None:
    """The plain metric asks for 0.9, the one in which the remainder lasts for 0.8."""
    lasting = World({DRIVE: 500.0 * direction(0)}, {DRIVE: 0.8})
    world = World({DRIVE: 500.0 * direction(0)}, {DRIVE: 0.9}, excused=True, other=lasting)
    search = a_search(world, "drive_gain")
    plain = search.trial(("drive_gain",), {DRIVE: 0.95})
    assert plain.values[DRIVE] == pytest.approx(0.9, abs=2e-3)
    assert as_told(search, plain).values[DRIVE] == pytest.approx(0.8, abs=2e-3)
    world.excused = False
    assert as_told(search, plain) is plain


def test_one_effect_is_told_in_the_place_of_two_that_explain_no_more() -> None:
    """What is hidden lies between what the two do; the plain metric, blind to one part of it, likes the two better."""
    both = 0.5 * np.sqrt(2.0) * (direction(0) + direction(1))
    does = {DRIVE: 500.0 * direction(0), BRAKE: 500.0 * direction(1), RATIO: 500.0 * both}
    each = 1.0 - 0.05 * np.sqrt(2.0)
    world = World(does, {DRIVE: each, BRAKE: each}, excused=True)
    search = a_search(world, "drive_gain", "brake_gain", "steer_ratio")
    two = search.trial(("drive_gain", "brake_gain"), {DRIVE: 0.95, BRAKE: 0.95})
    assert two.chi2 == pytest.approx(ROWS, rel=0.02)
    found = single(search, two, ())
    assert (found and found.names) == ("steer_ratio",)
    alone = search.trial(("steer_ratio",), {RATIO: 0.95})
    assert single(search, alone, ()) is None  # it is the same
    assert single(search, search.trial((), {}), ()) is None
    does[RATIO] = 500.0 * (0.8 * both + 0.6 * direction(2))  # now it does what nothing asks for, too
    assert single(search, two, ()) is None


@pytest.mark.parametrize(("more", "told"), [(0.9, ("steer_ratio",)), (1.1, None)])
def test_for_each_effect_less_the_error_that_lasts_may_grow_by_ten_standard_deviations(more: float, told: Any) -> None:
    """What is hidden is 50 standard deviations, of which one effect in the place of two leaves 10 or so."""
    aside = more * 10.0 / 50.0
    both = 0.5 * np.sqrt(2.0) * (direction(0) + direction(1))
    one_effect = np.sqrt(1.0 - aside**2) * both + aside * direction(2)
    does = {DRIVE: 500.0 * direction(0), BRAKE: 500.0 * direction(1), RATIO: 500.0 * one_effect}
    each = 1.0 - 0.05 * np.sqrt(2.0)
    search = a_search(World(does, {DRIVE: each, BRAKE: each}, excused=True), "drive_gain", "brake_gain", "steer_ratio")
    two = search.trial(("drive_gain", "brake_gain"), {DRIVE: 0.95, BRAKE: 0.95})
    found = single(search, two, ())
    assert (found and found.names) == told


def test_a_limit_that_one_drive_alone_asks_for_is_not_told() -> None:
    world = Limited({LOWER: 1000.0 * direction(0)}, excused=True, noise=NOISE - 200.0 * direction(0))
    search = a_search(world, "brake_limit")
    assert search.trial(("brake_limit",), {LOWER: 6.0}).chi2 < ROWS * 1.02  # a limit of 5 m/s^2 explains it
    assert quiet(search, search.trial((), {})) is None
    town = Limited({LOWER: 1000.0 * direction(0)}, noise=NOISE - 200.0 * direction(0))
    found = quiet(search, search.trial((), {}), (Fold(None, town),))  # type: ignore[arg-type]
    assert (found and found.names) == ("brake_limit",)


@pytest.mark.parametrize(("right", "told"), [(0.905, "steer_ratio"), (0.98, "steer_asymmetry")])
def test_of_two_of_which_one_contains_the_other_the_simpler_one_is_told(right: float, told: str) -> None:
    """One for all leaves (0.0025 x 400)^2 of each side, which is less than 10^2, or (0.04 x 400)^2, which is more."""
    left_side, right_side = (("steer_asymmetry", key) for key in ("g_left", "g_right"))
    rows = [400.0 * direction(0), 400.0 * direction(1)]
    does = {left_side: rows[0], right_side: rows[1], RATIO: rows[0] + rows[1]}
    world = World(does, {left_side: 0.9, right_side: right}, excused=True)
    search = a_search(world, "steer_ratio", "steer_asymmetry")
    found = quiet(search, search.trial((), {}))
    assert (found and found.names) == (told,)


@pytest.mark.parametrize(("there", "better"), [(0.8, True), (0.9, False), (0.85, False)])
def test_a_twin_is_fitted_once_more_where_its_remainder_lasts_if_data_held_out_are_better_by_that(
    there: float, better: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The plain fit said 0.9, with the remainder as an error that lasts it is 0.8; the other drive says so or not."""
    worlds = {name: World({DRIVE: 1000.0 * direction(0)}, {DRIVE: value}) for name, value in (("a", 0.8), ("b", there))}
    monkeypatch.setattr(fitted_twin, "experiment_set", lambda logs, twin, extra: worlds[next(iter(logs))])
    for each in (module, fitted_twin):
        monkeypatch.setattr(each, "candidates_of", lambda twin, names: tried(*names))
    monkeypatch.setattr(
        module, "estimates", lambda found, search: {k: Estimate(v, v, v, "-") for k, v in found.values.items()}
    )
    has = [SimpleNamespace(name="drive_gain", values={"g": 0.9}), SimpleNamespace(name="mass", values={"ratio": 1.1})]
    twin, none_left = (SimpleNamespace(remainder=left, effects=has) for left in ({"v": 1.0}, {}))
    logs: Any = {"a": None}
    apart: Any = {"b": None}

    def found(twin: Any, apart: Any = apart, *fitted: str, always: bool = False) -> dict[tuple[str, str], float]:
        again = module.beside_remainder(twin, fitted, Drives(logs, apart), always=always)
        return {key: round(e.value, 3) for key, e in again.items()}

    assert found(twin, apart, "drive_gain") == ({DRIVE: 0.8} if better else {})
    assert found(twin, apart, "drive_gain", always=True) == {DRIVE: 0.8}
    assert found(twin, {}, "drive_gain") == {}
    assert found(none_left, apart, "drive_gain") == {}
    assert found(twin, apart) == {}  # nothing was fitted
