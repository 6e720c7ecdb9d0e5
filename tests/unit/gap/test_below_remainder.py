"""What a search goes on to find below what it cannot explain, where that counts as an error that lasts."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import pytest

from pytest_dvp.gap.diagnose import below_remainder as module
from pytest_dvp.gap.diagnose import fitted_twin
from pytest_dvp.gap.diagnose.below_remainder import (
    MOST,
    SHOWN_BELOW,
    Below,
    below_remainder,
    confused_with,
    shown_below,
    with_below,
)
from pytest_dvp.gap.diagnose.diagnosis import Estimate, Step
from pytest_dvp.gap.diagnose.fitted_twin import Drives, refitted, with_values
from pytest_dvp.gap.extend import extend as extend_module
from tests.unit.gap.linear_world import BRAKE, DRIVE, MODEL, World, direction, tried
from tests.unit.gap.test_extending_by_hand import MODEL as HAD
from tests.unit.gap.test_extending_by_hand import Course
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.remainder_shape import RemainderShape
from vehicle.model.vehicle_model import VehicleModel

BIAS = ("gyro_bias", "b")
NAMES = ("drive_gain", "brake_gain", "gyro_bias")


def one(value: float) -> Estimate:
    return Estimate(value, value, value, "-")


class Twin:
    """A twin with a remainder, and worlds in the place of its two drives."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, fitted: World, apart: World, *names: str) -> None:
        self.worlds = {"a": fitted, "b": apart}
        fitted.channels = {}
        self.drives = Drives({"a": None}, {"b": None})  # type: ignore[dict-item]
        self.model: Any = SimpleNamespace(remainder={"v": 1.0}, effects=[])
        monkeypatch.setattr(fitted_twin, "experiment_set", lambda logs, twin, extra: self.worlds[next(iter(logs))])
        monkeypatch.setattr(module, "candidates", lambda twin, effects, ay, refined: tried(*(names or NAMES)))
        monkeypatch.setattr(module, "with_below", lambda twin, drives, found: self._known(found))
        monkeypatch.setattr(module, "candidates_of", lambda twin, names: tried(*names))
        monkeypatch.setattr(World, "exact", lambda world, values: world.whitened(values), raising=False)

    def _known(self, found: Below) -> Any:
        """From now on the worlds are those of a car that has the effect."""
        for world in self.worlds.values():
            world.does = {key: row for key, row in world.does.items() if key[0] != found.name}
        return self.model

    def found(self) -> list[Below]:
        return below_remainder(self.model, self.drives)


def world(value: float, *, row: float = 1000.0, **more: Any) -> World:
    return World({DRIVE: row * direction(0), BRAKE: 1e-9 * direction(1), BIAS: 1e-9 * direction(2)}, {DRIVE: value},
                 **more)  # fmt: skip


def test_an_effect_counts_that_both_drives_ask_for_in_the_same_size(monkeypatch: pytest.MonkeyPatch) -> None:
    (found,) = Twin(monkeypatch, world(0.9), world(0.9)).found()
    assert found.name == "drive_gain"
    assert found.values[DRIVE] == pytest.approx(0.9, abs=1e-3)
    assert found.gain == pytest.approx(2 * (1000.0 * 0.1) ** 2, rel=0.01)
    assert found.parameters["g"].low < 0.9 < found.parameters["g"].high


