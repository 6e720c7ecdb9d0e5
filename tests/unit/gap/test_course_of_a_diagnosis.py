"""The course of a whole diagnosis on residuals that are linear in the values: what its parts are asked, what is told.

The drive and the brake of the car are 10 % too weak: 900 and 400 of chi^2 beyond the 1,000 of the noise.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from pytest_dvp.gap.diagnose import diagnose as module
from pytest_dvp.gap.diagnose import rivals
from pytest_dvp.gap.diagnose.below_remainder import Below
from pytest_dvp.gap.diagnose.diagnose import diagnose
from pytest_dvp.gap.diagnose.diagnosis import Estimate
from pytest_dvp.gap.diagnose.held_out import Fold
from pytest_dvp.gap.diagnose.removal import Searched
from pytest_dvp.gap.diagnose.search import SearchResult
from pytest_dvp.gap.diagnose.tied_effects import Tied
from pytest_dvp.gap.diagnose.veto import Judged
from tests.unit.gap.linear_world import BRAKE, DRIVE, MOTOR, ROWS, World, a_search, direction, tried
from vehicle.model.command_inputs import Inputs
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.remainder_shape import RemainderShape


class Data(World):
    """A world with all that a diagnosis tells of its data."""

    independent = 500.0

    def __post_init__(self) -> None:
        super().__post_init__()
        level = self.noise
        self.channels = self.channels or {"v": 1.0}
        self.bare: Any = World(self.does, self.hidden, level)
        self.noise: Any = lambda: {"v": 0.03}

    def whitened(self, values: Any) -> Any:
        return self.bare.whitened(values)

    def by_channel(self, values: Any) -> dict[str, float]:
        found: dict[str, float] = self.bare.by_channel(values)
        return found

    slopes = 0.0

    def slides(self) -> tuple[float, float]:
        return 0.25, 0.125

    def exact(self, values: Any) -> Any:
        return self.whitened(values)


class Course:
    """A diagnosis whose search and judges are given; `asked` notes what its parts are asked."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, *names: str, **given: Any) -> None:
        does = {DRIVE: 300.0 * direction(0), BRAKE: 200.0 * direction(1)}
        self.world = Data(does, {DRIVE: 0.9, BRAKE: 0.9}, **given)
        self.search = a_search(self.world, "drive_gain", "brake_gain")
        self.final = self.search.trial(names, dict.fromkeys((DRIVE, BRAKE), 0.9))
        self.found = SearchResult(self.final, {"drive_gain": ("mass",)}, ("mass", "drive_gain"))
        self.asked: dict[str, Any] = {}
        self.said: list[str] = []
        self.removed: dict[tuple[str, str], float] = {}
        self.gains, self.vetoed, self.judges = {"drive_gain": 0.5}, (), ()
        self.model: Any = SimpleNamespace(
            effects=[], drives_nothing=False, inputs=Inputs(), remainder={"v": {"all": 0.1}},
            remainder_shape=SimpleNamespace(imitates={}),
        )  # fmt: skip
        put = monkeypatch.setattr
        put(module, "experiment_set", lambda logs, model, extra: self.world)
        put(module, "input_map", lambda model: ((), {}))
        put(module, "candidates", self.candidates)
        put(module, "searched", self.searched)
        put(module, "folds", lambda logs, held_out, model, effects: self.judges)
        put(module, "judged", self.judged)
        put(rivals, "rivals_over_segments", lambda *asked: self.note("segments", {"drive_gain": ("x",)}))
        put(rivals, "changing_instead", lambda search, final: self.note("changing", {"drive_gain": ("mass", "y")}))
        put(module, "with_sensors_asked", lambda search, final, judges: Tied(final, ()))
        put(module, "opinions", lambda logs, model, named: self.note("opinions", {}, named))
        put(module, "votes", lambda logs, model: {"first": None})
        put(module, "Dependences", lambda target, trial, effects: SimpleNamespace(of=self.dependence))
        put(module, "is_beyond_remainder", self.is_beyond)
        put(module, "with_standing", self.with_standing)
        put(module, "diagnose_perceptions", lambda logs, model, twins: ())
        put(module, "signature", lambda target, values: {"reading": "something"})
        put(module, "lost_held_out", lambda model, name, final, judges: 0.3)

    def note(self, name: str, answer: Any, given: Any = True) -> Any:
        self.asked[name] = given
        return answer

    def candidates(self, model: Any, known: Any, *, ay: bool, refined: bool) -> Any:
        self.asked["ay"] = ay
        return [*self.search.tried.values()]

    def searched(self, space: Any, model: Any) -> Searched:
        self.asked["tried"] = [c.name for c in space.tried]
        self.asked["judges"] = space.judges
        self.asked["refiners"] = [c.name for c in space.refiners]
        return Searched(self.search, self.found, self.removed, ("mass",) if self.removed else ())

    def judged(self, search: Any, found: Any, judges: Any, apart: Any) -> Judged:
        return Judged(found, self.vetoed, self.gains, judges)

    def is_beyond(self, search: Any, trial: Any, name: str, judges: Any) -> bool:
        self.asked["beyond"] = trial
        return name == "brake_gain"

    def dependence(self, name: str) -> Any:
        return f"{name} changes" if name == "drive_gain" else None

    def with_standing(self, named: Any, search: Any, final: Any, logs: Any, evidence: Any, known: Any) -> Any:
        self.asked["evidence"] = evidence
        return named

    def run(self, **given: Any) -> Any:
        return diagnose({"a": None}, self.model, tick=self.said.append, **given)  # type: ignore[dict-item]


