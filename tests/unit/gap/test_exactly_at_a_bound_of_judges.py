"""What holds exactly at a bound of those who judge what a search has found, and of its looks at single effects.

All numbers are such that a bound is met without rounding.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.gap.diagnose import held_out, residual_signature, run_setup
from pytest_dvp.gap.diagnose.beyond_remainder import is_evident, is_imitated
from pytest_dvp.gap.diagnose.candidates import is_certain, is_worth_naming
from pytest_dvp.gap.diagnose.first_order_gain import FirstOrderGain
from pytest_dvp.gap.diagnose.held_out import Fold, fold_excites, folds
from pytest_dvp.gap.diagnose.least_squares import Coordinate, Fit, widen_dead_times
from pytest_dvp.gap.diagnose.masked_pairs import promising
from pytest_dvp.gap.diagnose.run_setup import split_setup
from pytest_dvp.gap.diagnose.search import Search
from pytest_dvp.gap.diagnose.standing import REMAINDER_ONLY, _held_out, _Left, _nothing_sure
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.gap.diagnose.veto import allowed_loss
from pytest_dvp.logs.log import Log
from tests.unit.gap.linear_world import BRAKE, DRIVE, MODEL, SEGMENTS, World, a_search, a_trial
from vehicle.model.effect import Key
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.remainder_shape import RemainderShape

EVEN = np.full(SEGMENTS, 20.0)


def a_plain_search(*names: str, **channels: float) -> Search:
    return a_search(World({}, channels=channels or {"v": 1.0}), *names)


# --- how firm a name is


class Leaving:
    """A search that leaves given squares by channel, with all effects and without one."""

    def __init__(self, whole: dict[str, float], less: dict[str, float], count: int) -> None:
        one = SimpleNamespace(residuals=lambda values: SimpleNamespace(count=np.full(8, count)))
        known = dict.fromkeys(CHANNELS, 1.0)
        self.target: Any = SimpleNamespace(excused=False, experiments=[one], anew=lambda: known)
        self.final, self._less = (
            SimpleNamespace(values={}, fit=SimpleNamespace(residual=np.array([given.get(c, 0.0) for c in CHANNELS])))
            for given in (whole, less)
        )

    def without(self, final: Any, name: str) -> Any:
        return self._less


@pytest.mark.parametrize(
    ("whole", "less", "count", "told"),
    [
        ({"v": 4.0}, {"v": 14.0}, 7, ""),  # 180 are 20 times the 9 that 16 are above 7
        ({"v": 4.0}, {"v": 13.9}, 7, "v"),
        ({"v": 12.0}, {"v": 13.0}, 96, ""),  # 144 are one and a half times 96
        ({"v": 12.0}, {"v": 13.0}, 95, "v"),
        ({"v": 4.0}, {"v": 5.0, "yaw": 9.0}, 7, "v"),  # 9 of 90 are a tenth: it acts on it
        ({"v": 4.0}, {"v": 5.0, "yaw": 9.1}, 7, ""),
    ],
)
def test_what_is_left_over_in_a_channel_is_a_doubt_beyond_each_of_three_bounds(
    whole: dict[str, float], less: dict[str, float], count: int, told: str
) -> None:
    search = Leaving(whole, less, count)
    found = _Left(search, search.final).doubts("x")  # type: ignore[arg-type]
    assert found == ([f"much is left over in {told}, on which it acts"] if told else [])


class Without(Search):
    """A search that knows what is left without an effect."""

    less: Trial

    def without(self, best: Trial, name: str) -> Trial:
        return self.less


@pytest.mark.parametrize(
    ("gain", "excused", "told"),
    [(0.2, True, 0), (0.001, False, 1), (-0.001, False, 1), (0.00101, False, 0), (-0.00101, False, 1)],
)
def test_a_gain_on_data_held_out_that_is_just_rounding_says_nothing(gain: float, excused: bool, told: int) -> None:
    search = Without(World({}, excused=excused), ())  # type: ignore[arg-type]
    search.less = a_trial(1000.0, segments=EVEN)  # no draw of segments gains
    found = _held_out(search, a_trial(1000.0, "mass", segments=EVEN), "mass", {"mass": gain}, ())
    assert len(found) == told
    assert REMAINDER_ONLY not in found


@pytest.mark.parametrize(
    ("low", "high", "imitated"), [(1.0, 1.2, True), (0.8, 1.0, True), (1.001, 1.2, False), (0.8, 0.999, False)]
)
def test_an_interval_that_ends_at_what_the_twin_has_is_not_clear_of_it(low: float, high: float, imitated: bool) -> None:
    estimate = SimpleNamespace(value=1.05, low=low, high=high)
    named: Any = SimpleNamespace(name="drive_gain", parameters={"g": estimate})
    assert bool(_nothing_sure(named, find_effect("drive_gain"), {}, True)) is imitated
    assert bool(_nothing_sure(named, find_effect("drive_gain"), {}, False)) is imitated
    assert bool(_nothing_sure(named, find_effect("drive_gain"), {"g": 1.1}, True)) is (low <= 1.1 <= high)


@pytest.mark.parametrize(("value", "worth"), [(0.5, True), (0.4999, False), (-0.5, True), (-0.4999, False)])
def test_a_value_that_is_just_the_least_is_worth_naming(value: float, worth: bool) -> None:
    assert is_worth_naming(Key("k", "-", -2.0, 2.0, 0.0, 0.5), value) is worth


def test_three_standard_deviations_from_nothing_are_not_more_than_that() -> None:
    """1.2 half widths of 1."""
    c = Coordinate("effect", Key("k", "-", -2.0, 2.0, 0.0, 0.5))
    assert not is_certain(c, 1.2, (0.2, 2.2))
    assert is_certain(c, 1.2000001, (0.2, 2.2))
    limit = Coordinate("effect", Key("k", "-", 0.0, 1.0, np.inf, 0.5))
    assert not is_certain(limit, 0.2, (0.0, 0.33))
    assert is_certain(limit, 0.2, (0.0, 0.3299))


# --- data held out


@pytest.mark.parametrize(("rows", "parted"), [((200, 200), True), ((199, 200), False), ((200, 199), False)])
def test_two_hundred_rows_on_either_side_are_enough(
    rows: tuple[int, int], parted: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The stamps up to 60 % of the time, and those after it; and the same of a run's own set-up, up to 30 %."""
    for module in (held_out, run_setup):
        monkeypatch.setattr(module, "experiment_set", lambda logs, model, extra: logs)

    def log(share: float) -> Log:
        before, after = rows
        first, second = np.linspace(0.0, 0.99 * share, before), np.linspace(share + 0.001, 1.0, after)
        return Log({"t": np.concatenate([first, second]), "v": np.ones(before + after)})

    assert len(folds({"a": log(0.6)}, None, MODEL)) == int(parted)
    assert len(split_setup({"a": log(0.3)}, MODEL)) == int(parted)


