"""Whether the LiDAR loses what is behind others, by how far detections are off on the whole: made-up errors."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.perception.lidar_behind import BETTER, NAME, with_lidar
from pytest_dvp.gap.perception.perceived_values import Perceived
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.model_file import parse_model

BARE = parse_model("[model]\nname = 'car'\n[parameters]\nwheelbase = 2.5\n")
BOTH, CAMERA = (BARE.with_effect(NAME, {"share": 0.4, "lidar": lidar}) for lidar in (1.0, 0.0))


def shown(error: float) -> Perceived:
    return Perceived({}, {}, {}, error=error)


@pytest.mark.parametrize(
    ("model", "car", "loses", "otherwise"),
    [
        (BARE, BETTER - 0.01, 1.0, False),  # bad places are missing in the car
        (BARE, BETTER + 0.01, 0.0, False),
        (BOTH, 1.0, 1.0, False),  # as bad as a twin whose LiDAR loses them
        (BOTH, 1.0 / BETTER + 0.01, 0.0, True),  # worse: the car's does not
        (CAMERA, 1.0, 0.0, False),
        (CAMERA, BETTER - 0.01, 1.0, True),
    ],
)
def test_places_tell_what_the_lidar_does(model: Any, car: float, loses: float, otherwise: bool) -> None:
    found = Perceived({(NAME, "share"): (0.4, 0.3, 0.5)}, {}, {})
    assert with_lidar(found, shown(0.2 * car), shown(0.2), model, (NAME, "detection_false")) is otherwise
    assert found.values[NAME, "lidar"] == (loses, loses, loses)


@pytest.mark.parametrize("part", ["noise", "misses", "size"])
@pytest.mark.parametrize(("model", "keeps"), [(BARE, 0.0), (BOTH, 1.0), (CAMERA, 0.0)])
def test_beside_what_moves_places_nothing_is_concluded(part: str, model: Any, keeps: float) -> None:
    for car in (0.5, 2.0):
        found = Perceived({(NAME, "share"): (0.4, 0.3, 0.5)}, {}, {})
        assert not with_lidar(found, shown(car), shown(1.0), model, (f"detection_{part}",))
        assert found.values[NAME, "lidar"] == (keeps, 0.0, 1.0)


def test_where_nothing_was_behind_anything_nothing_is_said() -> None:
    found = Perceived({}, {}, {})
    assert not with_lidar(found, shown(0.1), shown(0.2), BARE, ())
    assert found.values == {}


def test_the_value_is_one_of_the_effect() -> None:
    key = find_effect(NAME).key("lidar")
    assert (key.minimum, key.maximum, key.neutral) == (0.0, 1.0, 1.0)
    assert np.isfinite(key.least)