def test_effects_are_told_in_the_order_of_what_they_explain_with_their_shares(monkeypatch: pytest.MonkeyPatch) -> None:
    course = Course(monkeypatch, "brake_gain", "drive_gain")
    told = course.run()
    assert told.verdict == "AMBIGUOUS"  # the drive has a rival
    assert [(e.name, e.action, e.rivals) for e in told.effects] == [
        ("drive_gain", "add", ("mass",)), ("brake_gain", "add", ()),
    ]  # fmt: skip
    assert [e.gain for e in told.effects] == pytest.approx([900.0 / 1300.0, 400.0 / 1300.0], abs=1e-3)
    assert [e.held_out_gain for e in told.effects] == [0.5, None]
    assert [e.parameters["g"].value for e in told.effects] == pytest.approx([0.9, 0.9], abs=1e-3)
    assert [(s.added, s.chi2_per_n) for s in told.ladder] == [
        ("", pytest.approx(2.3)), ("drive_gain", pytest.approx(1.4, abs=1e-3)),
        ("brake_gain", pytest.approx(1.0, abs=1e-3)),
    ]  # fmt: skip
    assert told.not_excited == ("mass",)  # what is named was excited
    assert (told.noise_floor, told.votes, told.signature) == ({"v": 0.03}, {"first": None}, {})
    assert told.values == {DRIVE: pytest.approx(0.9, abs=1e-3), BRAKE: pytest.approx(0.9, abs=1e-3), MOTOR: 0.0}
    samples = told.samples
    assert (samples.count, samples.independent, samples.slides, samples.left_out) == (ROWS, 500.0, 0.25, 0.125)
    assert told.remainder == {"v": {"all": 0.1}}
    document = told.as_dict()
    assert document["chi2_per_n"]["fit"] == {"before": pytest.approx(2.3), "after": pytest.approx(1.0, abs=1e-3)}
    assert document["error"]["fit"]["before"] == dict(told.ladder[0].rmse)
    assert document["error"]["fit"]["after"] == dict(told.ladder[2].rmse)
    assert "segments" not in course.asked  # near the noise no draws are needed