class Shown:
    """Data in which an effect makes a change of so many squares; what is left with it is `rest` squares."""

    def __init__(self, squares: int, count: int, rest: int = 0) -> None:
        self.squares, self.count, self.rest = squares, count, rest

    def whitened(self, values: Any) -> Any:
        off = values[DRIVE] == 1.0
        return np.concatenate([np.ones(self.squares) * off, np.ones(self.rest)])


@pytest.mark.parametrize(
    ("fitted", "judge", "shown"),
    [
        (Shown(5, 100), Shown(0, 100), False),  # 5 % of the samples
        (Shown(6, 100), Shown(0, 100), True),
        (Shown(10, 100, rest=200), Shown(0, 100), False),  # 5 % of what is left
        (Shown(11, 100, rest=200), Shown(0, 100), True),
        (Shown(30, 100), Shown(100, 100), False),  # 30 % of what it does there
        (Shown(31, 100), Shown(100, 100), True),
        (Shown(30, 100), Shown(198, 200), True),  # of as many samples
        (Shown(30, 100), Shown(200, 200), False),
    ],
)
def test_data_show_an_effect_by_more_than_five_percent_and_three_tenths_of_what_the_judges_see(
    fitted: Shown, judge: Shown, shown: bool
) -> None:
    trial = a_trial(0.0, "drive_gain", values={DRIVE: 0.9})
    fold = Fold(fitted, judge)  # type: ignore[arg-type]
    assert fold_excites(a_plain_search("drive_gain"), fold, trial, "drive_gain") is shown


