"""The course of `extend` and `diagnose` with every part given: what is asked of whom, and what is told."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose import diagnose as diagnose_module
from pytest_dvp.gap.diagnose.below_remainder import Below
from pytest_dvp.gap.diagnose.candidates import candidates
from pytest_dvp.gap.diagnose.diagnosis import Estimate, NamedEffect, Step
from pytest_dvp.gap.diagnose.search import Search, SearchResult
from pytest_dvp.gap.diagnose.standing import _nothing_sure
from pytest_dvp.gap.diagnose.tied_effects import Tied
from pytest_dvp.gap.extend import extend as extend_module
from pytest_dvp.gap.extend.acceptance import Acceptance
from pytest_dvp.gap.extend.extend import _chosen, _fitted, _wanted, extend
from pytest_dvp.gap.extend.extension import Rung
from tests.unit.gap.linear_world import DRIVE, World, a_search
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.errors import ModelError
from vehicle.model.model_file import parse_model
from vehicle.model.remainder_shape import RemainderShape

MODEL = parse_model("[model]\nname = 'c'\n[parameters]\nwheelbase = 2.5\nmass = 1200.0\n")
HAS = MODEL.with_effect("drive_gain", {"g": 0.9}).with_effect("detection_yaw", {"b": 0.1})


def one(value: float, unit: str = "-") -> Estimate:
    return Estimate(value, value - 0.1, value + 0.1, unit)


# --- what is meant


def test_each_effect_is_meant_once_and_must_be_known_and_suit_the_model() -> None:
    assert [e.name for e in _wanted(MODEL, ["mass", "drive_gain", "mass"], ())] == ["mass", "drive_gain"]
    mine = dataclasses.replace(find_effect("drive_gain"), name="my_gain")
    assert _wanted(MODEL, ["my_gain"], [mine]) == [mine]
    with pytest.raises(ModelError, match="did you mean 'mass'"):
        _wanted(MODEL, ["mas"], ())
    assert _wanted(MODEL, [], ()) == []


def test_what_needs_other_inputs_cannot_be_fitted() -> None:
    target: Any = SimpleNamespace(channels=("v",))
    found = _chosen(MODEL, [find_effect("drive_gain"), find_effect("steer_delay")], target)
    assert [c.name for c in found] == ["drive_gain", "steer_delay"]
    speed = dataclasses.replace(find_effect("drive_gain"), base=())
    with pytest.raises(ModelError) as refused:
        _chosen(MODEL, [speed], target)
    assert refused.value.key == "drive_gain"
    assert "cannot be fitted to this model: it needs other inputs than accel_cmd and steer_cmd" in str(refused.value)


# --- the course of an extension


class Course:
    """Every part of `extend`, given; notes what it was asked."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, *, wrong: Any = (), chi2: Any = (4.0, 1.0),
                 held: Any = (4.0, 1.0), channels: Any = None) -> None:  # fmt: skip
        self.asked: dict[str, Any] = {}
        self.ticks: list[str] = []
        self.wrong = set(wrong)
        self.fits: list[list[str]] = []
        self.shown: tuple[str, ...] = ()  # of what is refused, where what is left lasts
        target: Any = SimpleNamespace(by_channel=lambda values: channels or {"v": 1.0}, channels=("v",), slopes=0.0,
                                      noise=lambda: {"v": 0.1}, count=100)  # fmt: skip
        self.search: Any = SimpleNamespace(start={("inputs", "a"): 1.0}, target=target, nuisance=())
        self.final: Any = SimpleNamespace(names=(), values={}, fit=SimpleNamespace(coordinates=()))
        rungs = tuple(
            Rung("", Step("" if k == 0 else "mass", c, {}, {}, h))
            for k, (c, h) in enumerate(zip(chi2, held, strict=True))
        )
        for name, value in {
            "experiment_set": lambda logs, model, extra: target,
            "_search": self._search, "_fitted": self._fitted, "folds": lambda *asked: ("judge",),
            "ladder_of": self._ladder(rungs),
            "estimates": lambda final, search: {DRIVE: one(0.8), ("mass", "ratio"): one(1.1)},
            "judge_addition": self._judged("add"), "judge_removal": self._removed,
            "judge_perception": self._perception, "fitted_model": self._note("extended", "model"),
            "with_remainder": lambda extended, *more: extended, "with_shape": lambda twin, *more: twin,
            "beside_remainder": self._beside,
            "_grown_below": lambda twin, refused, begin, drives: self._below(twin, refused),
            "worse_together": lambda steps: ["worse"],
        }.items():  # fmt: skip
            monkeypatch.setattr(extend_module, name, value)

    def _below(self, twin: Any, refused: Any) -> Any:
        self.asked.setdefault("below", []).append([c.name for c in refused])
        return (MODEL if self.shown else twin), [Below(c.name, {}, 900.0) for c in refused if c.name in self.shown]

    def _beside(self, twin: Any, names: Any, drives: Any, always: bool = False) -> Any:
        self.asked.setdefault("beside", []).append((list(names), always))
        return {}

    def _search(self, target: Any, model: Any, tried: Any, lost: Any) -> Any:
        self.asked["search"] = ([c.name for c in tried], list(lost))
        return self.search

    def _fitted(self, search: Any, begin: Any, kept: Any, chosen: Any, *, together: bool) -> Any:
        self.asked["fitted"] = (dict(begin), list(kept), [c.name for c in chosen])
        self.asked["together"] = together
        self.fits.append([c.name for c in chosen])
        return self.final

    def _ladder(self, rungs: Any) -> Any:
        def ladder(search: Any, final: Any, kept: int, lost: Any, judges: Any, present: Any) -> Any:
            self.asked["ladder"] = (kept, list(lost), judges, set(present))
            return iter(rungs)

        return ladder

    def _judged(self, action: Any) -> Any:
        def judge(search: Any, final: Any, candidate: Any, judges: Any, model: Any, sure: Any) -> Acceptance:
            return self._said(candidate.name, action)

        return judge

    def _said(self, name: str, action: Any, **parameters: Any) -> Acceptance:
        effect = NamedEffect(name, parameters, action=action, gain=0.3)
        return Acceptance(effect, f"{name} is wrong" if name in self.wrong else "", f"{name} noted")

    def _removed(self, search: Any, final: Any, name: str, model: Any, judges: Any) -> Acceptance:
        return self._said(name, "remove", g=one(1.0))

    def _perception(self, model: Any, logs: Any, held_out: Any, seen: Any, blind: Any, twins: Any) -> Any:
        self.asked["perception"] = ([e.name for e in seen], list(blind), twins)
        return [self._said(e.name, "add", T=one(0.2, "s")) for e in seen] + [self._said(n, "remove") for n in blind]

    def _note(self, name: str, answer: Any) -> Any:
        def note(*asked: Any) -> Any:
            self.asked[name] = asked
            return answer

        return note

    def run(self, model: Any = HAS, **more: Any) -> Any:
        return extend({"a": None}, model, tick=self.ticks.append, **more)  # type: ignore[dict-item]


