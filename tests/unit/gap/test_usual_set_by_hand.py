"""The set of what nearly every car has, in a world whose effects stand at right angles to each other."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose import usual_car as module
from pytest_dvp.gap.diagnose.usual_car import USUAL, _least_needed, usual_car
from tests.unit.gap.linear_world import NEUTRAL, World, a_search, direction
from vehicle.model.effect_catalogue import find_effect

NAMES = ("drive_gain", "brake_gain", "mass", "steer_ratio", "steer_offset", "rolling_resistance")
KEY = {name: find_effect(name).parameters[0] for name in NAMES}


@pytest.mark.parametrize("name", list(USUAL))
def test_a_fit_begins_where_a_car_may_be_and_a_scale_or_an_offset_begins_at_none(name: str) -> None:
    for key, value in USUAL[name].items():
        declared = find_effect(name).key(key)
        assert max(declared.minimum, 0.0) <= value <= declared.high
        if declared.low < declared.neutral == 1.0 or key == "offset":  # it may be too much or too little
            assert value == declared.neutral


def a_world(scale: float = 1e3, **off: float) -> World:
    """Each effect that is `off` by so much takes `scale` of chi^2 for the square of what it is off by."""
    places = {(name, KEY[name].name): k for k, name in enumerate(NAMES)}
    does = {key: np.sqrt(scale) * direction(k) for key, k in places.items()}
    return World(does, {(name, KEY[name].name): NEUTRAL[name, KEY[name].name] + value for name, value in off.items()})


STRONG = {"drive_gain": 0.15, "brake_gain": 0.14, "mass": 0.13, "steer_ratio": 0.12, "rolling_resistance": 0.5}


def test_what_is_needed_least_comes_first() -> None:
    """Without one, what it was off by in squares is left; the others stand at right angles and do not help."""
    search = a_search(a_world(drive_gain=0.1, brake_gain=-0.15, mass=0.05, steer_ratio=0.12), *NAMES[:4])
    now = search.trial(NAMES[:4], NEUTRAL)
    assert _least_needed(search, now) == ["mass", "drive_gain", "steer_ratio", "brake_gain"]


def test_the_others_take_over_what_is_left_out_if_they_can() -> None:
    """The mass does 0.99 of what the drive does: without the drive it takes its share over."""
    world = a_world(drive_gain=0.2, brake_gain=0.05)
    world.does["mass", KEY["mass"].name] = np.sqrt(1000.0) * direction(2, 0, 0.99)
    search = a_search(world, "drive_gain", "brake_gain", "mass")
    now = search.trial(("drive_gain", "brake_gain", "mass"), NEUTRAL)
    assert _least_needed(search, now) == ["mass", "drive_gain", "brake_gain"]


def course(monkeypatch: pytest.MonkeyPatch, needed: set[str], *names: str) -> tuple[Any, list[str], list[Any], World]:
    """Which sets are fitted where an effect pays if it is needed; the least needed comes first in order of its name."""
    world = a_world()
    search = a_search(world, *names)
    ticks: list[str] = []
    fitted: list[Any] = []
    plain = search.trial

    def trial(names: Any, start: Any, **more: Any) -> Any:
        fitted.append((tuple(names), dict(start), more.get("like")))
        return plain(names, start, **more)

    monkeypatch.setattr(search, "tick", ticks.append)
    monkeypatch.setattr(search, "trial", trial)
    monkeypatch.setattr(search, "pays", lambda less, now: not needed.isdisjoint(set(now.names) - set(less.names)))
    monkeypatch.setattr(module, "_least_needed", lambda search, now: sorted(now.names))
    return usual_car(search), ticks, fitted, world


def test_all_begin_at_usual_values_and_are_fitted_four_times_before_one_is_left_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found, ticks, fitted, world = course(monkeypatch, {"mass"}, "mass", "rolling_resistance")
    every = ("rolling_resistance", "mass")  # in the order of what is usual
    assert [set(names) for names, *_ in fitted] == [set(every)] * 4 + [
        {"rolling_resistance"},
        {"mass"},
        set(),
        {"mass"},
    ]
    assert fitted[0][1:] == ({("rolling_resistance", "c"): 0.1, ("mass", KEY["mass"].name): 1.0}, None)
    assert all(like is not None for *_, like in fitted[1:])
    assert len(world.settled) == 4  # before each fit anew, and at the end
    assert found.names == ("mass",)
    assert ticks[0] == "what nearly every car has, 2 effects at once"
    assert [text.partition(";")[0].rpartition(" ")[2] for text in ticks[1:]] == ["mass", "rolling_resistance", "mass"]
    assert ticks[1].endswith("; chi²/N 1")


def test_what_is_not_needed_goes_until_the_three_least_needed_ones_pay(monkeypatch: pytest.MonkeyPatch) -> None:
    """In the order of their names: the brakes go; drive, mass and rolling pay, and the offset is not asked."""
    needed = {"drive_gain", "mass", "rolling_resistance", "steer_ratio"}
    found, ticks, _, _ = course(monkeypatch, needed, *NAMES)
    assert set(found.names) == needed | {"steer_offset"}
    asked = [text.partition(";")[0].rpartition(" ")[2] for text in ticks[1:]]
    assert asked == ["brake_gain", "drive_gain", "mass", "rolling_resistance"]


def test_those_that_paid_are_asked_again_once_another_has_gone(monkeypatch: pytest.MonkeyPatch) -> None:
    _, ticks, _, _ = course(monkeypatch, {"brake_gain", "drive_gain"}, *NAMES)
    asked = [text.partition(";")[0].rpartition(" ")[2] for text in ticks[1:]]
    assert asked == [
        "brake_gain", "drive_gain", "mass", "brake_gain", "drive_gain", "rolling_resistance", "brake_gain",
        "drive_gain", "steer_offset", "brake_gain", "drive_gain", "steer_ratio", "brake_gain", "drive_gain",
    ]  # fmt: skip


def test_a_car_keeps_what_it_has_and_loses_what_it_lacks() -> None:
    found = usual_car(a_search(a_world(1e5, **STRONG), *NAMES))
    assert set(found.names) == set(STRONG)
    for name, value in STRONG.items():
        assert found.values[name, KEY[name].name] == pytest.approx(NEUTRAL[name, KEY[name].name] + value, abs=1e-3)