@pytest.mark.parametrize(("level", "share"), [(2.0, 0.01), (2.0001, 0.2)])
def test_an_effect_may_lose_a_fifth_of_its_gain_only_where_more_than_twice_the_noise_is_left(
    level: float, share: float
) -> None:
    search = a_plain_search("drive_gain")
    assert allowed_loss(search, a_trial(0.0, "drive_gain"), "drive_gain", level, 3.0) == pytest.approx(3.0 * share)
    assert allowed_loss(search, a_trial(0.0, "drive_gain"), "drive_gain", level, 0.0) == pytest.approx(1e-3 * level)


# --- effects that hide each other, and quiet ones


class Pair:
    """One of two effects with a single point, which makes a given change; its name is its key."""

    def __init__(self, name: str) -> None:
        self.name, self.coarse = name, ({(name, "k"): 1.0},)

    def weaker(self, point: Any, share: float) -> list[Any]:
        return [{key: value * share for key, value in point.items()}]


def pair(u: Any, v: Any, rest: Any, jacobian: Any = None) -> Any:
    rows = {"a": np.asarray(u, dtype=float), "b": np.asarray(v, dtype=float)}
    left = np.asarray(rest, dtype=float)
    target: Any = SimpleNamespace(
        whitened=lambda values: left + sum((rows[name] for name, _ in values), np.zeros(len(left)))
    )
    fit = SimpleNamespace(residual=left, jacobian=np.zeros((0, len(left))) if jacobian is None else jacobian)
    now: Any = SimpleNamespace(values={}, fit=fit)
    return promising(target, now, [(Pair("a"), Pair("b"))])  # type: ignore[list-item]


@pytest.mark.parametrize(
    ("rest", "taken"),
    [((-5.0, -5.0), True), ((-5.1, -4.0), False), ((-4.0, -5.1), False), ((0.0, -4.0), False), ((-4.0, 0.0), False),
     ((-0.1, -0.1), True)],
)  # fmt: skip
def test_of_each_of_a_pair_some_and_at_most_five_quarters_of_a_point_are_asked_for(rest: Any, taken: bool) -> None:
    """Changes of 4 at right angles: a rest of -5 asks for 5/4 of one, of which the point itself is taken."""
    found = pair((4.0, 0.0), (0.0, 4.0), rest)
    assert bool(found) is taken
    if taken:
        ((left, names, point),) = found
        share = min(-rest[0] / 4.0, 1.0)
        assert names == ("a", "b")
        assert left == pytest.approx(0.0, abs=1e-12)  # to first order all of it
        assert point == pytest.approx({("a", "k"): share, ("b", "k"): share})


def test_a_pair_that_does_all_but_the_same_is_none() -> None:
    """Changes (1, 0) and (1, e): what stands beside is e^2/(1 + e^2), of which a thousandth is too little."""
    for beside, taken in ((0.0315, False), (0.0318, True)):
        assert bool(pair((1.0, 0.0), (1.0, beside), (-0.9, -0.5 * beside))) is taken


def test_what_the_others_can_do_counts_for_no_pair() -> None:
    """The third direction is that of a value that is fitted already: neither the rest nor the changes count in it."""
    found = pair((4.0, 0.0, 7.0), (0.0, 4.0, -2.0), (-2.0, -1.0, 9.0), np.array([[0.0, 0.0, 3.0]]))
    ((left, _, point),) = found
    assert left == pytest.approx(0.0, abs=1e-12)
    assert point == pytest.approx({("a", "k"): 0.5, ("b", "k"): 0.25})


def test_twenty_standard_deviations_are_not_more_than_that() -> None:
    world = World({DRIVE: 1.0 * np.append(np.ones(1), np.zeros(999))}, {DRIVE: 21.0}, noise=np.zeros(1000))
    search = a_search(world, "drive_gain")
    at = a_trial(0.0, "drive_gain", values={DRIVE: 21.0})
    assert not is_evident(search, at, "drive_gain", world)  # type: ignore[arg-type]
    world.hidden = {DRIVE: 21.5}
    further = a_trial(0.0, "drive_gain", values={DRIVE: 21.5})
    assert is_evident(search, further, "drive_gain", world)  # type: ignore[arg-type]