def test_what_moves_is_fitted_and_what_is_seen_is_told_by_detections(monkeypatch: pytest.MonkeyPatch) -> None:
    course = Course(monkeypatch)
    found = course.run(add=["mass", "detection_latency"], remove=["drive_gain", "detection_yaw"], fitted_on=["a.csv"],
                       start={("mass", "ratio"): 1.2}, twins={"s": None})  # fmt: skip
    assert course.ticks == ["preparing", "fitting", "held-out data", "fitting beside what is left"]
    assert course.asked["search"] == (["mass"], ["drive_gain"])
    begin, kept, chosen = course.asked["fitted"]
    assert begin == {("inputs", "a"): 1.0, DRIVE: 0.9, ("detection_yaw", "b"): 0.1, ("mass", "ratio"): 1.2}
    assert (kept, chosen) == ([], ["mass"])
    assert course.asked["ladder"] == (0, ["drive_gain"], ("judge",), {"drive_gain", "detection_yaw"})
    assert course.asked["perception"] == (["detection_latency"], ["detection_yaw"], {"s": None})
    assert [(e.name, e.action) for e in found.effects] == [
        ("mass", "add"), ("drive_gain", "remove"), ("detection_latency", "add"), ("detection_yaw", "remove"),
    ]  # fmt: skip
    assert [e.gain for e in found.effects] == [1.0, 0.3, 0.3, 0.3]  # of the ladder, or as it was told
    _, _, sure, removed, added, fitted_on = course.asked["extended"]
    assert set(sure) == {DRIVE, ("mass", "ratio"), ("detection_latency", "T")}
    assert sure[DRIVE].value == 0.8  # what is removed has no value of its own
    assert (list(removed), [e.name for e in added], fitted_on) == (
        ["drive_gain", "detection_yaw"], ["mass", "detection_latency"], ("a.csv",),
    )  # fmt: skip
    assert set(found.refitted) == {DRIVE}
    assert found.notes == tuple(f"{e.name} noted" for e in found.effects)
    assert (found.model, found.noise_floor, found.refusal, found.explained) == ("model", {"v": 0.1}, "", True)


