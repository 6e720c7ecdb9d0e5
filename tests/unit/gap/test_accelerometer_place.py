"""Where the lateral accelerometer is, fitted along with a set of effects."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.accelerometer_place import PLACE, placed, points_there

COUNT, WHEELBASE, TRUE = 400, 3.0, 1.2
RNG = np.random.default_rng(5)
SHOWN = RNG.normal(0.0, 1.0, COUNT)  # what the place changes, per metre
OTHER = SHOWN + RNG.normal(0.0, 0.5, COUNT)  # what the one effect changes, which looks much like it
NOISE = RNG.normal(0.0, 1.0, COUNT)
KEY = ("steer_lag", "tau")


class World:
    """Residuals that are linear in the place and in one effect's value, whose truth is 0."""

    channels = ("yaw_rate", "ay")

    def __init__(self, ay_x: float, true: float = TRUE) -> None:
        car = SimpleNamespace(ay_x=ay_x, wheelbase=WHEELBASE)
        self.experiments = (SimpleNamespace(model=SimpleNamespace(car=car)),)
        self.true = true

    def whitened(self, values: Any) -> Any:
        return NOISE + (values.get(PLACE, 0.0) - self.true) * SHOWN + values[KEY] * OTHER


def a_search(world: World, tyres: bool = True) -> Any:
    def trial(names: Any, values: Any, like: Any = None) -> Any:
        free = world.whitened({**values, KEY: 0.0})
        value = -float(OTHER @ free) / float(OTHER @ OTHER)
        rest = free + value * OTHER
        fit = SimpleNamespace(residual=rest, jacobian=OTHER[None, :])
        return SimpleNamespace(names=names, values={**values, KEY: value}, fit=fit, chi2=float(rest @ rest))

    effect = SimpleNamespace(effect=SimpleNamespace(tyres=tyres))
    return SimpleNamespace(target=world, count=COUNT, known={"steer_lag": effect}, trial=trial)


def test_the_place_is_found_with_what_the_other_values_make_of_it() -> None:
    search = a_search(World(0.0))
    now = search.trial(("steer_lag",), {})
    assert abs(now.values[KEY]) > 0.5  # it makes up for the place
    found = placed(search, now, 0.05)
    assert found.values[PLACE] == pytest.approx(TRUE, abs=0.3)
    assert abs(found.values[KEY]) < 0.3
    assert found.chi2 < now.chi2 - 0.05 * COUNT


@pytest.mark.parametrize(
    ("ay_x", "tyres", "channels", "true"),
    [
        (0.5, True, ("ay",), TRUE),  # the model says it
        (0.0, False, ("ay",), TRUE),
        (0.0, True, ("yaw_rate",), TRUE),
        (0.0, True, ("ay",), 0.05),  # not worth it
    ],
)
def test_a_place_that_is_said_or_not_shown_is_kept(
    ay_x: float, tyres: bool, channels: tuple[str, ...], true: float
) -> None:
    world = World(ay_x, true)
    world.channels = channels  # type: ignore[assignment]
    search = a_search(world, tyres)
    now = search.trial(("steer_lag",), {})
    assert placed(search, now, 0.05) is now


def test_it_stays_between_the_bumpers() -> None:
    search = a_search(World(0.0, 50.0))
    found = placed(search, search.trial(("steer_lag",), {}), 0.05)
    assert found.values[PLACE] == 1.4 * WHEELBASE


def test_effects_are_tried_where_the_accelerometer_was_found() -> None:
    points = [{KEY: tau, PLACE: place} for tau in (0.2, 0.1) for place in (0.0, 1.5)]
    assert points_there(SimpleNamespace(values={}), points) == points  # type: ignore[arg-type]
    assert points_there(SimpleNamespace(values={PLACE: 1.5}), points) == points  # type: ignore[arg-type]
    found = points_there(SimpleNamespace(values={PLACE: 1.1}), points)  # type: ignore[arg-type]
    assert found == [{KEY: 0.2}, {KEY: 0.1}]
