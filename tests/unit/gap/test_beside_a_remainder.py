"""Where the parts of a diagnosis are asked beside a known remainder, and with which values."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import pytest

from pytest_dvp.gap.diagnose import imitation as imitation_module
from pytest_dvp.gap.diagnose import quiet_effects, removal, rivals, standing, veto
from pytest_dvp.gap.diagnose.beyond_remainder import is_evident_apart
from pytest_dvp.gap.diagnose.candidates import candidates
from pytest_dvp.gap.diagnose.diagnosis import Estimate, NamedEffect
from pytest_dvp.gap.diagnose.held_out import Fold
from pytest_dvp.gap.diagnose.imitation import of_other_drives, placebos
from pytest_dvp.gap.diagnose.removal import SearchSpace
from pytest_dvp.gap.diagnose.rivals import rivals_of
from pytest_dvp.gap.diagnose.search import Search, SearchResult
from pytest_dvp.gap.diagnose.standing import Evidence, with_standing
from pytest_dvp.gap.extend import twin_remainder
from tests.unit.gap.linear_world import BRAKE, DRIVE, World, a_search, a_trial, direction, tried
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.model_file import parse_model
from vehicle.model.remainder_shape import RemainderShape

FADE = ("brake_fade", "k")


def apart(world: World) -> Fold:
    return Fold(None, world)  # type: ignore[arg-type]


@pytest.mark.parametrize(("asks", "told"), [(0.926, False), (0.924, True)])
def test_the_data_fitted_on_must_ask_for_three_quarters_of_the_size_as_well(asks: float, told: bool) -> None:
    """2 x 0.074 x 0.1 - 0.1^2 is less than half of 0.1^2, 2 x 0.076 x 0.1 - 0.1^2 is more."""
    world = World({DRIVE: 1000.0 * direction(0)}, {DRIVE: asks}, excused=True)
    town = World({DRIVE: 1000.0 * direction(0)}, {DRIVE: 0.9})
    trial = a_trial(0.0, "drive_gain", values={DRIVE: 0.9})
    assert is_evident_apart(a_search(world, "drive_gain"), trial, "drive_gain", (apart(town),)) is told


@pytest.mark.parametrize("misfit", [True, False])
def test_hills_are_looked_for_in_the_place_of_a_set_where_much_is_left(
    misfit: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    world = World({DRIVE: 500.0 * direction(0)}, {DRIVE: 0.9}, excused=True)
    search = a_search(world, "drive_gain")
    asked: list[bool] = []
    monkeypatch.setattr(Search, "misfit", lambda self, trial: misfit)
    monkeypatch.setattr(quiet_effects, "quiet", lambda search, base, judges, placed: asked.append(placed))
    quiet_effects.single(search, search.trial(("drive_gain",), {DRIVE: 0.95}), ())
    assert asked == [misfit]


@pytest.mark.parametrize("placed", [True, False])
def test_what_lies_somewhere_is_asked_for_along_the_way_only_if_wanted(
    placed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The fading of the brakes stands for a hill here."""
    world = World({FADE: 1e6 * direction(0)}, {FADE: 0.0005}, excused=True)
    search = a_search(world, refiners=("brake_fade",))
    ways: list[str] = []
    monkeypatch.setattr(quiet_effects, "is_placed", lambda candidate: True)
    monkeypatch.setattr(
        quiet_effects, "along_the_way", lambda search, candidate: ways.append(candidate.name) or candidate.points
    )
    found = quiet_effects.quiet(search, search.trial((), {}), placed=placed)
    assert (found and found.names) == (("brake_fade",) if placed else None)
    assert ways == (["brake_fade"] if placed else [])


def test_of_a_set_that_grows_it_is_what_is_new_that_must_mean_something(monkeypatch: pytest.MonkeyPatch) -> None:
    """All but the question whether a value means something is answered with yes."""
    search = a_search(World({}, excused=True), "drive_gain", "mass")
    monkeypatch.setattr(Search, "trial", lambda self, names, values, target=None: a_trial(900.0, *names))
    grown = a_trial(900.0, "drive_gain", "mass")
    for name, answer in {"is_imitated": True, "_promising": [grown], "is_evident_apart": True, "_gain": 1.0}.items():
        monkeypatch.setattr(quiet_effects, name, lambda *given, answer=answer: answer)
    for sound, names in (("mass", ("drive_gain", "mass")), ("drive_gain", None)):
        monkeypatch.setattr(Search, "is_credible", lambda self, trial, name, target, sound=sound: name == sound)
        found = quiet_effects.quiet(search, a_trial(950.0, "drive_gain"), placed=False)
        assert (found and found.names) == names