@pytest.mark.parametrize(
    ("known", "together"),
    [
        ({("mass", "ratio"): 1.2, ("steer_delay", "T"): 0.1}, True),
        ({("mass", "ratio"): 1.2}, False),
        (None, False),
    ],
)
def test_what_was_fitted_together_goes_on_together(monkeypatch: pytest.MonkeyPatch, known: Any, together: bool) -> None:
    course = Course(monkeypatch)
    course.run(add=["mass", "steer_delay"], start=known)
    assert course.asked["together"] is together


def test_a_joint_fit_begins_with_all_at_once_where_all_are_known() -> None:
    """One after the other, a mass, a lag and a lifted pedal ended at 4.9 of chi^2/N, together at 1.8."""
    fits: list[tuple[tuple[str, ...], dict[Any, float]]] = []

    def trial(names: Any, values: Any, zoom: bool = False) -> Any:
        fits.append((tuple(names), dict(values)))
        return SimpleNamespace(names=tuple(names), values=dict(values), chi2=100.0)

    target = SimpleNamespace(settle=lambda values: None, whitened=lambda values: np.ones(3))
    search: Any = SimpleNamespace(trial=trial, target=target, count=100)
    chosen = [c for name in ("mass", "steer_delay") for c in candidates(HAS, [find_effect(name)], refined=True)]
    begin = {("mass", "ratio"): 1.2, ("steer_delay", "T"): 0.1}
    _fitted(search, begin, ["drive_gain"], chosen, together=True)
    assert fits[0] == (("drive_gain", "mass", "steer_delay"), begin)
    fits.clear()
    _fitted(search, begin, ["drive_gain"], chosen, together=False)
    assert fits[0][0] == ("drive_gain",)
    assert ("drive_gain", "mass") in [names for names, _ in fits]


def test_values_fitted_once_more_are_those_of_the_model_and_the_ladder_ends_with_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    course = Course(monkeypatch, chi2=(4.0, 1.0), held=(4.0, 3.0))
    asked: list[Any] = []
    for name, value in {
        "beside_remainder": lambda twin, names, drives, always=False: (
            asked.append((twin, names)) or {("mass", "ratio"): one(1.2)}
        ),
        "Search": lambda target, tried: SimpleNamespace(trial=lambda names, values: "as written"),
        "step": lambda search, trial, judges: Step(f"{trial} {judges}", 2.0, {}, {}, 2.5),
        "fitted_model": lambda model, final, sure, *more: {key: estimate.value for key, estimate in sure.items()},
    }.items():
        monkeypatch.setattr(extend_module, name, value)
    found = course.run(add=["mass"], held_out={"b": None})
    assert asked == [({DRIVE: 0.8, ("mass", "ratio"): 1.1}, [])]
    assert found.model == {("mass", "ratio"): 1.2}
    assert found.refitted[DRIVE] == one(0.8)
    assert [(rung.change, rung.step.chi2_per_n) for rung in found.ladder][1:] == [
        ("", 1.0), ("~ once more, where what is left lasts", 2.0)
    ]  # fmt: skip
    assert found.ladder[-1].step.added == "as written ('judge',)"
    assert found.notes[-1].startswith("the last row, once more, where what is left lasts: ")


