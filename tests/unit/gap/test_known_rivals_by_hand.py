"""Rivals of a law in a linear world: which are asked in which order, what each leaves, and how it is called."""

from __future__ import annotations

from math import inf, sqrt
from typing import Any

import pytest

from pytest_dvp.gap.discover import known_rivals as module
from pytest_dvp.gap.discover.known_rivals import CALIBRATION, _climb, _from_nothing, _named, known_rivals
from tests.unit.gap.linear_world import BRAKE, DRIVE, NEUTRAL, Applied, World, a_search, direction, tried
from vehicle.model.effect_catalogue import find_effect

MASS = ("mass", find_effect("mass").parameters[0].name)
STRONG = 1e5  # of chi^2 for the square of what a value is off by


def a_world(**off: float) -> World:
    keys = {"drive_gain": DRIVE, "brake_gain": BRAKE, "mass": MASS}
    does = {key: sqrt(STRONG) * direction(k) for k, key in enumerate(keys.values())}
    hidden = {keys[name]: NEUTRAL[keys[name]] + value for name, value in off.items()}
    return World(does, hidden, channels={"v": 2.0})


def asked(
    monkeypatch: pytest.MonkeyPatch, target: World, judge: World, model: Any, *names: str
) -> tuple[list[Any], list[str], list[Any]]:
    """Rivals, lines of progress, and what the starts of the segments were moved for."""
    ticks: list[str] = []
    moved: list[Any] = []

    def offered(model: Any, known: Any, *, ay: bool, refined: bool) -> Any:
        assert refined  # what changes while driving may be what a law was found for
        assert ay is False  # no lateral acceleration is measured here
        return tried(*names)

    monkeypatch.setattr(module, "candidates", offered)
    monkeypatch.setattr(module, "input_map", lambda model: ((), {}))
    monkeypatch.setattr(module, "settle", lambda data, values: moved.append((data, dict(values))))
    found = list(known_rivals(target, judge, model, {}, ticks.append))  # type: ignore[arg-type]
    return found, ticks, moved


def test_values_that_a_model_has_come_first_then_its_calibration_and_the_catalogue(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The mass is 0.2 off, the drive 0.1: 4,000 and 1,000 of chi^2 beside the noise of 1,000. On the data held out the
    drive is off by 0.15, so that 0.05 of it, 250 of chi^2, stay with what was fitted."""
    target, judge = a_world(drive_gain=-0.1, mass=0.2), a_world(drive_gain=-0.15, mass=0.2)
    found, ticks, moved = asked(monkeypatch, target, judge, Applied(mass=1.1), "drive_gain", "brake_gain", "mass")
    assert ticks == ["rivals: the model's own values", "rivals: gains and zeros", "rivals: the catalogue"]
    assert [one.text.partition(" (")[0] for one in found] == [
        "the model with its own values fitted again", "the model with its calibration fitted again",
        "the effect mass", "the effects mass", "the effects mass",
    ]  # fmt: skip
    assert found[1].text.endswith("(drive_gain, brake_gain, mass)")
    assert [one.left for one in found] == pytest.approx([2.0, 1.0, 2.0, 1.0, 1.0], abs=0.02)
    assert [one.judged for one in found] == pytest.approx([3.25, 1.25, 3.25, 1.25, 1.25], abs=0.03)
    assert [data is target for data, _ in moved] == [True, False] * 5
    assert moved[0][1] == pytest.approx({MASS: 1.2}, abs=0.01)


def test_of_a_model_without_effects_the_calibration_comes_first_and_without_an_effect_last(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of the mass alone is nothing fitted again: it is no part of the calibration of a model that does not name it."""
    found, ticks, _ = asked(monkeypatch, a_world(), a_world(), Applied(), "drive_gain", "mass")
    assert [one.text for one in found] == ["the model with its calibration fitted again (drive_gain)"]
    assert (found[0].left, found[0].judged) == pytest.approx((1.0, 1.0), abs=1e-3)
    assert len(ticks) == 3
    assert set(CALIBRATION) >= {"steer_ratio", "steer_offset", "drive_gain", "brake_gain"}


def test_a_rise_adds_one_effect_at_a_time_from_where_the_last_one_left_the_segments() -> None:
    search = a_search(a_world(drive_gain=-0.1, mass=0.2), "drive_gain", "brake_gain", "mass")
    assert [trial.names for trial in _climb(search)] == [("mass",), ("mass", "drive_gain")]
    assert [set(values) >= {MASS} for values in search.target.settled] == [True, True]  # type: ignore[attr-defined]


def test_a_set_is_called_by_its_values_in_their_units() -> None:
    world = World({DRIVE: direction(0)})
    one = a_search(world, "drive_gain").trial(("drive_gain",), {DRIVE: 1.0})
    assert _named(one) == "the effect drive_gain (g 1) of the catalogue"
    names = ("drive_gain", "rolling_resistance")
    key = ("rolling_resistance", find_effect("rolling_resistance").parameters[0].name)
    both = a_search(World({DRIVE: direction(0), key: direction(1)}), *names).trial(names, {DRIVE: 0.93444, key: 0.1})
    both.values[DRIVE], both.values[key] = 0.93444, 0.123456  # type: ignore[index]
    assert _named(both) == "the effects drive_gain (g 0.934), rolling_resistance (c 0.123 m/s^2) of the catalogue"


@pytest.mark.parametrize("name", ["steer_lag", "drive_delay", "rolling_resistance", "drive_gain", "power_limit"])
def test_a_value_that_counts_by_ratio_counts_by_difference_from_doing_nothing_on(name: str) -> None:
    (candidate,) = tried(name)
    for before, after in zip(candidate.coordinates, _from_nothing(candidate).coordinates, strict=True):
        neutral = before.key.neutral
        changed = before.by_ratio and neutral != inf and neutral < before.key.low
        assert after.key.low == (neutral if changed else before.key.low)
        assert not (changed and after.by_ratio)
        assert after.key.high == before.key.high