@pytest.mark.parametrize(("value", "imitated"), [(1.5, True), (1.501, False), (0.5, True), (0.499, False)])
def test_a_size_that_is_just_what_the_remainder_imitates_is_imitated(value: float, imitated: bool) -> None:
    world = World({})
    world.model.remainder_shape = RemainderShape(imitates={"drive_gain": {"g": 0.25}})
    search = a_search(world, "drive_gain", "brake_gain")
    trial = a_trial(0.0, "drive_gain", values={DRIVE: value, BRAKE: value})
    assert is_imitated(search, trial, "drive_gain", 2.0) is imitated
    assert not is_imitated(search, trial, "brake_gain", 2.0)


# --- to first order


def look(rest: Any, *rows: Any) -> tuple[FirstOrderGain, Any]:
    """A look at an effect whose value x changes the residual by x times a row."""
    left = np.asarray(rest, dtype=float)
    row = np.asarray(rows[0], dtype=float)
    target: Any = SimpleNamespace(count=10, whitened=lambda values: left + values.get(("e", "k"), 0.0) * row)
    now: Any = SimpleNamespace(values={}, fit=SimpleNamespace(residual=left, jacobian=np.zeros((0, len(left)))))
    c = Coordinate("e", Key("k", "-", 0.0, 1.0, 0.0, 0.1))
    candidate: Any = SimpleNamespace(
        own={}, coordinates=(c,), weaker=lambda point, share: [{key: value * share for key, value in point.items()}]
    )
    return FirstOrderGain(target, now), candidate


def test_an_effect_is_looked_at_once_if_it_promises_less_than_a_tenth_of_what_is_needed() -> None:
    """A rest of (1, 0) and a change of (-2, 0): as strong as it likes it takes away 1."""
    points: list[dict[tuple[str, str], float]] = [{("e", "k"): 1.0}, {("e", "k"): 0.5}]
    gain, candidate = look((1.0, 3.0), (-2.0, 0.0))
    once = gain.remaining_chi2(candidate, points, 10.1)
    assert once == [(pytest.approx(9.0), points[-1])]  # all of what it can take
    assert len(gain.remaining_chi2(candidate, points, 10.0)) > 1
    assert len(gain.remaining_chi2(candidate, points, 0.0)) > 1
    assert len(gain.remaining_chi2(candidate, points[:1], 10.1)) == 2  # a single point, and what promises most


@pytest.mark.parametrize("places", [(0.0, 1.2), (1.2, 0.0)])
def test_a_wrong_place_of_an_accelerometer_leaves_an_effect_its_hope(places: tuple[float, ...]) -> None:
    """1.2 m ahead of where it is, it changes the residual by 100; the effect itself would take away 9 of 10."""
    place = ("parameters", "ay_x")
    left = np.array([3.0, 1.0])

    def whitened(values: Any) -> Any:
        return left + np.array([-3.0 * values.get(("e", "k"), 0.0), 100.0 * (values.get(place, 0.0) > 0.0)])

    target: Any = SimpleNamespace(count=10, whitened=whitened)
    now: Any = SimpleNamespace(values={}, fit=SimpleNamespace(residual=left, jacobian=np.zeros((0, 2))))
    _, candidate = look((1.0, 3.0), (-2.0, 0.0))
    points = [{("e", "k"): k, place: at} for k in (1.0, 0.5) for at in places]
    found = FirstOrderGain(target, now).remaining_chi2(candidate, points, 8.0)
    assert min(chi2 for chi2, _ in found) == pytest.approx(1.0)
    nothing = FirstOrderGain(target, now).remaining_chi2(candidate, points, 100.0)
    assert [point for _, point in nothing] == points[2:]  # the weakest alone, at each place