@pytest.mark.parametrize(
    ("fitted", "row", "told"),
    [(0.79 * 0.025, 1000.0, False), (0.81 * 0.025, 1000.0, True)],
)
def test_the_data_fitted_on_must_show_it_by_twenty_standard_deviations(
    fitted: float, row: float, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    twin = Twin(monkeypatch, world(1.0 - fitted, row=row), world(1.0 - fitted, row=row))
    assert bool(twin.found()) is told


@pytest.mark.parametrize(("row", "told"), [(95.0, False), (105.0, True)])
def test_the_data_held_out_must_show_it_by_ten(row: float, told: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    twin = Twin(monkeypatch, world(0.9), world(0.9, row=row))
    assert bool(twin.found()) is told


@pytest.mark.parametrize(("there", "told"), [(0.926, False), (0.924, True)])
def test_the_data_held_out_must_gain_half_of_what_it_changes_there(
    there: float, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """2 x 0.074 x 0.1 - 0.1^2 is less than half of 0.1^2, 2 x 0.076 x 0.1 - 0.1^2 is more."""
    assert bool(Twin(monkeypatch, world(0.9), world(there)).found()) is told


@pytest.mark.parametrize(("size", "told"), [(0.019, False), (0.021, True)])
def test_an_effect_that_is_too_small_for_a_name_gets_none_here_either(
    size: float, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    twin = Twin(monkeypatch, world(1.0 - size, row=1e4), world(1.0 - size, row=1e4))
    assert bool(twin.found()) is told


def test_nothing_is_asked_without_a_remainder_or_without_data_held_out(monkeypatch: pytest.MonkeyPatch) -> None:
    twin = Twin(monkeypatch, world(0.9), world(0.9))
    assert below_remainder(twin.model, twin.drives._replace(held_out={})) == []
    twin.model.remainder = {}
    assert twin.found() == []
    assert shown_below(twin.model, twin.drives, tried("drive_gain")[0], {}) is None


@pytest.mark.parametrize(("brake", "names"), [(0.93, ("brake_gain",)), (0.94, ())])
def test_others_that_gain_at_least_half_as_much_are_rivals(
    brake: float, names: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """0.0714 of 0.1 is a little more than half, squared, 0.0612 less."""
    rows = {DRIVE: 1000.0 * direction(0), BRAKE: 1020.0 * direction(1)}
    two = [World(dict(rows), {DRIVE: 0.9, BRAKE: brake}) for _ in range(2)]
    first, second = Twin(monkeypatch, *two, "drive_gain", "brake_gain").found()
    assert (first.name, first.rivals) == ("drive_gain", names)
    assert (second.name, second.rivals) == ("brake_gain", ())


def test_no_more_than_the_most_are_found_and_each_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    twin = Twin(monkeypatch, world(0.9), world(0.9))
    monkeypatch.setattr(module, "with_below", lambda twin, drives, found: twin)
    told: list[str] = []
    assert len(below_remainder(twin.model, twin.drives, told.append)) == MOST
    assert told[1] == "what is left as an error that lasts: effect 2; so far drive_gain"


def test_the_road_and_the_wind_of_a_day_are_not_the_cars(monkeypatch: pytest.MonkeyPatch) -> None:
    twin = Twin(monkeypatch, world(0.9), world(0.9))
    (gain,) = tried("drive_gain")
    road = dataclasses.replace(gain, effect=dataclasses.replace(gain.effect, slot="road"))
    monkeypatch.setattr(module, "candidates", lambda twin, effects, ay, refined: [road])
    assert twin.found() == []
    monkeypatch.setattr(module, "candidates", lambda twin, effects, ay, refined: [gain])
    assert [each.name for each in twin.found()] == ["drive_gain"]
    monkeypatch.setattr(module, "_WIND", "drive_gain")
    assert twin.found() == []


def test_what_the_twin_has_is_not_found_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    twin = Twin(monkeypatch, world(0.9), world(0.9))
    twin.model.effects = [SimpleNamespace(name="drive_gain", values={"g": 0.9})]
    assert twin.found() == []


@pytest.mark.parametrize("start", [{}, {DRIVE: 0.9}])
@pytest.mark.parametrize(("there", "shown"), [(0.944, True), (0.951, False)])
def test_one_effect_by_name_has_to_pay_on_both_drives_in_whatever_size(
    there: float, shown: bool, start: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """2 x 0.056 x 0.1 - 0.1^2 is a little above nothing, 2 x 0.049 x 0.1 - 0.1^2 below; each times 1e6 is chi^2."""
    (drive,) = tried("drive_gain")
    twin = Twin(monkeypatch, world(0.9), world(there))
    found = shown_below(twin.model, twin.drives, drive, start)
    assert (found is not None) is shown
    assert found is None or found.values[DRIVE] == pytest.approx(0.9, abs=1e-3)


@pytest.mark.parametrize(("row", "shown"), [(190.0, False), (210.0, True)])
def test_one_effect_by_name_needs_twenty_standard_deviations_where_it_is_fitted(
    row: float, shown: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    twin = Twin(monkeypatch, world(0.9, row=row), world(0.9))
    assert (shown_below(twin.model, twin.drives, tried("drive_gain")[0], {}) is not None) is shown


def test_it_is_never_named_as_more_than_provisional_and_the_reason_is_said() -> None:
    named = Below("steer_lag", {"tau": one(0.04)}, 5000.0, ("steer_servo",)).as_named()
    assert (named.standing, named.rivals, named.gain) == ("provisional", ("steer_servo",), 0.0)
    assert named.doubts == ("these data cannot tell it from steer_servo", SHOWN_BELOW)
    assert Below("steer_lag", {"tau": one(0.04)}, 5000.0).as_named().doubts == (SHOWN_BELOW,)


@pytest.mark.parametrize(("better", "values"), [(True, (0.8, 0.85)), (False, (0.9, 0.95))])
def test_what_it_is_confused_with_is_fitted_anew_with_it_if_data_held_out_gain(
    better: bool, values: tuple[float, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    twin = MODEL.with_effect("drive_gain", {"g": 0.9})
    trial = SimpleNamespace(values={DRIVE: 0.8, BRAKE: 0.85})
    anew = SimpleNamespace(trial=trial, before=2.0, after=1.9 if better else 2.0)
    asked: list[Any] = []
    monkeypatch.setattr(module, "refitted", lambda grown, names, drives: asked.append(list(names)) or anew)
    monkeypatch.setattr(module, "remeasured", lambda twin, drives: twin)
    monkeypatch.setattr(module, "confused_with", lambda twin, name: ["drive_gain"])
    found = with_below(twin, Drives({}, {}), Below("brake_gain", {"g": one(0.95)}, 1.0))
    assert asked == [["drive_gain", "brake_gain"]]
    assert tuple(a.values["g"] for a in found.effects) == values


def test_an_effect_is_confused_with_those_of_the_twin_that_it_is_tied_to() -> None:
    twin = MODEL
    for name, values in {"drive_delay": {"T": 0.1}, "mass": {"ratio": 1.1}, "drive_lag": {"tau": 0.1}}.items():
        twin = twin.with_effect(name, values)
    assert confused_with(twin, "drive_lag") == ["drive_delay"]
    assert confused_with(twin, "drive_delay") == ["drive_lag"]
    assert confused_with(twin, "mass") == []


@pytest.mark.parametrize(("has", "names"), [((), []), (("drive_gain",), ["mass"])])
def test_what_has_stood_for_an_effect_as_far_as_it_could_is_fitted_along(
    has: tuple[str, ...], names: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A gain of 1 has made up for 0.8 of a mass of 1.1. Beside it as it is, the mass takes 22 standard deviations off
    the data fitted on and 7 off the others; with the gain fitted along, 36 and 12."""
    both, mass = direction(0), ("mass", "ratio")
    two = [
        World({DRIVE: row * both, mass: row * (0.8 * both + 0.6 * direction(1))}, {DRIVE: 0.92, mass: 1.1})
        for row in (600.0, 200.0)
    ]
    twin = Twin(monkeypatch, *two, "mass")
    twin.model.effects = [SimpleNamespace(name=name, values={"g": 1.0}) for name in has]
    assert [found.name for found in twin.found()] == names


def test_a_joint_fit_says_what_the_data_held_out_leave_before_and_after(monkeypatch: pytest.MonkeyPatch) -> None:
    twin = Twin(monkeypatch, world(0.8), world(0.85))
    twin.model.effects = [SimpleNamespace(name="drive_gain", values={"g": 0.9})]
    monkeypatch.setattr(fitted_twin, "candidates_of", lambda model, names: tried(*names))
    found = refitted(twin.model, ["drive_gain"], twin.drives)
    assert found.trial.values[DRIVE] == pytest.approx(0.8, abs=1e-3)
    assert (found.before, found.after) == (pytest.approx(1000.0 + 50.0**2), pytest.approx(1000.0 + 50.0**2, rel=0.02))


def test_values_are_taken_of_effects_that_a_model_has_or_gets_and_of_its_inputs_and_its_car() -> None:
    model = MODEL.with_effect("drive_gain", {"g": 0.9})
    values = {DRIVE: 0.8, BRAKE: 0.7, BIAS: 0.1, ("inputs", "steer_scale"): 0.5, ("parameters", "ay_x"): 0.3}
    found = with_values(model, values, [find_effect("brake_gain")])
    assert [(a.name, a.values["g"]) for a in found.effects] == [("drive_gain", 0.8), ("brake_gain", 0.7)]
    assert (found.inputs.steer_scale, found.car.ay_x) == (0.5, 0.3)
    assert [(a.name, a.values["g"]) for a in with_values(model, {}).effects] == [("drive_gain", 0.9)]


# --- `extend`: what explains too little is asked once more, where what is left lasts


@pytest.mark.parametrize(("shows", "names"), [(("mass", "drive_gain"), ["mass", "drive_gain"]), (("mass",), ["mass"])])
def test_effects_are_taken_that_are_shown_beside_those_before_them(
    shows: tuple[str, ...], names: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Any] = []

    def shown(twin: str, drives: Any, candidate: Any, start: Any) -> Below | None:
        asked.append((twin, candidate.name, start))
        return Below(candidate.name, {}, 1.0) if candidate.name in shows else None

    monkeypatch.setattr(extend_module, "shown_below", shown)
    monkeypatch.setattr(extend_module, "with_below", lambda twin, drives, found: f"{twin} + {found.name}")
    twin: Any = "twin"
    refused = tried("drive_gain", "mass")[::-1]
    grown, found = extend_module._grown_below(twin, refused, {DRIVE: 0.9}, Drives({}, {}))
    assert asked == [("twin", "mass", {DRIVE: 0.9}), ("twin + mass", "drive_gain", {DRIVE: 0.9})]
    assert [each.name for each in found] == names
    assert grown == " + ".join(["twin", *names])


def test_a_remainder_that_is_measured_anew_does_not_hold_the_old_one(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[VehicleModel] = []
    monkeypatch.setattr(fitted_twin, "experiment_set", lambda logs, twin, extra: seen.append(twin) or world(1.0))
    monkeypatch.setattr(fitted_twin, "folds", lambda logs, held_out, model, effects: ())
    monkeypatch.setattr(
        fitted_twin, "with_remainder", lambda model, search, final, judges: (model, final.names, judges)
    )
    old = dataclasses.replace(MODEL, remainder={"v": {"cruise": 1.0}})
    model, names, judges = fitted_twin.remeasured(old, Drives({"a": None}, {}))  # type: ignore[misc, dict-item]
    assert (model.remainder, model.remainder_shape, names, judges) == ({}, RemainderShape(), (), ())
    assert seen[0].remainder == {}


@pytest.mark.parametrize(
    ("shown", "fits", "refused"),
    [
        ((), [["mass", "steer_lag", "brake_gain"], ["brake_gain"]], "mass is wrong; steer_lag is wrong"),
        (("mass", "steer_lag"), [["mass", "steer_lag", "brake_gain"], ["brake_gain"]], "worse"),
        (("mass",), [["mass", "steer_lag", "brake_gain"], ["brake_gain"], ["steer_lag", "brake_gain"]],
         "steer_lag is wrong"),
    ],
)  # fmt: skip
def test_what_is_refused_sample_by_sample_is_asked_once_more_before_it_is(
    shown: tuple[str, ...], fits: list[list[str]], refused: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    course = Course(monkeypatch, wrong=("mass", "steer_lag"))
    course.shown = shown
    found = course.run(add=["mass", "steer_lag", "brake_gain"], held_out={"b": None})
    assert course.fits == fits
    assert course.asked["below"] == [
        ["mass", "steer_lag"],
        *([["mass"]] if len(fits) > 2 else []),
    ]
    assert course.asked["beside"] == [(list(shown), False), *([(list(shown), True)] if shown else [])]
    assert (found.refusal, found.model) == (refused, HAD if shown else "model")


def test_the_last_row_says_which_effects_were_fitted_where_what_is_left_lasts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Data held out are not better with all fitted anew there, so only the effect that is shown there is."""
    course = Course(monkeypatch, wrong=("mass",))
    course.shown = ("mass",)
    for name, value in {
        "beside_remainder": lambda twin, names, drives, always=False: (
            {("mass", "ratio"): one(1.2)} if always and list(names) == ["mass"] else {}
        ),
        "Search": lambda target, tried: SimpleNamespace(trial=lambda names, values: "as written"),
        "step": lambda search, trial, judges: Step(f"{trial}", 2.0, {}, {}, 2.5),
        "folds": lambda *asked: ("judge",),
    }.items():
        monkeypatch.setattr(extend_module, name, value)
    found = course.run(add=["mass"], held_out={"b": None})
    assert found.ladder[-1].change == "+ mass, where what is left lasts"
    assert found.notes[-2] == f"mass: {SHOWN_BELOW}"
    assert found.notes[-1].startswith("the last row, mass, where what is left lasts: they, and what they are often")