@pytest.mark.parametrize(("open_from", "first"), [(0.89, "brake_gain"), (0.91, "drive_gain")])
def test_what_may_be_older_than_the_twin_is_told_after_what_is_new(
    monkeypatch: pytest.MonkeyPatch, open_from: float, first: str
) -> None:
    """The drive explains more than the brake; the drives of the twin would not have shown it from `open_from` on."""
    course = Course(monkeypatch, "brake_gain", "drive_gain")
    course.world.model.remainder_shape = RemainderShape(unseen={"drive_gain": {"g": open_from}})
    told = course.run()
    assert told.effects[0].name == first
    assert told.ladder[1].added == first


def test_the_second_engine_and_the_standing_are_asked_with_what_was_found(monkeypatch: pytest.MonkeyPatch) -> None:
    course = Course(monkeypatch, "drive_gain", "brake_gain", excused=True)
    course.world.other = course.world
    course.judges = (Fold(None, course.world),)  # type: ignore[assignment, arg-type]
    course.search.known |= {c.name: c for c in tried("mass")}
    told = course.run()
    named = course.asked["opinions"]
    assert {name: values["g"] for name, values in named.items()} == pytest.approx(
        {"drive_gain": 0.9, "brake_gain": 0.9}, abs=1e-3
    )
    evidence = course.asked["evidence"]
    assert evidence.held_out == {"drive_gain": 0.5}
    assert evidence.dependence == {"drive_gain": "drive_gain changes"}
    assert evidence.evident == ["brake_gain"]
    assert evidence.told is course.asked["beyond"]  # judged with the values that are told
    assert evidence.told is not course.final
    assert course.asked["judges"] is course.judges
    assert told.effects[0].rivals == ("mass", "x", "y")  # each of them once
    assert told.effects[1].rivals == ()
    plain = Course(monkeypatch, "drive_gain", "brake_gain")
    plain.run()
    assert plain.asked["evidence"].evident == []


