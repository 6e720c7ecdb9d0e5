"""Where an effect of a place is looked for when a known remainder hides all else: along the way that was driven."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.candidates import candidates
from pytest_dvp.gap.diagnose.quiet_effects import STEP, along_the_way, is_placed
from vehicle.model.effect_catalogue import catalogue
from vehicle.model.model_file import parse_model

MODEL = parse_model('[model]\nbase = "kinematic_bicycle"\n[parameters]\nwheelbase = 2.5\nmass = 1000')
HILL = next(c for c in candidates(MODEL, catalogue().values(), refined=True) if c.name == "road_profile")


def searched(x: np.ndarray, y: np.ndarray) -> SimpleNamespace:
    measured = np.full((len(x), 8), np.nan)
    measured[:, 0], measured[:, 1] = x, y
    return SimpleNamespace(target=SimpleNamespace(experiments=[SimpleNamespace(measured=measured)]))


def test_each_place_of_the_way_is_asked_with_the_sizes_of_the_effect() -> None:
    """200 m along x and back: places at 0, 20 ... 200 m, each once, and none beside the way."""
    way = np.concatenate([np.linspace(0.0, 200.0, 500), np.linspace(200.0, 0.0, 500)])
    points = along_the_way(searched(way, np.full(1000, 7.0)), HILL)  # type: ignore[arg-type]
    assert sorted({p["road_profile", "x"] for p in points}) == [STEP * k for k in range(11)]
    assert {p["road_profile", "y"] for p in points} == {0.0}
    sizes = {(p["road_profile", "height"], p["road_profile", "length"]) for p in points}
    assert sizes == {(p["road_profile", "height"], p["road_profile", "length"]) for p in HILL.points}
    assert len(points) == 11 * len(sizes)


def test_a_long_way_is_asked_in_longer_steps() -> None:
    """6 km straight on: 301 places of 20 m are too many, 134 of 45 m too, 90 of 67.5 m are not."""
    x = np.linspace(0.0, 6000.0, 3000)
    points = along_the_way(searched(x, np.zeros(3000)), HILL)  # type: ignore[arg-type]
    places = sorted({p["road_profile", "x"] for p in points})
    assert len(places) == 90
    assert np.diff(places) == pytest.approx(67.5)


def test_a_log_without_positions_has_no_places() -> None:
    nowhere = np.full(50, np.nan)
    assert along_the_way(searched(nowhere, nowhere), HILL) == []  # type: ignore[arg-type]


def test_rows_without_a_position_have_no_place() -> None:
    x = np.array([0.0, np.nan, 40.0])
    assert {p["road_profile", "x"] for p in along_the_way(searched(x, x), HILL)} == {0.0, 40.0}  # type: ignore[arg-type]


def test_the_place_at_the_origin_is_nought_without_a_sign() -> None:
    """A way 5 m left of the axis of a map, and 5 m right of it, passes the same place."""
    for beside in (-5.0, 5.0):
        points = along_the_way(searched(np.full(3, beside), np.full(3, beside)), HILL)  # type: ignore[arg-type]
        assert {str(p["road_profile", key]) for p in points for key in "xy"} == {"0.0"}


def test_only_what_lies_at_a_placeis_placed() -> None:
    placed = [c.name for c in candidates(MODEL, catalogue().values(), refined=True) if is_placed(c)]
    assert placed == ["road_profile"]