@pytest.mark.parametrize("placed", [True, False])
def test_a_placebo_hill_is_looked_for_as_a_diagnosis_does(placed: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []

    class Look:
        def __init__(self, target: Any, now: Any) -> None: ...

        def remaining_chi2(self, candidate: Any, points: Any) -> list[Any]:
            asked.append(points)
            return []

    monkeypatch.setattr(imitation_module, "FirstOrderGain", Look)
    monkeypatch.setattr(imitation_module, "is_placed", lambda candidate: placed)
    monkeypatch.setattr(imitation_module, "along_the_way", lambda search, candidate: "the way")
    (candidate,) = tried("drive_gain")
    model: Any = SimpleNamespace(effects=[])
    placebos([World({DRIVE: direction(0)})], [candidate], model)  # type: ignore[list-item]
    assert asked == ["the way" if placed else candidate.points]


# --- rivals


class Rivals:
    """Rivals of the drive's gain, asked with drives that show it or not."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, *, excused: bool = True, there: float = 0.9) -> None:
        does = {DRIVE: 500.0 * direction(0), BRAKE: 500.0 * direction(1)}
        self.world = World(does, {DRIVE: 0.9}, excused=excused)
        self.judges = (apart(World(does, {DRIVE: there})),)
        self.search = a_search(self.world, "drive_gain", "brake_gain", "mass", "gyro_bias")
        self.final = self.search.trial(("drive_gain",), {DRIVE: 0.95})
        self.asked: list[Any] = []
        monkeypatch.setattr(rivals, "rivals_over_segments", self.over_segments)
        monkeypatch.setattr(rivals, "changing_instead", lambda search, final: {"drive_gain": ("steer_assist", "mass")})

    def over_segments(self, search: Any, judges: Any, best: Any, possible: Any = None) -> dict[str, tuple[str, ...]]:
        self.asked.append((search.target, judges, best, possible))
        return {"drive_gain": ("gyro_bias",)}

    def of(self, *met: str) -> tuple[str, ...]:
        found = SearchResult(self.final, {"drive_gain": met}, ())
        return rivals_of(self.search, self.judges, found)["drive_gain"]


def test_of_what_all_drives_show_only_rivals_that_are_often_confused_with_it_stay_from_the_search(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A mass is confused with a gain of the drive, a gain of the brakes is not."""
    assert Rivals(monkeypatch).of("brake_gain", "mass") == ("mass", "gyro_bias", "steer_assist")
    assert Rivals(monkeypatch, there=1.0).of("brake_gain", "mass") == (
        "brake_gain", "mass", "gyro_bias", "steer_assist",
    )  # fmt: skip
    assert Rivals(monkeypatch, excused=False).of("brake_gain", "mass") == (
        "brake_gain", "mass", "gyro_bias", "steer_assist",
    )  # fmt: skip


def test_rivals_over_segments_are_drawn_where_the_remainder_lasts(monkeypatch: pytest.MonkeyPatch) -> None:
    course = Rivals(monkeypatch)
    course.world.other = World({DRIVE: 500.0 * direction(0), BRAKE: 500.0 * direction(1)}, {DRIVE: 0.8})
    course.judges[0].judge.other = lasting = World({DRIVE: 500.0 * direction(0)}, {DRIVE: 0.8})  # type: ignore[attr-defined]
    course.of()
    ((target, judges, best, _),) = course.asked
    assert target is course.world.other
    assert [fold.judge for fold in judges] == [lasting]
    assert best.values[DRIVE] == pytest.approx(0.8, abs=2e-3)  # as it is told
    plain = Rivals(monkeypatch, excused=False)
    plain.of()
    assert plain.asked == [(plain.world, plain.judges, plain.final, None)]


def test_a_rival_over_segments_is_possible_if_all_drives_show_it_too(monkeypatch: pytest.MonkeyPatch) -> None:
    for there, brake, mass in ((0.9, False, True), (1.0, True, True)):
        course = Rivals(monkeypatch, there=there)
        course.of()
        possible = course.asked[0][3]
        values = {BRAKE: 0.9, ("mass", "ratio"): 1.1, DRIVE: 0.9}
        assert possible("drive_gain", a_trial(0.0, "brake_gain", values=values)) is brake  # no drive asks for it
        assert possible("drive_gain", a_trial(0.0, "mass", values=values)) is mass  # often confused
        assert possible("drive_gain", a_trial(0.0, "drive_gain", values=values)) is True


# --- the search and its judges


def test_a_search_space_asks_for_one_effect_first_and_knows_whether_drives_are_held_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    final = a_trial(1000.0, "mass")
    monkeypatch.setattr(Search, "run", lambda self: SearchResult(final, {}, ()))
    monkeypatch.setattr(removal, "refined", lambda search, trial, rivals: trial)
    asked: list[Any] = []

    def instead(search: Any, trial: Any, judges: Any) -> Any:
        asked.append((trial, judges))
        return dataclasses.replace(trial, names=("one",))

    monkeypatch.setattr(removal, "single", instead)
    monkeypatch.setattr(removal, "quiet", lambda *more: pytest.fail("one effect is there already"))
    world: Any = World({}, excused=True)
    part = (Fold(world, world),)  # a part of the drive
    for judges, held_out in (((apart(world),), True), (part, False), ((), False)):
        search, found = SearchSpace(world, (), (), (), {}, lambda text: None, judges).run({})
        assert found.final.names == ("one",)
        assert asked.pop() == (final, judges)
        assert search.apart is held_out


def test_what_may_be_a_fragment_is_judged_with_the_values_that_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """The plain metric asks for 0.9, the one in which the remainder lasts for 0.8."""
    does = {DRIVE: 500.0 * direction(0)}
    world = World(does, {DRIVE: 0.9}, excused=True, other=World(does, {DRIVE: 0.8}))
    search = a_search(world, "drive_gain")
    final = search.trial(("drive_gain",), {DRIVE: 0.95})
    asked: list[float] = []
    monkeypatch.setattr(veto, "LITTLE", 1e9)
    monkeypatch.setattr(
        veto, "is_beyond_remainder", lambda search, trial, name, judges: asked.append(trial.values[DRIVE]) or True
    )
    veto._veto(search, SearchResult(final, {}, ()), (apart(World(does, {DRIVE: 0.9})),), lambda: (), fragment=1e9)
    assert asked == [pytest.approx(0.8, abs=2e-3)]


# --- standing and the file of the twin


@pytest.mark.parametrize("excused", [True, False])
def test_what_speaks_against_a_value_is_said_where_it_is_told(excused: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    lower = ("brake_limit", "limit")
    world = World({}, excused=excused, other=World({}))
    world.model.remainder_shape = RemainderShape(unseen={"brake_limit": {"limit": 5.0}})
    search = a_search(world, "brake_limit", "drive_gain")
    final = a_trial(1000.0, "brake_limit", "drive_gain", values={lower: 6.0, DRIVE: 0.9}, fitted=2)
    told = dataclasses.replace(final, values={lower: 6.0, DRIVE: 5.0})
    asked: list[Any] = []
    monkeypatch.setattr(standing, "_held_out", lambda *more: [])
    monkeypatch.setattr(standing._Left, "__init__", lambda self, search, trial: asked.append((search.target, trial)))
    monkeypatch.setattr(standing._Left, "doubts", lambda self, name: [])
    named = [
        NamedEffect("brake_limit", {"limit": Estimate(6.0, 5.5, 6.5, "m/s^2")}),
        NamedEffect("drive_gain", {"g": Estimate(0.99, 0.9, 1.1, "-")}),
    ]
    known = {name: find_effect(name) for name in ("brake_limit", "drive_gain")}
    limit, gain = with_standing(named, search, final, [], Evidence({}, {}, {}, told=told), known)
    assert limit.doubts == (
        "the drives that the twin was learnt from do not come to limit = 6: it may be older than this",
    )
    unsure = "the twin's known remainder imitates as much" if excused else "its interval holds what the model has"
    assert gain.doubts == (unsure, "g = 5 stands where the search ends: no estimate")
    assert asked == [(world.other if excused else world, told)]
    evident = Evidence({}, {}, {}, evident=("drive_gain",), told=told)
    _, gain = with_standing(named, search, final, [], evident, known)
    # However evident an effect is: what is told of it must agree with itself.
    assert gain.doubts == (unsure, "g = 5 stands where the search ends: no estimate")
    _, gain = with_standing(named, search, final, [], Evidence({}, {}, {}, evident=("drive_gain",)), known)
    assert gain.doubts == (unsure,)
    assert asked[-1][1] is final
    besides = Evidence({}, {}, {}, evident=("drive_gain",), besides=True)
    _, gain = with_standing(named, search, final, [], besides, known)
    assert gain.doubts[-1].startswith("data held out leave far more")


def test_the_shape_of_a_remainder_holds_all_that_the_drives_say_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, answer in {
        "experiment_set": lambda logs, twin, extra: SimpleNamespace(
            channels=("v", "ay"), lasting=lambda: "lasting", reckoned=lambda: "reckoned"
        ),
        "candidates": lambda twin, known, *, ay, refined: tried("mass", "gyro_bias"),
        "placebos": lambda groups, tried, twin: ({"mass": {"ratio": 0.2}}, {"jerk_limit": {"limit": 9.0}}),
        "imitation": lambda groups, tried: (
            {"mass": {"ratio": 0.1}, "roll": {"gain": 0.3}}
            if groups[0] == "lasting"
            else {c.name: {"b": 0.001} for c in tried}
        ),
        "of_other_drives": lambda twin, tried: {"road_bank": {"slope": 0.01}},
        "unseen": lambda groups, tried, twin: {"power_limit": {"limit": float(len(groups))}},
        "_anew": lambda groups: {"ax": 2.0},
    }.items():
        monkeypatch.setattr(twin_remainder, name, answer)
    twin = dataclasses.make_dataclass("Twin", ["remainder", "remainder_shape"])({"v": 1.0}, RemainderShape({"v": 0.1}))
    shape = twin_remainder.with_shape(twin, {"a": None}, {"b": None}, ()).remainder_shape  # type: ignore[arg-type, dict-item]
    assert shape == RemainderShape(
        {"v": 0.1}, {"mass": {"ratio": 0.2}, "roll": {"gain": 0.3}, "road_bank": {"slope": 0.01}}, {"ax": 2.0},
        {"jerk_limit": {"limit": 9.0}}, {"power_limit": {"limit": 2.0}}, sensors={"gyro_bias": {"b": 0.001}},
    )  # fmt: skip
    three: Any = {"a": None, "b": None, "c": None}  # nothing held out: each drive says what it looks like
    assert twin_remainder.with_shape(twin, three, {}, ()).remainder_shape.unseen == {"power_limit": {"limit": 3.0}}  # type: ignore[arg-type]
    alone = twin_remainder.with_shape(twin, {"a": None}, {}, ())  # type: ignore[arg-type, dict-item]
    assert alone.remainder_shape.unseen == {"power_limit": {"limit": 1.0}}
    bare = dataclasses.replace(twin, remainder={})
    assert twin_remainder.with_shape(bare, {"a": None}, {}, ()) is bare  # type: ignore[arg-type, dict-item]


def test_the_road_and_the_air_of_a_twin_are_those_of_its_drives() -> None:
    """Others have their own, which may be as large and to the other side. What the car has goes with it."""
    car = "[model]\nname = 'car'\n[parameters]\nwheelbase = 2.5\n"
    road = "[[effect]]\nname = 'road_bank'\nparameters = {slope = {value = -0.0064}, heading = {value = 0.3}}\n"
    wind = "[[effect]]\nname = 'headwind'\nparameters = {speed = {value = 3.0}, k = {value = 0.0006}}\n"
    rolling = "[[effect]]\nname = 'rolling_resistance'\nparameters = {c = {value = 0.1}}\n"
    twin = parse_model(car + road + wind + rolling)
    among = candidates(twin, [find_effect(name) for name in ("road_bank", "headwind", "rolling_resistance")], ay=True)
    found = of_other_drives(twin, among)
    assert found["road_bank"] == {"slope": 0.0064}
    assert found["headwind"]["speed"] == 3.0
    assert set(found) == {"road_bank", "headwind"}
    assert of_other_drives(parse_model(car), among) == {}


@pytest.mark.parametrize(("gears", "apart"), [("", {}), ("1.6", {"limit": pytest.approx(1.2)})])
def test_a_force_that_each_gear_has_another_of_is_that_of_the_drives(gears: str, apart: dict[str, float]) -> None:
    """Greatest drive of 2 m/s^2 in one gear, next to gears 1.6 apart: in another one it may as well be 0.8 or 3.2."""
    car = "[model]\nname = 'car'\n[inputs]\nlongitudinal = 'accel_cmd'\n[parameters]\nwheelbase = 2.5\n"
    limit = "[[effect]]\nname = 'drive_torque_limit'\nparameters = {limit = {value = 2.0}}\n"
    box = "[[effect]]\nname = 'gear_changes'\n"
    box += "parameters = {T = {value = 0.4}, v1 = {value = 4.0}, step = {value = 1.6}}"
    twin = parse_model(car + limit + (box if gears else ""))
    among = candidates(twin, [find_effect("drive_torque_limit"), find_effect("gear_changes")], ay=True)
    assert of_other_drives(twin, among).get("drive_torque_limit", {}) == apart