def test_where_more_than_noise_is_left_rivals_are_drawn_over_segments_and_it_is_told_what_is_left(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The brake alone: 900 of 1,000 are left."""
    course = Course(monkeypatch, "brake_gain")
    told = course.run()
    assert told.verdict == "PARTIAL"
    assert told.signature == {"reading": "something"}
    assert {"segments", "changing"} <= set(course.asked)
    assert course.world.settled == [dict(course.final.values)]
    assert told.not_excited == ("mass", "drive_gain")
    none = Course(monkeypatch)
    told = none.run()
    assert (told.verdict, told.effects, told.signature) == ("UNKNOWN", (), {"reading": "something"})
    assert len(told.ladder) == 1


def test_nothing_is_missing_or_was_not_excited(monkeypatch: pytest.MonkeyPatch) -> None:
    course = Course(monkeypatch)
    course.world.does.clear()
    course.final = course.search.trial((), {})
    course.found = SearchResult(course.final, {}, ("mass",))
    told = course.run()
    assert (told.verdict, told.signature, told.car) == ("NOTHING_MISSING", {}, {})  # one of two that were tried
    course.found = SearchResult(course.final, {}, ("mass", "drive_gain"))
    assert course.run().verdict == "NOT_EXCITED"
    course.model.drives_nothing = True  # a model that stands says nothing of what a drive shows
    assert course.run().not_excited == ()


def test_what_the_car_lacks_is_told_after_what_is_added_and_before_the_ladder(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the effect of the model 1,300 of chi^2 are beyond the noise in place of 2,200: it costs 900."""
    course = Course(monkeypatch, "brake_gain", "drive_gain")
    course.removed = {("mass", "ratio"): 1.0, ("mass", "height"): 0.0}
    steps = [SimpleNamespace(chi2_per_n=3.2)]
    monkeypatch.setattr(module, "_given", lambda search, gone, judges: course.note("gone", steps, gone))
    told = course.run()
    assert course.asked["gone"] == ("mass",)
    assert [e.name for e in told.effects] == ["drive_gain", "brake_gain", "mass"]
    removed = told.effects[-1]
    assert (removed.action, removed.held_out_gain, removed.rivals) == ("remove", 0.3, ("mass",))
    assert removed.gain == pytest.approx(900.0 / 2200.0, abs=1e-3)
    assert told.effects[0].gain == pytest.approx(900.0 / 2200.0, abs=1e-3)
    assert [s.chi2_per_n for s in told.ladder] == pytest.approx([3.2, 2.3, 1.4, 1.0], abs=1e-3)
    assert told.ladder[1].added == "mass"  # the first rung is the model without it


def test_an_effect_that_the_model_has_is_changed_and_the_cars_parameters_are_told(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    course = Course(monkeypatch, "drive_gain", "brake_gain")
    course.model.effects = [SimpleNamespace(name="brake_gain")]
    course.final.values["parameters", "ay_x"] = 0.3
    told = course.run()
    assert {e.name: e.action for e in told.effects} == {"drive_gain": "add", "brake_gain": "change"}
    assert told.car == {"ay_x": 0.3}


def test_effects_that_change_while_driving_come_late_unless_the_model_has_them(monkeypatch: pytest.MonkeyPatch) -> None:
    course = Course(monkeypatch, "drive_gain")
    effects = [find_effect(name) for name in ("brake_gain", "brake_fade")]
    assert effects[1].diagnosed.refines
    assert not effects[0].diagnosed.refines
    every = [SimpleNamespace(name=e.name, effect=e) for e in effects]
    monkeypatch.setattr(module, "candidates", lambda *given, **more: every)
    course.run()
    assert (course.asked["tried"], course.asked["refiners"]) == (["brake_gain"], ["brake_fade"])
    course.model.effects = [SimpleNamespace(name="brake_fade")]
    course.run()
    assert (course.asked["tried"], course.asked["refiners"]) == (["brake_gain", "brake_fade"], [])


@pytest.mark.parametrize("channels", [{"v": 1.0}, {"v": 1.0, "ay": 1.0}])
def test_where_the_lateral_accelerometer_sits_matters_only_if_there_is_one(
    channels: dict[str, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    course = Course(monkeypatch, "drive_gain", channels=channels)
    course.run()
    assert course.asked["ay"] is ("ay" in channels)


def test_an_error_that_only_the_held_out_data_show_is_looked_for_in_all_logs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a twin with a known remainder, where nothing is named and nothing is left on the data fitted on."""
    course = Course(monkeypatch, excused=True)
    course.world.other = course.world
    course.world.does.clear()
    course.final = course.search.trial((), {})
    course.found = SearchResult(course.final, {}, ())
    asked: list[Any] = []
    monkeypatch.setattr(module, "experiment_set", lambda logs, model, extra: asked.append(sorted(logs)) or course.world)
    wrong = Data({DRIVE: 300.0 * direction(0)}, {DRIVE: 0.9}, excused=True)
    wrong.other = wrong
    course.judges = (Fold(None, wrong),)  # type: ignore[assignment, arg-type]
    told = diagnose({"a": None}, course.model, {"b": None})  # type: ignore[dict-item]
    assert asked == [["a"], ["a", "b"]]
    assert told.verdict == "UNKNOWN"  # no effect explains it in all logs together, and it is there all the same
    asked.clear()
    course.judges = (Fold(None, course.world),)  # type: ignore[assignment, arg-type]
    diagnose({"a": None}, course.model, {"b": None})  # type: ignore[dict-item]
    assert asked == [["a"]]


@pytest.mark.parametrize(
    ("named", "held_out", "excused", "misfit", "asked"),
    [
        (("drive_gain",), True, False, True, True),
        (("drive_gain",), True, False, False, False),
        (("drive_gain",), True, True, True, False),
        (("drive_gain",), False, False, True, False),
        ((), True, False, True, False),
    ],
)
def test_a_search_goes_on_below_what_it_cannot_explain_if_other_drives_can_judge(
    named: Any, held_out: bool, excused: bool, misfit: bool, asked: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    course = Course(monkeypatch, *named, excused=excused)
    course.search.misfit = lambda trial: misfit  # type: ignore[method-assign]
    drives: list[Any] = []
    lag = ("steer_lag", "tau")
    value = Estimate(0.04, 0.03, 0.05, "s")
    monkeypatch.setattr(module, "with_values", lambda model, values, added: tuple(e.name for e in added))
    monkeypatch.setattr(module, "remeasured", lambda twin, drives: ("measured", twin))
    monkeypatch.setattr(
        module, "below_remainder",
        lambda twin, on, tick: drives.append((twin, on.held_out)) or [Below("steer_lag", {"tau": value}, 900.0)],
    )  # fmt: skip
    told = course.run(held_out={"b": None} if held_out else None)
    assert drives == ([(("measured", ("drive_gain",)), {"b": None})] if asked else [])
    assert [e.name for e in told.effects] == [*named, *(["steer_lag"] if asked else [])]
    assert told.values.get(lag) == (0.04 if asked else None)
    if asked:
        assert (told.effects[-1].standing, told.effects[-1].gain) == ("provisional", 0.0)
        assert [step.added for step in told.ladder] == ["", "drive_gain"]  # it takes next to nothing off the error


@pytest.mark.parametrize("excused", [True, False])
def test_of_a_twin_with_a_remainder_what_is_often_confused_is_asked_and_may_take_the_place(
    excused: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    course = Course(monkeypatch, "drive_gain", excused=excused)
    course.vetoed = ("brake_gain", "mass")
    course.search.misfit = lambda trial: False  # type: ignore[method-assign]
    brakes = course.search.trial(("brake_gain",), dict.fromkeys((DRIVE, BRAKE), 0.9))
    asked: list[Any] = []

    def tied(search: Any, final: Any, judges: Any) -> Tied:
        asked.append((search, final, judges))
        return Tied(brakes, ("gear_inertia", "z"))

    monkeypatch.setattr(module, "best_of_tied", tied)
    monkeypatch.setattr(module, "gained_apart", lambda trial, judges: 0.7)
    monkeypatch.setattr(module, "rivals_of", lambda search, judges, found: {"brake_gain": ("z", "y")})
    told = course.run()
    assert asked == ([(course.search, course.final, ())] if excused else [])
    assert told.names == (("brake_gain",) if excused else ("drive_gain",))
    if excused:
        assert told.effects[0].rivals == ("gear_inertia", "z", "y")
        assert told.effects[0].held_out_gain == 0.7
        assert told.vetoed == ("mass",)  # what is named is not said to be vetoed
    else:
        assert told.vetoed == ("brake_gain", "mass")


def test_what_a_sensor_explains_takes_the_place_with_its_own_rivals_and_is_evident(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    course = Course(monkeypatch, "drive_gain", excused=True)
    course.search.misfit = lambda trial: False  # type: ignore[method-assign]
    sensed = course.search.trial(("brake_gain",), {DRIVE: 1.0, BRAKE: 0.9})
    monkeypatch.setattr(module, "best_of_tied", lambda search, final, judges: Tied(final, ("a",)))
    monkeypatch.setattr(module, "gained_apart", lambda trial, judges: 0.6)
    monkeypatch.setattr(
        module, "rivals_of", lambda search, judges, found: dict.fromkeys(("brake_gain", "drive_gain"), ("y",))
    )
    monkeypatch.setattr(module, "with_sensors_asked", lambda search, final, judges: Tied(sensed, ("z",)))
    monkeypatch.setattr(module, "is_beyond_remainder", lambda *asked: False)
    told = course.run()
    assert [(e.name, e.rivals, e.held_out_gain) for e in told.effects] == [("brake_gain", ("z",), 0.6)]
    assert course.asked["evidence"].evident == ["brake_gain"]
    monkeypatch.setattr(module, "with_sensors_asked", lambda search, final, judges: Tied(final, ("z",)))
    assert course.run().effects[0].rivals == ("a", "z", "y")
    assert course.asked["evidence"].evident == []
