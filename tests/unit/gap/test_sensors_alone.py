"""Effects of the sensors alone, asked beside dead reckoning: when one is told, and whose place it takes."""

from __future__ import annotations

from math import sqrt
from typing import Any

import pytest

from pytest_dvp.gap.diagnose import sensors_alone as module
from pytest_dvp.gap.diagnose.held_out import Fold
from pytest_dvp.gap.diagnose.sensors_alone import sensor_effects, with_sensors_asked
from tests.unit.gap.linear_world import DRIVE, NEUTRAL, World, a_search, direction, tried
from vehicle.model.remainder_shape import RemainderShape

BIAS = ("gyro_bias", "b")
WANDERS = {"yaw": {"cruise": 0.002}}


@pytest.fixture(autouse=True)
def two_drives(monkeypatch: pytest.MonkeyPatch) -> None:
    """A world is its own experiment, as it is beside dead reckoning, too; all data together are those fitted on."""

    def together(experiments: Any, *, lasts: bool, reckons: bool) -> Any:
        assert (lasts, reckons) == (True, True)
        return experiments[0]

    monkeypatch.setattr(module, "ExperimentSet", together)
    monkeypatch.setattr(module, "all_data", lambda search, judges: [search.target, *(f.judge for f in judges)])


def a_world(row: float = 0.0, bias: float = 0.01, shape: RemainderShape | None = None, **more: Any) -> World:
    """A gyro that is off by `bias` takes row x bias standard deviations off."""
    found = World({BIAS: row * direction(0), **more.pop("does", {})}, {BIAS: bias, **more.pop("hidden", {})}, **more)
    found.model.remainder_shape = shape or RemainderShape(wanders=WANDERS)
    found.experiments = [found]  # type: ignore[list-item]
    return found


def told(fitted: World, *others: World, named: tuple[str, ...] = ()) -> tuple[tuple[str, ...], tuple[str, ...]]:
    search = a_search(fitted, "drive_gain", "gyro_bias", "mass")
    final = search.trial(named, {key: NEUTRAL[key] for key in fitted.does if key[0] in named})
    judges = tuple(Fold(None, other) for other in others)  # type: ignore[arg-type]
    found = with_sensors_asked(search, final, judges)
    return found.final.names, found.rivals


def test_only_what_changes_what_is_shown_is_an_effect_of_a_sensor() -> None:
    assert [c.name for c in sensor_effects(tried("gyro_bias", "mass", "steer_offset"))] == ["gyro_bias"]


@pytest.mark.parametrize(("here", "there", "names"), [
    (1050.0, 750.0, ("gyro_bias",)), (950.0, 750.0, ()), (1050.0, 650.0, ()),
])  # fmt: skip
def test_it_is_told_if_the_data_fitted_on_show_it_by_ten_standard_deviations_and_each_other_by_seven(
    here: float, there: float, names: tuple[str, ...]
) -> None:
    assert told(a_world(here), a_world(there)) == (names, ())
    assert told(a_world(here), a_world(2000.0), a_world(there)) == (names, ())


@pytest.mark.parametrize(("bias", "names"), [(0.0074, ()), (0.0076, ("gyro_bias",))])
def test_the_others_ask_for_half_of_it_at_least(bias: float, names: tuple[str, ...]) -> None:
    """2 x 0.74 - 1 is less than half, 2 x 0.76 - 1 is more."""
    assert told(a_world(5000.0), a_world(5000.0, bias)) == (names, ())


@pytest.mark.parametrize(("imitated", "names"), [(0.0034, ()), (0.0032, ("gyro_bias",))])
def test_it_is_larger_than_what_the_drives_of_the_twin_imitate(imitated: float, names: tuple[str, ...]) -> None:
    """By 4.3 / sqrt(2): 0.0103 and 0.0097 beside 0.01."""
    shape = RemainderShape(wanders=WANDERS, sensors={"gyro_bias": {"b": imitated}})
    assert told(a_world(5000.0, shape=shape), a_world(5000.0)) == (names, ())


@pytest.mark.parametrize(
    ("alike", "expected"),
    [(0.95, (("gyro_bias",), ())), (0.99, (("drive_gain",), ("gyro_bias",))), (1.0 / 0.98, (("drive_gain",), ()))],
)
def test_it_takes_the_place_of_a_name_that_explains_less_and_is_the_rival_of_one_that_explains_as_much(
    alike: float, expected: Any
) -> None:
    """The gain explains `alike` of what the bias does; or the bias of what the gain does."""
    bias, drive = direction(0), direction(1, 0, sqrt(min(alike, 1.0)))
    does = {BIAS: 5000.0 * bias, DRIVE: 500.0 * drive}
    hidden = {BIAS: 0.01, DRIVE: 1.0}
    if alike > 1.0:
        does = {BIAS: 5000.0 * direction(1, 0, sqrt(1.0 / alike)), DRIVE: 500.0 * direction(0)}
        hidden = {BIAS: 0.0, DRIVE: 1.1}
    worlds = [a_world(does=dict(does), hidden=dict(hidden)) for _ in range(2)]
    assert told(*worlds, named=("drive_gain",)) == expected


@pytest.mark.parametrize(("alike", "rivals"), [(0.98, ()), (0.99, ("steer_offset",))])
def test_what_is_often_confused_with_it_is_its_rival_if_it_explains_nearly_as_much(
    alike: float, rivals: tuple[str, ...]
) -> None:
    """An offset of the steering is no sensor's effect and is asked only then; a mass, which nobody takes for a bias,
    is not, though it does the same here."""
    does = {BIAS: 5000.0 * direction(0), ("steer_offset", "offset"): 5000.0 * direction(1, 0, sqrt(alike)),
            ("mass", "ratio"): 500.0 * direction(0)}  # fmt: skip
    fitted, other = (a_world(does=dict(does)) for _ in range(2))
    search = a_search(fitted, "gyro_bias", "mass", "steer_offset")
    found = with_sensors_asked(search, search.trial((), {}), (Fold(None, other),))  # type: ignore[arg-type]
    assert (found.final.names, found.rivals) == (("gyro_bias",), rivals)


def test_nothing_is_asked_of_a_set_without_another_drive_or_where_the_file_does_not_say_what_wanders() -> None:
    strong = a_world(5000.0, does={DRIVE: direction(1), ("mass", "ratio"): direction(2)})
    assert told(strong) == ((), ())
    assert told(strong, a_world(5000.0), named=("drive_gain", "mass")) == (("drive_gain", "mass"), ())
    assert told(strong, a_world(5000.0, shape=RemainderShape())) == ((), ())
    assert told(strong, a_world(5000.0)) == (("gyro_bias",), ())