@pytest.mark.parametrize(
    ("add", "remove", "kept"),
    [(["mass"], [], ["drive_gain"]), (["drive_gain"], [], []), (["mass"], ["drive_gain"], [])],
)
def test_all_others_are_fitted_again_where_that_is_asked_for(
    add: Any, remove: Any, kept: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    course = Course(monkeypatch)
    course.run(MODEL.with_effect("drive_gain", {"g": 0.9}), add=add, remove=remove, refit=True)
    assert course.asked["search"] == ([*kept, *add], remove)
    assert course.asked["fitted"][1] == kept
    assert course.asked["ladder"][0] == len(kept)


@pytest.mark.parametrize(
    ("more", "wrong", "refusal"),
    [
        ({"add": ["mass"]}, (), ""),
        ({"add": ["mass"], "held_out": {"b": None}}, (), "worse"),
        ({"add": [], "held_out": {"b": None}}, (), ""),
        ({"add": ["mass"], "refit": True}, (), "worse"),
        ({"add": ["mass"], "refit": True, "held_out": {"b": None}}, ("mass",), "mass is wrong"),
        ({"add": ["mass"], "remove": ["drive_gain"]}, ("mass", "drive_gain"), "mass is wrong; drive_gain is wrong"),
    ],
)
def test_why_a_model_is_refused(more: Any, wrong: Any, refusal: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """All together are judged where nothing is wrong by itself, and where something was fitted again or held out."""
    assert Course(monkeypatch, wrong=wrong).run(**more).refusal == refusal


@pytest.mark.parametrize(
    ("chi2", "held", "channels", "explained"),
    [
        ((4.0, 1.3), (4.0, 1.3), {"v": 1.5}, True),
        ((4.0, 1.31), (4.0, 1.0), {"v": 1.5}, False),
        ((4.0, 1.0), (4.0, 1.31), {"v": 1.5}, False),
        ((4.0, 1.0), (4.0, None), {"v": 1.5}, True),
        ((4.0, 1.0), (4.0, 1.0), {"v": 1.51}, False),
    ],
)
def test_all_is_explained_where_noise_is_left_on_both_data_and_in_each_channel(
    chi2: Any, held: Any, channels: Any, explained: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    course = Course(monkeypatch, chi2=chi2, held=held, channels=channels)
    assert course.run(add=["mass"]).explained is explained


# --- what a remainder imitates


@pytest.mark.parametrize(
    ("name", "parameters", "given", "excused", "doubt"),
    [
        ("drive_gain", {"g": (0.9, 1.1)}, {}, True, True),
        ("drive_gain", {"g": (0.9, 1.0)}, {}, True, True),  # its end
        ("drive_gain", {"g": (0.9, 0.99)}, {}, True, False),
        ("drive_gain", {"g": (1.01, 1.1)}, {}, True, False),
        ("drive_gain", {"g": (0.9, 1.1)}, {}, False, True),
        ("drive_gain", {"g": (0.7, 0.8)}, {"g": 0.75}, True, True),  # what the twin has already
        ("drive_gain", {"g": (0.9, 1.1)}, {"g": 0.75}, True, False),
        ("body_roll", {"gain": (-0.1, 0.1), "frequency": (1.0, 2.0)}, {}, True, True),  # how does not count
        ("body_roll", {"gain": (0.1, 0.2), "frequency": (0.0, 99.0)}, {}, True, False),
        ("steer_lag", {"tau": (-0.1, 0.1)}, {}, True, True),  # a lag only says how: that counts
        ("steer_lag", {"tau": (0.1, 0.2)}, {}, True, False),
    ],
)
def test_what_is_not_clear_of_what_the_twin_has_is_not_sure(
    name: str, parameters: Any, given: Any, excused: bool, doubt: bool
) -> None:
    shown = {key: Estimate(0.5 * (low + high), low, high, "-") for key, (low, high) in parameters.items()}
    said = ["the twin's known remainder imitates as much" if excused else "its interval holds what the model has"]
    assert _nothing_sure(NamedEffect(name, shown), find_effect(name), given, excused) == (said if doubt else [])


# --- a search rises without what comes late


@pytest.mark.parametrize("better", [False, True])
def test_a_set_rises_first_without_what_comes_late_and_then_with_it(
    better: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    search = a_search(World({}), "drive_gain")
    seen: list[tuple[str, bool, tuple[str, ...]]] = []

    def grown(self: Any, now: Any, turns: Any, barred: Any = (), most: int = 0, until: Any = None) -> Any:
        seen.append(("grown", self._late, now.names))
        return dataclasses.replace(now, names=(*now.names, f"g{len(seen)}"))

    def trial(self: Any, names: Any, start: Any, **more: Any) -> Any:
        seen.append(("trial", self._late, tuple(names)))
        return SimpleTrial(tuple(names))

    monkeypatch.setattr(Search, "grown", grown)
    monkeypatch.setattr(Search, "trial", trial)
    monkeypatch.setattr(Search, "_whole_actuator", lambda self, now: SimpleTrial((*now.names, "w")) if better else now)
    found = search._risen(SimpleTrial(()), [])  # type: ignore[arg-type]
    course = [("grown", False, ()), ("trial", True, ("g1",)), ("grown", True, ("g1",))]
    if better:
        course.append(("grown", True, ("g1", "g3", "w")))
    assert seen == course
    assert found.names == (("g1", "g3", "w", "g4") if better else ("g1", "g3"))


@dataclasses.dataclass
class SimpleTrial:
    names: tuple[str, ...]
    values: Any = dataclasses.field(default_factory=dict)
    chi2: float = 0.0


# --- the course of a diagnosis


class Diagnosing:
    """Every part of `diagnose`, given. trials: names and chi^2 of the ladder, from nothing on; 100 samples."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, trials: Any, *, excused: bool = False, misfit: bool = False,
                 removed: Any = (), given: Any = (), judged: bool = False, hidden: Any = ()) -> None:  # fmt: skip
        self.ticks: list[str] = []
        self.logs: list[Any] = []
        self.settled: list[Any] = []
        made = [SimpleTrial(names, {}, chi2) for names, chi2 in trials]
        self.final, self.beside = made[-1], list[Any]()
        self.search: Any = SimpleNamespace(count=100, misfit=lambda trial: misfit)
        target: Any = SimpleNamespace(channels=("v",), excused=excused, settle=self.settled.append, count=100,
                                      independent=50.0, slides=lambda: (0.1, 0.2), slopes=0.0,
                                      noise=lambda: {"v": 0.1})  # fmt: skip
        names = self.final.names
        found = SearchResult(self.final, dict.fromkeys(names, ("near",)), hidden)  # type: ignore[arg-type]
        steps = [Step("", level, {}, {}) for level in given]

        def experiments(logs: Any, model: Any, extra: Any) -> Any:
            self.logs.append(list(logs))
            return target

        def told(search: Any, trial: Any, judges: Any, added: str) -> Step:
            return Step(added, trial.chi2 / 100.0, {}, {})

        for name, value in {
            "experiment_set": experiments, "with_seen_gearbox": lambda candidates, target: candidates,
            "searched": lambda space, model: (self.search, found, dict.fromkeys(removed, 1.0), ("other",)),
            "folds": lambda *asked: (),
            "judged": lambda search, found, judges, apart: (found, ("out",), {"mass": 0.7}, (), False),
            "_misfit": lambda judges: judged,
            "with_sensors_asked": lambda search, final, judges: Tied(final, ()),
            "rivals_of": lambda search, judges, found: dict.fromkeys(names, ("near", "far")),
            "_measured": lambda search, final, model: (final, {}),
            "with_rival_values": lambda search, final, sure, rivals: self.beside.append(rivals) or sure,
            "_ladder": lambda search, final, told: made, "_given": lambda search, gone, judges: steps, "step": told,
            "_estimates": lambda trial, sure, name: {}, "lost_held_out": lambda *asked: 0.5,
            "Dependences": lambda *asked: SimpleNamespace(of=lambda name: None), "opinions": lambda *asked: {},
            "is_beyond_remainder": lambda *asked: True,
            "as_told": lambda search, trial: trial, "implausible_scales": lambda *asked: [],
            "with_standing": lambda named, *more: tuple(named), "diagnose_perceptions": lambda *asked: (),
            "signature": lambda *asked: {"reading": "r"}, "votes": lambda *asked: {},
        }.items():  # fmt: skip
            monkeypatch.setattr(diagnose_module, name, value)

    def run(self, model: Any = MODEL, **more: Any) -> Any:
        return diagnose_module.diagnose({"a": None}, model, tick=self.ticks.append, **more)  # type: ignore[dict-item]


LADDER = [((), 500.0), (("mass",), 200.0), (("mass", "steer_ratio"), 100.0)]


def test_each_effect_gains_its_share_of_what_is_beyond_the_noise(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 400 beyond the noise 300 and 100."""
    course = Diagnosing(monkeypatch, LADDER)
    found = course.run(MODEL.with_effect("steer_ratio", {"g": 1.1}))
    assert course.beside == [{"mass": ("near",), "steer_ratio": ("near",)}]  # an interval holds beside any of them
    assert [(e.name, e.action, e.gain, e.rivals, e.held_out_gain) for e in found.effects] == [
        ("mass", "add", 0.75, ("near",), 0.7), ("steer_ratio", "change", 0.25, ("near",), None),
    ]  # fmt: skip
    assert [step.added for step in found.ladder] == ["", "mass", "steer_ratio"]
    assert (found.verdict, found.vetoed, found.noise_floor, found.signature) == (
        "AMBIGUOUS", ("out",), {"v": 0.1}, {},
    )  # fmt: skip
    assert (found.samples.count, found.samples.independent, found.samples.slides, found.samples.left_out) == (
        100, 50.0, 0.1, 0.2,
    )  # fmt: skip
    assert course.ticks == ["preparing", "held-out data", "ladder", "standing"]
    assert course.settled == []


def test_of_what_is_not_named_the_answer_says_how_much_may_hide(monkeypatch: pytest.MonkeyPatch) -> None:
    shape = RemainderShape(imitates={"mass": {"ratio": 0.1}, "brake_gain": {"g": 0.02}})
    found = Diagnosing(monkeypatch, LADDER).run(dataclasses.replace(MODEL, remainder_shape=shape))
    assert [(one.effect, one.size) for one in found.may_hide] == [("brake_gain", pytest.approx(0.086))]


def test_a_share_is_within_nothing_and_all(monkeypatch: pytest.MonkeyPatch) -> None:
    found = Diagnosing(monkeypatch, [((), 300.0), (("mass",), 50.0), (("mass", "steer_ratio"), 60.0)]).run()
    assert [e.gain for e in found.effects] == [1.0, 0.0]
    little = Diagnosing(monkeypatch, [((), 90.0), (("mass",), 80.0)]).run()
    assert [e.gain for e in little.effects] == [1.0]  # of no excess it is all


@pytest.mark.parametrize(
    ("excused", "misfit", "asked"), [(False, False, False), (True, False, True), (False, True, True)]
)
def test_rivals_over_segments_are_asked_for_where_more_than_noise_is_left(
    excused: bool, misfit: bool, asked: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    course = Diagnosing(monkeypatch, LADDER, excused=excused, misfit=misfit)
    found = course.run()
    assert found.effects[0].rivals == (("near", "far") if asked else ("near",))
    assert ("rivals over segments" in course.ticks) is asked
    assert len(course.settled) == asked
    assert found.verdict == ("PARTIAL" if misfit else "AMBIGUOUS")
    assert bool(found.signature) is misfit


def test_what_the_car_lacks_gains_what_its_own_step_takes_away(monkeypatch: pytest.MonkeyPatch) -> None:
    """From 6 to 5 to 3 of chi^2/N, of the 5 beyond the noise: 1/5 and 2/5; the effect after them 2/5."""
    removed = (("drive_gain", "g"), ("brake_gain", "g"))
    course = Diagnosing(monkeypatch, [((), 300.0), (("mass",), 100.0)], removed=removed, given=(6.0, 5.0))
    found = course.run()
    gains = {e.name: (e.action, round(e.gain, 9)) for e in found.effects}
    assert gains == {"mass": ("add", 0.4), "drive_gain": ("remove", 0.2), "brake_gain": ("remove", 0.4)}
    assert [step.added for step in found.ladder] == ["", "", "brake_gain", "mass"]
    assert all(e.rivals == ("other",) for e in found.effects if e.action == "remove")


@pytest.mark.parametrize(
    ("excused", "misfit", "judged", "names", "held", "again"),
    [
        (True, False, True, (), True, True),
        (False, False, True, (), True, False),
        (True, True, True, (), True, False),
        (True, False, False, (), True, False),
        (True, False, True, ("mass",), True, False),
        (True, False, True, (), False, False),
    ],
)
def test_what_only_held_out_data_show_is_looked_for_in_all_logs_together(
    excused: bool, misfit: bool, judged: bool, names: Any, held: bool, again: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    trials = [((), 100.0), (names, 90.0)] if names else [((), 100.0)]
    course = Diagnosing(monkeypatch, trials, excused=excused, misfit=misfit, judged=judged)
    course.run(held_out={"b": None} if held else None)
    assert course.logs == ([["a"], ["a", "b"]] if again else [["a"]])
    assert ("only the held-out data show an error: all logs together" in course.ticks) is again


def test_what_would_not_have_shown_is_told_unless_the_model_stands(monkeypatch: pytest.MonkeyPatch) -> None:
    course = Diagnosing(monkeypatch, LADDER[:2], hidden=("aero_drag", "mass"))
    assert course.run().not_excited == ("aero_drag",)  # what was found was shown
    model: Any = dataclasses.replace(MODEL, inputs=dataclasses.replace(MODEL.inputs, longitudinal=("speed_cmd",)))
    assert model.drives_nothing
    assert course.run(model).not_excited == ()
    many = Diagnosing(monkeypatch, LADDER[:1], hidden=tuple(f"e{k}" for k in range(200)))
    assert many.run().verdict == "NOT_EXCITED"
    assert np.isclose(Diagnosing(monkeypatch, LADDER[:1]).run().ladder[0].chi2_per_n, 5.0)
