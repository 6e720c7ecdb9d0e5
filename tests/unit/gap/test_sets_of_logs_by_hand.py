"""Several logs judged together, pairs of effects that hide each other, and the course of a search around removals."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.gap.diagnose import removal as removal_module
from pytest_dvp.gap.diagnose.diagnosis import Estimate, NamedEffect, Step
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, _without_jumps
from pytest_dvp.gap.diagnose.masked_pairs import promising, tied_pairs
from pytest_dvp.gap.diagnose.removal import SearchSpace
from pytest_dvp.gap.diagnose.search import Search, SearchResult
from pytest_dvp.gap.discover.noise_left import settle
from pytest_dvp.gap.extend.extension import Extension, Rung
from tests.unit.gap.linear_world import World, a_search, a_trial, direction

NAN = math.nan
V, AX, STEER = (CHANNELS.index(name) for name in ("v", "ax", "steer"))

# --- several logs


class One:
    """A log of some rows of 0.1 s whose residuals are `rest` in v and twice that in ax, in units of 0.5 and of 2.0."""

    def __init__(self, rest: Any, starts: Any, *, channels: Any = ("v", "ax"), step: float = 0.1, remainder: Any = None,
                 slides: Any = (), abandoned: Any = ()) -> None:  # fmt: skip
        n = len(rest)
        self.rest = np.full((n, 8), NAN)
        self.rest[:, V] = rest
        if "ax" in channels:
            self.rest[:, AX] = 2.0 * np.array(rest)
        self.channels, self.count, self.independent = channels, int(np.isfinite(self.rest).sum()), 0.5 * n
        self.edges = np.append(starts, n) * 8
        self.log: Any = SimpleNamespace(t=step * np.arange(n))
        self.model: Any = SimpleNamespace(remainder=remainder or {})
        rows = np.arange(n)
        self.segments: Any = SimpleNamespace(slides=np.isin(rows, slides), abandoned=np.isin(rows, abandoned))
        self.noise = np.full(8, np.inf)
        self.noise[[V, AX]] = 0.5, 2.0
        self.settled: list[Any] = []

    def residuals(self, values: Any) -> Any:
        return SimpleNamespace(values=self.rest, count=np.isfinite(self.rest).sum(axis=0))

    def exact(self, values: Any) -> Any:
        return self.rest + 1.0

    def white(self, rest: Any) -> Any:
        return np.nan_to_num(rest / np.where(np.isfinite(self.noise), self.noise, 1.0)).ravel()

    def freed(self, rest: Any) -> Any:
        return 10.0 * self.white(rest)

    def settle(self, values: Any) -> None:
        self.settled.append(values)


def together(*logs: One, lasts: bool = False) -> ExperimentSet:
    return ExperimentSet(logs, lasts)  # type: ignore[arg-type]


A = One([1.0, 1.0, NAN, 3.0], [0, 2], step=0.2, slides=(1, 2), abandoned=(1,))
B = One([2.0, 2.0], [0], channels=("v",))
C = One([1.0, 0.0, 0.0], [0, 1], step=0.1)


def test_samples_add_up_and_the_longest_of_the_usual_steps_counts() -> None:
    found = together(A, B, C)
    assert (found.count, found.independent) == (6 + 2 + 6, 4.5)
    assert found.sample == pytest.approx(0.2)
    assert found.channels == ("v", "ax")
    assert together(B).channels == ("v",)
    assert found.slides() == pytest.approx((2.0 / 9.0, 1.0 / 9.0))


def test_a_set_is_excused_if_one_of_its_models_has_a_remainder() -> None:
    assert not together(A, B).excused
    assert together(A, One([1.0], [0], remainder={"v": {"cruise": 0.1}})).excused


def test_segments_of_several_logs_stand_one_after_the_other() -> None:
    """Rows of eight channels: segments of A at rows 0 and 2, of B at row 4, of C at rows 6 and 7."""
    found = together(A, B, C)
    assert found.starts().tolist() == [0, 16, 32, 48, 56]
    squares = found.by_segment(found.whitened({}))
    # v over 0.5 and ax over 2: rest^2 (4 + 1) each
    assert squares == pytest.approx([10.0, 45.0, 4.0 * 8.0, 5.0, 0.0])
    assert len(found.whitened({})) == 72
    assert (together(B).whitened({}) == B.white(B.rest)).all()


def test_an_error_that_lasts_is_judged_by_what_could_not_be_foreseen_of_it() -> None:
    plain, lasting = together(A, B), together(A, B).lasting()
    assert (plain.lasts, lasting.lasts) == (False, True)
    assert lasting.whitened({}) == pytest.approx(10.0 * plain.whitened({}))
    assert lasting.by_channel({})["v"] == pytest.approx(100.0 * plain.by_channel({})["v"])
    assert plain.exact({})[V] == pytest.approx((1.0 + 1.0) / 0.5)
    assert lasting.exact({})[V] == pytest.approx(40.0)


def test_each_channel_is_judged_over_all_logs_that_have_it() -> None:
    found = together(A, B, C)
    assert found.by_channel({}) == {"v": pytest.approx(4.0 * 20.0 / 8.0), "ax": pytest.approx(12.0 / 6.0)}
    assert found.rmse({}) == {"v": pytest.approx(math.sqrt(20.0 / 8.0)), "ax": pytest.approx(math.sqrt(48.0 / 6.0))}
    nothing = together(One([NAN, NAN], [0]))
    assert nothing.by_channel({}) == nothing.rmse({}) == {}


def test_the_noise_of_several_logs_is_their_root_mean_square() -> None:
    other = One([1.0], [0], channels=("v",))
    other.noise[V] = 1.5
    assert together(A, other).noise() == {"v": pytest.approx(math.sqrt((0.25 + 2.25) / 2.0)), "ax": 2.0}
    together(A, other).settle({"k": 1})  # type: ignore[dict-item]
    assert A.settled == other.settled == [{"k": 1}]


@pytest.mark.parametrize(("jump", "gone"), [(0.5, False), (0.501, True), (-0.501, True)])
def test_where_a_command_jumps_by_more_than_five_deviations_there_is_no_acceleration(jump: float, gone: bool) -> None:
    measured = np.ones((4, 8))
    found = _without_jumps(measured, np.array([1.0, 1.0, 1.0 + jump, 1.0 + jump]), 0.1)
    assert np.flatnonzero(np.isnan(found[:, AX])).tolist() == ([2] if gone else [])
    assert np.isfinite(np.delete(found, AX, axis=1)).all()
    assert np.isfinite(measured).all()
    assert _without_jumps(measured, None, 0.1) is measured
    assert _without_jumps(measured, np.zeros(4), math.inf) is measured


@pytest.mark.parametrize(("after", "kept"), [(4.0, True), (5.0, True), (5.1, False)])
def test_segments_begin_anew_where_that_leaves_no_more(after: float, kept: bool) -> None:
    class Begun:
        segments = "given"

        def whitened(self, values: Any) -> Any:
            return np.array([math.sqrt(5.0 if self.segments == "given" else after)])

        def settle(self, values: Any) -> None:
            self.segments = "settled"

    one: Any = Begun()
    if after == 5.0:
        one.whitened = lambda values: np.array([2.0])
    settle(SimpleNamespace(experiments=[one]), {})  # type: ignore[arg-type]
    assert one.segments == ("settled" if kept else "given")


# --- pairs that hide each other


def candidate(name: str, *sizes: float, tyres: bool = True, detail: bool = False, ties: Any = ()) -> Any:
    """An effect of one value; a weaker point is a share of it."""
    return SimpleNamespace(
        name=name, coarse=[{(name, "k"): size} for size in sizes], detail=detail,
        effect=SimpleNamespace(tyres=tyres, ties=ties),
        weaker=lambda point, share: [{key: share * value for key, value in point.items()}],
    )  # fmt: skip


REST = np.array([0.0, 4.0, 2.0, 5.0])  # the first direction is taken up by what is fitted


def pairs(a: Any, b: Any, does_a: Any, does_b: Any, jacobian: Any = ((1.0, 0.0, 0.0, 0.0),)) -> Any:
    def whitened(values: Any) -> Any:
        found = REST.copy()
        for name, does in ((a.name, does_a), (b.name, does_b)):
            found += values.get((name, "k"), 0.0) * np.array(does)
        return found

    now: Any = SimpleNamespace(values={}, fit=SimpleNamespace(residual=REST, jacobian=np.array(jacobian)))
    return promising(SimpleNamespace(whitened=whitened), now, [(a, b)])  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("does_a", "does_b", "left", "values"),
    [
        # each takes its own direction: 16 + 4 + 25 less 16 and 4
        ((7.0, -8.0, 0.0, 0.0), (0.0, 0.0, -4.0, 0.0), 25.0, (0.5, 0.5)),
        ((0.0, -4.0, 0.0, 0.0), (0.0, 0.0, -2.0, 0.0), 25.0, (1.0, 1.0)),
        ((0.0, -3.2, 0.0, 0.0), (0.0, 0.0, -4.0, 0.0), 25.0, (1.0, 0.5)),  # 1.25 of it, but no more than all is taken
        ((0.0, -3.1, 0.0, 0.0), (0.0, 0.0, -4.0, 0.0), None, None),
        ((0.0, -8.0, 0.0, 0.0), (0.0, 0.0, -1.5, 0.0), None, None),
        ((0.0, 8.0, 0.0, 0.0), (0.0, 0.0, -4.0, 0.0), None, None),  # of the wrong sign
        ((0.0, -8.0, 0.0, 0.0), (0.0, 0.0, 4.0, 0.0), None, None),
        ((0.0, -8.0, 0.0, 0.0), (3.0, -8.0, 0.0, 0.0), None, None),  # both do the same beside what is fitted
        ((7.0, 0.0, 0.0, 0.0), (0.0, 0.0, -4.0, 0.0), None, None),
        # opposite and alike: 8 (-1, 1) and 8 (1, 1/2) of the second and third: shares by Cramer's rule
        ((0.0, -8.0, 8.0, 0.0), (0.0, -8.0, -16.0, 0.0), 25.0, (0.25, 0.25)),
    ],
)
def test_a_pair_takes_what_both_can_do_together_to_first_order(
    does_a: Any, does_b: Any, left: float | None, values: Any
) -> None:
    found = pairs(candidate("a", 1.0), candidate("b", 1.0), does_a, does_b)
    if left is None:
        assert found == []
    else:
        ((chi2, names, point),) = found
        assert (chi2, names) == (pytest.approx(left), ("a", "b"))
        assert (point["a", "k"], point["b", "k"]) == pytest.approx(values)


def test_of_several_points_the_best_pair_counts() -> None:
    found = pairs(candidate("a", 1.0, 0.5), candidate("b", -1.0, 1.0), (0.0, -8.0, 0.0, 0.0), (0.0, 0.0, -4.0, 1.0))
    ((chi2, _, point),) = found
    assert point["a", "k"] == pytest.approx(0.5)
    assert chi2 == pytest.approx(29.0 - 9.0 / 17.0)  # (4 x 2 - 5)^2 over 4^2 + 1
    assert point["b", "k"] == pytest.approx(3.0 / 17.0)


def test_pairs_are_of_tyres_alike_and_one_of_them_is_a_detail() -> None:
    known = {c.name: c for c in (
        candidate("a", ties=("b", "c", "d")), candidate("b", detail=True), candidate("c"),
        candidate("d", detail=True, tyres=False), candidate("e", detail=True, ties=("c",)),
    )}  # fmt: skip
    assert [(a.name, b.name) for a, b in tied_pairs(known, ())] == [("a", "b"), ("c", "e")]
    assert [(a.name, b.name) for a, b in tied_pairs(known, ("a",))] == [("c", "e")]


# --- a search around what is removed


@pytest.mark.parametrize(
    ("excused", "names", "hidden", "final"),
    [
        (True, (), "quiet", ("quiet", "refined")),
        (True, (), None, ("refined",)),
        (False, (), "quiet", ("refined",)),
        (True, ("mass",), "quiet", ("mass", "quiet", "refined")),
    ],
)
def test_where_a_remainder_hides_all_a_quiet_effect_is_asked_for_and_what_changes_comes_last(
    excused: bool, names: Any, hidden: Any, final: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    world = World({}, excused=excused)
    first = SearchResult(a_trial(1000.0, *names), {"mass": ("x",)}, ("y",))
    monkeypatch.setattr(Search, "run", lambda self: first)
    monkeypatch.setattr(removal_module, "quiet", lambda search, trial, judges: hidden and dataclasses.replace(
        trial, names=(*trial.names, hidden)))  # fmt: skip

    def refined(search: Any, trial: Any, rivals: Any) -> Any:
        rivals["mass"] = (*rivals["mass"], "refiner")
        return dataclasses.replace(trial, names=(*trial.names, "refined"))

    monkeypatch.setattr(removal_module, "refined", refined)
    space = SearchSpace(world, (), (), (), {("inputs", "k"): 1.0}, lambda text: None)  # type: ignore[arg-type]
    search, found = space.run({("mass", "ratio"): 1.0})
    assert found.final.names == final
    assert (found.rivals, found.not_excited) == ({"mass": ("x", "refiner")}, ("y",))
    assert first.rivals == {"mass": ("x",)}
    assert (search.fixed, search.start) == ({("mass", "ratio"): 1.0}, {("inputs", "k"): 1.0})


@pytest.mark.parametrize(
    ("left", "first", "excused", "worth"),
    [(0.5, False, False, 0.05), (1.0, False, False, 0.05), (2.0, False, False, 0.1), (2.5, False, False, 0.075),
     (2.5, False, True, 0.125), (0.5, True, False, 0.03), (4.0, True, True, 0.12)],
)  # fmt: skip
def test_what_a_step_must_gain_is_a_share_of_what_it_leaves(
    left: float, first: bool, excused: bool, worth: float
) -> None:
    """3 % for the first one and where more is left than twice the noise, unless a remainder explains that; else 5."""
    search = a_search(World({}, excused=excused))
    assert search.least_gain(left, first=first) == pytest.approx(worth)


@pytest.mark.parametrize(
    ("effects", "left", "was", "matched"),
    [(6, 2999.0, 200_000.0, True), (6, 3000.0, 200_000.0, False), (5, 2000.0, 200_000.0, False),
     (6, 1900.0, 100_000.0, True), (6, 2000.0, 100_000.0, False)],
)  # fmt: skip
def test_many_effects_that_explain_nearly_all_need_no_other_beginning(
    effects: int, left: float, was: float, matched: bool
) -> None:
    """Of 1,000 samples: three times the noise beyond it, and 2 % of what was beyond it at first."""
    search = a_search(World({}))
    names = ("drive_gain", "brake_gain", "mass", "steer_ratio", "steer_offset", "gyro_bias")[:effects]
    assert search._is_matched(a_trial(1000.0 + was), a_trial(1000.0 + left, *names)) is matched


def test_what_may_take_a_place_came_near_or_is_often_confused_with_it() -> None:
    search = a_search(World({}), "drive_gain", "mass", "brake_gain", "rolling_resistance", refiners=("brake_fade",))
    assert search._contestants("drive_gain")[:4] == ["drive_gain", "mass", "brake_gain", "rolling_resistance"]
    search._near = {"drive_gain": ("rolling_resistance", "brake_fade")}
    found = search._contestants("drive_gain")
    assert found[0] == "rolling_resistance"
    assert "brake_fade" not in found  # not tried
    ties = set(search.known["drive_gain"].effect.ties)
    said = {name for name, c in search.tried.items() if "drive_gain" in c.effect.ties}
    assert set(found[1:]) == ((ties | said) & set(search.tried)) - {"rolling_resistance"}


def test_sets_without_one_are_remembered_while_the_set_is_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    search = a_search(World({("drive_gain", "g"): direction(0)}), "drive_gain", "mass")
    best, other = a_trial(1000.0, "drive_gain", "mass"), a_trial(1000.0, "drive_gain", "mass")
    fitted: list[tuple[str, float]] = []

    def without(self: Any, best: Any, name: str, above: float = math.inf) -> Any:
        fitted.append((name, above))
        return a_trial(1250.0 if name == "mass" else 1251.0)

    monkeypatch.setattr(Search, "_fitted_without", without)
    assert search._roughly_without(best, "mass").chi2 == 1250.0
    assert search._roughly_without(best, "drive_gain").chi2 == 1251.0
    assert fitted == [("mass", 1250.0), ("drive_gain", 1250.0)]  # five times 5 % of 1,000
    search.without(best, "mass")  # as good as that it need not be fitted again
    assert len(fitted) == 2
    search.without(best, "drive_gain")
    search.without(best, "drive_gain")
    assert fitted[2:] == [("drive_gain", math.inf)]
    search.without(other, "mass")
    assert fitted[3:] == [("mass", math.inf)]


# --- an extension as data


def test_an_extension_tells_the_errors_before_and_after_on_both_data() -> None:
    steps = [Step(f"s{k}", 10.0 + k, {"v": 1.0}, {"v": 0.5 + k}, 20.0 + k, {"v": 1.5 + k}) for k in range(3)]
    effect = NamedEffect("mass", {"ratio": Estimate(1.1, 1.0, 1.2, "-")})
    model: Any = None
    found = Extension(
        model, (effect,), {("drive_gain", "g"): Estimate(0.9, 0.8, 1.0, "-")},
        tuple(Rung(f"c{k}", step) for k, step in enumerate(steps)), {"v": 0.1}, "why", ("n",), explained=True,
    ).as_dict()  # fmt: skip
    assert found["error"] == {
        "fit": {"before": {"v": 0.5}, "after": {"v": 2.5}}, "held_out": {"before": {"v": 1.5}, "after": {"v": 3.5}},
    }  # fmt: skip
    assert found["chi2_per_n"] == {
        "fit": {"before": 10.0, "after": 12.0}, "held_out": {"before": 20.0, "after": 22.0},
    }  # fmt: skip
    assert found["refitted"] == {"drive_gain.g": {"value": 0.9, "low": 0.8, "high": 1.0, "unit": "-"}}
    assert [rung["change"] for rung in found["ladder"]] == ["c0", "c1", "c2"]
    assert (found["noise_floor"], found["explained"], found["refusal"], found["notes"]) == (
        {"v": 0.1}, True, "why", ["n"],
    )  # fmt: skip
    assert [one["name"] for one in found["effects"]] == ["mass"]
