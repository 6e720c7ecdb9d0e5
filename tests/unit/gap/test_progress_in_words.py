"""What a search says as it goes on: the number of the effect that is looked for, what was found, and what is left."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose import usual_car as usual
from pytest_dvp.gap.diagnose.search import Search
from pytest_dvp.gap.extend import growth
from tests.unit.gap.linear_world import BRAKE, DRIVE, World, direction, tried

ONCE = "what nearly every car has, 3 effects at once"


def test_a_search_counts_effects_and_rivals_from_one_and_says_what_is_left_a_sample() -> None:
    """Of 1,000 samples of noise 1 the gains leave 900 and 420 more."""
    world = World({DRIVE: 300.0 * direction(0), BRAKE: np.sqrt(420.0) * 10.0 * direction(1)},
                  {DRIVE: 0.9, BRAKE: 0.9})  # fmt: skip
    said: list[str] = []
    Search(world, tried("drive_gain", "brake_gain", "mass")[:2], tick=said.append).run()  # type: ignore[arg-type]
    assert list(dict.fromkeys(said)) == [
        "effect 1: trying 2",
        "effect 2: trying 2; so far drive_gain: chi²/N 1.42",
        "effect 3: trying 2; so far drive_gain, brake_gain: chi²/N 1",
        "rivals of brake_gain, 1 of 2; chi²/N 1",
        "rivals of drive_gain, 2 of 2; chi²/N 1",
    ]


def test_the_growth_of_a_model_says_what_came_beside_its_own_effects(monkeypatch: pytest.MonkeyPatch) -> None:
    def made(names: Any, left: float) -> Any:
        return SimpleNamespace(names=tuple(names), values={}, chi2=left)

    following = {("mass",): "a", ("mass", "a"): "b"}
    left = {1: 50.0, 2: 30.0, 3: 12.5}
    search: Any = SimpleNamespace(
        count=10, target=SimpleNamespace(settle=lambda values: None),
        trial=lambda names, values, like=None: made(names, left[len(names)]),
        paying=lambda now, barred, most: [made((*now.names, following[now.names]), 0.0)] if now.names in following
        else [],
    )  # fmt: skip
    monkeypatch.setattr(growth, "settled_fit", lambda search, now: now)
    monkeypatch.setattr(growth, "contradicts", lambda target, now, trial: False)
    said: list[str] = []
    assert growth.grown(search, {}, ("mass",), said.append).names == ("mass", "a", "b")
    assert said == [
        "what all logs show together: chi²/N 5",
        "what all logs show together; so far a: chi²/N 3",
        "what all logs show together; so far a, b: chi²/N 1.25",
    ]


@pytest.mark.parametrize(
    ("needed", "kept", "said"),
    [
        ({"mass", "drive_gain", "creep"}, {"mass", "drive_gain", "creep"}, ["creep", "drive_gain", "mass"]),
        ({"mass"}, {"mass"}, ["creep", "drive_gain", "mass"]),
        ({"creep", "mass"}, {"creep", "mass"}, ["creep", "drive_gain", "creep", "mass"]),
    ],
)
def test_of_what_nearly_every_car_has_the_least_needed_is_asked_first_and_anew_after_each_that_went(
    needed: set[str], kept: set[str], said: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Three effects that pay one after the other end it; so does asking all that are there."""
    names = ["mass", "drive_gain", "creep"]
    told: list[str] = []
    search: Any = SimpleNamespace(
        tried={name: SimpleNamespace(coordinates=(), seen={}) for name in names}, start={}, count=4, tick=told.append,
        target=SimpleNamespace(settle=lambda values: None), unseen=lambda: (),
        trial=lambda names, values, like=None: SimpleNamespace(names=tuple(names), values={}, chi2=10.0),
        pays=lambda less, now: bool(({*now.names} - {*less.names}) & needed),
    )  # fmt: skip
    monkeypatch.setattr(usual, "_least_needed", lambda search, now: sorted(now.names))
    assert {*usual.usual_car(search).names} == kept
    assert told == [ONCE, *(f"what nearly every car has: without {name}; chi²/N 2.5" for name in said)]