def test_a_change_in_the_wrong_direction_or_too_small_is_not_made_weaker() -> None:
    points: list[dict[tuple[str, str], float]] = [{("e", "k"): 1.0}]
    for rest, row, more in (
        ((1.0, 3.0), (2.0, 0.0), False),  # adds to the rest
        ((4.0, 3.0), (-2.0, 0.0), False),  # more of it would be better
        ((2.0, 3.0), (-2.0, 0.0), False),  # it is just right
        ((1.0, 3.0), (-2.0, 0.0), True),
        ((0.0, 3.0), (-2.0, 0.0), False),  # it does nothing for it
    ):
        gain, candidate = look(rest, row)
        found = gain.remaining_chi2(candidate, points)
        assert len(found) == (2 if more else 1)
        assert found[0][0] == pytest.approx((rest[0] + row[0]) ** 2 + 9.0)
        if more:
            assert found[1] == (pytest.approx(9.0), {("e", "k"): pytest.approx(0.5)})


# --- what an unexplained error looks like


@pytest.mark.parametrize(
    ("given", "starts"),
    [
        ({"regressors": [{"key": "speed", "term": "v", "held_out_share": 0.15}]},
         "longitudinal error grows with speed"),
        ({"slip": 0.12}, "longitudinal error that no term"),
        ({"same_place": 0.5}, "longitudinal error that no term"),
        ({"axis": "lateral", "chi2_per_n": 1.5}, "lateral error that no term"),
        ({"slip": 0.3, "regressors": [{"key": "speed", "term": "v", "held_out_share": 0.5}]},
         "longitudinal error grows with speed"),
    ],
)  # fmt: skip
def test_an_error_that_lies_on_a_bound_is_read(given: dict[str, Any], starts: str) -> None:
    entry = {"axis": "longitudinal", "chi2_per_n": 9.0, "regressors": [], "same_place": None, "slip": 0.0,
             "speed": {"bin": "speed 5-10 m/s"}}  # fmt: skip
    assert residual_signature._read(entry | given, [])[0].startswith(starts)


def test_a_rhythm_of_a_fifth_is_not_read() -> None:
    entry = {"axis": "lateral", "chi2_per_n": 9.0, "regressors": [], "same_place": None, "slip": 0.0,
             "speed": {"bin": "speed 5-10 m/s"}}  # fmt: skip
    peak: Any = SimpleNamespace(kind="time", frequency=1.0, unit="Hz", share=0.2)
    assert "no term of the list" in residual_signature._read(entry, [peak])[0]


def test_a_term_that_explains_just_a_twentieth_is_told_and_is_no_alternative() -> None:
    terms: Any = [SimpleNamespace(key=k, name=k, columns=np.zeros((3, 1))) for k in "ab"]
    sums: Any = SimpleNamespace(
        held_out=lambda chosen: 0.05 if list(chosen) == [0] else 0.0,
        left=lambda share: 11.0 - 10.0 * share,
        fitted=lambda chosen: (0.05, np.zeros(1)),
    )
    assert residual_signature._selected(sums, terms)[0] == [0]
    assert residual_signature._others(sums, terms, []) == []


def test_an_alternative_to_the_first_term_may_be_one_that_was_chosen_later() -> None:
    terms: Any = [SimpleNamespace(key=k, name=k, columns=np.zeros((3, 1))) for k in "abc"]
    sums: Any = SimpleNamespace(held_out=lambda chosen: {0: 0.9, 1: 0.5, 2: 0.3}[chosen[0]])
    assert [one["term"] for one in residual_signature._others(sums, terms, [1, 0])] == ["a", "c"]


# --- dead times


def test_a_dead_time_behind_another_value_has_its_ends_looked_for() -> None:
    """Of (gain, dead time) the second one is widened as well: by a tenth of 20 ms, for any move is seen."""
    gain = Coordinate("effect", Key("g", "-", 0.0, 1.0, 0.0, 0.1))
    late = Coordinate("effect", Key("T", "s", 0.0, 1.0, 0.0, 0.1), dead_time=0.1)
    values = {gain.name: 0.5, late.name: 0.3}
    found = Fit((gain, late), values, np.zeros(1), 0.0, np.zeros((2, 1)))
    target: Any = SimpleNamespace(whitened=lambda given: np.array([1e9 * (given[late.name] - 0.3)]), sample=0.02)
    wide = widen_dead_times(target, found, values, {gain.name: (0.4, 0.6), late.name: (0.3, 0.3)})
    assert wide == {gain.name: (0.4, 0.6), late.name: pytest.approx((0.298, 0.302))}
