"""What holds exactly at a bound of signals, terms, remainders and parts of logs, on rows that meet it exactly."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.compare.compared_model import LogSubject
from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.gap.compare.smoothed_motion import Motion
from pytest_dvp.gap.diagnose import chance_gain as chance
from pytest_dvp.gap.diagnose import held_out_choice, known_remainder, regression_signals, wheelbase_check
from pytest_dvp.gap.diagnose import residual_terms as terms_module
from pytest_dvp.gap.diagnose.chance_gain import _surrogates, chance_gain
from pytest_dvp.gap.diagnose.diagnosis import Step
from pytest_dvp.gap.diagnose.error_shares import percents, shares
from pytest_dvp.gap.diagnose.held_out import Fold
from pytest_dvp.gap.diagnose.held_out_choice import chosen
from pytest_dvp.gap.diagnose.input_scales import implausible_scales
from pytest_dvp.gap.diagnose.known_remainder import Left, measured_remainder
from pytest_dvp.gap.diagnose.lasting_remainder import _fallen
from pytest_dvp.gap.diagnose.least_squares import Coordinate
from pytest_dvp.gap.diagnose.part_selection import exciting_parts
from pytest_dvp.gap.diagnose.regression_signals import rate_limited, signals, with_stiction
from pytest_dvp.gap.diagnose.residual_signature import _at_measured_speed, _error, _slip
from pytest_dvp.gap.diagnose.residual_terms import _passed, terms
from pytest_dvp.gap.diagnose.search import SearchResult
from pytest_dvp.gap.diagnose.tyre_regressors import on_tyres
from pytest_dvp.gap.diagnose.wheelbase_check import wrong_wheelbase
from pytest_dvp.logs.log import Log
from tests.unit.gap.linear_world import SettledSearch
from vehicle.model.command_inputs import Inputs
from vehicle.model.effect import Key

N = 400


def a_motion(n: int = N, **given: Any) -> Motion:
    t = 0.125 * np.arange(n)
    fields: dict[str, Any] = {
        "t": t, "step": 0.125, "x": 8.0 * t, "y": 0.0 * t, "yaw": 0.0 * t, "v": 8.0 + 0.0 * t,
        "yaw_rate": 0.25 + 0.0 * t,
        "accel": 0.0 * t, "steer": 0.0 * t, "moving": np.ones(n, dtype=bool), "way": 8.0 * t, "braked": t, "driven": t,
        "wheelbase": 2.5,
    }  # fmt: skip
    return Motion(**(fields | given))


# --- terms of an error


@pytest.mark.parametrize(("lowest", "again"), [(3.0, False), (2.9, True)])
def test_a_speed_is_passed_where_it_is_reached_and_once_more_below_three_quarters_of_it(
    lowest: float, again: bool
) -> None:
    m = a_motion(8, t=np.arange(8.0), step=1.0, v=np.array([3.0, 4.0, 5.0, lowest, 3.5, 4.0, 5.0, 5.0]))
    assert _passed(m, 4.0, 1.0).tolist() == [0.0, 1.0, 0.0, 0.0, 0.0, float(again), 0.0, 0.0]


def by_name(m: Motion) -> dict[str, Any]:
    return {term.name: term.columns for term in terms("longitudinal", [m], ())[0]}


def test_a_speed_that_nobody_exceeds_is_not_passed() -> None:
    names = by_name(a_motion(v=np.linspace(0.0, 5.0, N)))
    assert "the 0.5 s after passing 4 m/s" in names
    assert "the 0.5 s after passing 5 m/s" not in names


def test_pedals_are_released_below_a_twentieth_and_brakes_above_three_tenths() -> None:
    accel = np.array([0.05, 0.0499, -0.05, -0.0499, -0.3, -0.2999, 0.5, -3.0])
    names = by_name(a_motion(8, accel=accel, v=np.full(8, 1.0)))
    assert names["pedals released"][:, -1].tolist() == [0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]
    slow = 1.0 - 1.0 / 2.5
    free = [1.0, 1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.0]
    assert names["below 2.5 m/s without brake"][:, -1] == pytest.approx(slow * np.array(free))
    assert names["below 2.5 m/s"][:, -1] == pytest.approx(np.full(8, slow))
    assert terms_module.CREEPING == (1.5, 2.5, 4.0)


# --- the signature of an error


def rest(n: int = N, **channels: Any) -> Any:
    found = np.full((n, 8), np.nan)
    for name, values in channels.items():
        found[:, CHANNELS.index(name)] = values
    return found


def test_at_a_crawl_a_yaw_rate_says_nothing_of_an_angle_and_a_speed_something_of_a_yaw_rate() -> None:
    """A crawl is 2 m/s: at just that speed there is no angle, and a wrong speed turns the car."""
    m = a_motion(v=np.where(np.arange(N) < 50, 2.0, 8.0), yaw_rate=np.full(N, 0.25))
    e: Any = SimpleNamespace(channels=("yaw_rate",))
    angle = _error("lateral", e, rest(yaw_rate=0.5), m)
    assert angle[:50].tolist() == [0.0] * 50
    assert angle[50:] == pytest.approx(0.5 * 2.5 / 8.0)
    found = _at_measured_speed(rest(v=0.5, yaw_rate=0.5, yaw=0.0), m)
    assert found[:, 4] == pytest.approx(np.where(np.arange(N) < 50, 0.5 - 0.5 * 0.25 / 2.0, 0.5 - 0.5 * 0.25 / 8.0))


@pytest.mark.parametrize(("rows", "told"), [(50, False), (51, True)])
def test_a_slide_is_told_of_more_than_fifty_rows(rows: int, told: bool) -> None:
    """All of them go north and point east."""
    m = a_motion(rows, x=np.zeros(rows), y=np.arange(rows) * 1.0)
    assert _slip(m) == pytest.approx(0.5 * np.pi if told else 0.0)


# --- signals of the second opinion


@pytest.fixture
def a_log(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A function that gives the signals of a log of 50 Hz whose accelerometer is known in so many rows."""
    n, t = 600, 0.02 * np.arange(600)

    def of(known: int, speed: Any = 5.0) -> Any:
        v = np.broadcast_to(np.asarray(speed, dtype=float), n)
        m = a_motion(n, t=t, step=0.02, v=v, yaw=0.0 * t, yaw_rate=0.0 * t, accel=t, steer=-t)
        monkeypatch.setattr(regression_signals, "motion", lambda log, model: m)
        rng = np.random.default_rng(0)
        ax = np.where(np.arange(n) < known, rng.normal(size=n), np.nan)
        car = SimpleNamespace(cg_to_front_axle=1.25, yaw_inertia=1500.0, mass=1000.0)
        log = SimpleNamespace(t=t, columns=Log({"t": t, "v": v + 0.01 * rng.normal(size=n), "ax": ax}).columns)
        return signals(log, SimpleNamespace(car=car, inputs=Inputs()))  # type: ignore[arg-type]

    return of


@pytest.mark.parametrize(("known", "judged"), [(100, {"dv"}), (101, {"dv", "ax"})])
def test_a_channel_is_judged_with_more_than_a_hundred_rows(known: int, judged: set[str], a_log: Any) -> None:
    assert set(a_log(known).measured) == judged


def test_windows_are_a_fifth_of_a_second_and_do_not_overlap(a_log: Any) -> None:
    s = a_log(600)
    assert s.w == 5
    assert s.rows[0] >= 5
    assert set(np.diff(s.rows)) == {5}
    assert s.rows[-1] == 590  # the last one ends within the log
    assert (s.gyration, s.cg_front, s.wheelbase) == (1.5, 1.25, 2.5)
    assert s.accel == pytest.approx(s.t)
    assert s.steer == pytest.approx(-s.t)


@pytest.mark.parametrize(("top", "slowest"), [(20.0, 0.8), (4.0, 0.4)])
def test_no_equation_is_judged_near_standstill(top: float, slowest: float, a_log: Any) -> None:
    """0.8 m/s, or a tenth of what a small car usually drives; not within two windows of a row that is slower."""
    row = np.arange(600)
    for v, judged in ((0.99 * slowest, False), (1.01 * slowest, True)):
        s = a_log(600, np.where((row >= 300) & (row < 400), v, top))
        assert bool(np.isin(s.rows, np.arange(300, 400)).any()) is judged
        assert bool(np.isin(295, s.rows)) is judged
        assert 285 in s.rows
    exact = a_log(600, np.where((row >= 300) & (row < 400), 0.8, 20.0))
    assert not np.isin(exact.rows, np.arange(300, 400)).any()


def test_a_signal_that_is_limited_or_sticks_just_where_it_may() -> None:
    assert rate_limited(np.array([0.0, 1.0, 1.0, -3.0]), 1.0) == pytest.approx([0.0, 0.5, 1.0, 0.5])
    assert rate_limited(np.array([0.0, 0.5, 0.5]), 1.0) == pytest.approx([0.0, 0.375, 0.5])
    assert with_stiction(np.array([2.0, 2.75, 3.0, 2.0]), 1.0).tolist() == [2.0, 2.0, 3.0, 2.0]
    assert with_stiction(np.array([2.0, 1.5, 1.0, 1.5]), 1.0).tolist() == [2.0, 2.0, 1.0, 1.0]


def test_tyres_slip_from_one_metre_a_second_on() -> None:
    """Below it the car rolls, whatever its tyres are; at it very soft ones hardly turn it at once."""
    n = 40
    s: Any = SimpleNamespace(v=np.full(n, 1.0), steer=np.where(np.arange(n) < 5, 0.0, 0.2), step=0.02, wheelbase=2.5,
                             cg_front=1.25, gyration=1.5)  # fmt: skip
    soft = on_tyres(s, 50.0, 50.0)[0]
    assert soft[10] < 0.2 * math.tan(0.2) / 2.5
    s.v = np.full(n, 0.999)
    assert on_tyres(s, 50.0, 50.0)[0][5:] == pytest.approx(np.full(n - 5, 0.999 * math.tan(0.2) / 2.5))


# --- remainders


def left(rows: Any, noise: float) -> Left:
    values = rest(len(rows), v=rows)
    log: Any = SimpleNamespace(t=np.arange(len(rows)) * 0.02, columns={})
    return Left(log, values, values, np.full(8, noise), ("v",))


def test_a_tenth_of_the_noise_s_square_is_no_remainder(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 100 samples of unit noise, squares of 110 are one tenth more: 30 ones and 20 twos."""
    monkeypatch.setattr(known_remainder, "regimes_of", lambda log, measured: {"all": np.ones(len(measured), bool)})
    monkeypatch.setattr(known_remainder, "REGIMES", ("all",))
    rows = np.array([1.0] * 30 + [2.0] * 20 + [0.0] * 50)
    assert measured_remainder([[left(rows, 1.0)]]) == {}
    rows[-1] = 0.5
    assert measured_remainder([[left(rows, 1.0)]]) == {"v": {"all": 0.32}}  # of sqrt(10.25/100) three digits


def test_a_correlation_has_fallen_only_below_that_of_neighbours_over_e() -> None:
    """Of rows that are all alike it never falls, and of opposite neighbours there is none."""
    assert _fallen(np.ones(600), np.array([0])) == 250
    assert _fallen(np.where(np.arange(100) % 2 == 0, 1.0, -1.0), np.array([0])) == 0
    assert _fallen(np.array([1.0, 0.0, -1.0, 0.0] * 50), np.array([0])) == 0  # neighbours are unrelated
    assert _fallen(np.repeat([1.0, -1.0], 300), np.array([0, 300])) == 250  # each piece by itself


# --- parts of logs


def test_logs_of_just_the_most_rows_are_whole() -> None:
    log = Log({"t": 0.02 * np.arange(1500), "v": np.arange(1500) % 7.0, "a": np.sin(np.arange(1500))})
    (part,) = exciting_parts({"a": log}, ["a"], 1500)
    assert part.whole
    assert not any(part.whole for part in exciting_parts({"a": log}, ["a"], 1499))


# --- shares


def ladder(*levels: float) -> list[Step]:
    return [Step("" if k == 0 else f"e{k}", level, {}, {}, segments=(50.0 * level, 50.0 * level))
            for k, level in enumerate(levels)]  # fmt: skip


@pytest.mark.parametrize(("level", "told"), [(1.05, False), (1.0501, True)])
def test_a_share_means_something_beyond_a_twentieth_above_the_noise(level: float, told: bool) -> None:
    assert bool(shares(ladder(level, 1.0))) is told


def test_shares_are_of_what_is_above_the_noise() -> None:
    found = shares(ladder(3.0, 2.0, 0.5))
    assert (found["e1"].value, found["e2"].value) == pytest.approx((0.5, 0.5))  # less than the noise is no gain
    assert (found["e1"].shown, found["e2"].shown) == ("50 %", "50 %")
    assert found["e1"].low == found["e1"].high == pytest.approx(0.5)  # both segments say the same
    worse = shares(ladder(3.0, 4.0, 2.0))
    assert (worse["e1"].value, worse["e2"].value) == pytest.approx((-0.5, 1.0))


@pytest.mark.parametrize(
    ("given", "shown"),
    [([0.0095, 0.9905], ["1 %", "99 %"]), ([0.0094, 0.9906], ["0.9 %", "99.1 %"]), ([0.0, 1.0], ["0 %", "100 %"]),
     ([0.333, 0.333, 0.334], ["33 %", "33 %", "34 %"]), ([0.336, 0.332, 0.332], ["34 %", "33 %", "33 %"]),
     ([-0.005, 1.0], ["-0.5 %", "100.0 %"]), ([0.126, 0.126], ["13 %", "12 %"])],
)  # fmt: skip
def test_shares_add_up_and_none_is_lost(given: list[float], shown: list[str]) -> None:
    assert percents(given) == shown


# --- by chance


def test_a_piece_of_four_samples_has_surrogates_of_its_spectrum() -> None:
    for n, alike in ((3, True), (4, False)):
        r = np.arange(1.0, n + 1.0)
        found = _surrogates(r, [np.arange(n)], 50)
        if alike:
            assert not found.any()
        else:
            assert (found**2).sum(axis=1) == pytest.approx(np.full(50, float(r @ r)))
            assert np.abs(found.mean(axis=1)) == pytest.approx(np.full(50, 2.5))
            assert {bool(one.mean() > 0.0) for one in found} == {True, False}
            assert {bool(one @ [1.0, -1.0, 1.0, -1.0] > 0.0) for one in found} == {True, False}


def test_an_effect_by_chance_gains_what_the_best_of_all_does_in_five_of_a_hundred_draws(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Draws along one direction are known: the gain along it is their square, and what is fitted or present is none."""
    draws = np.zeros((20, 6))
    draws[:, 0] = np.arange(1.0, 21.0)
    monkeypatch.setattr(chance, "_surrogates", lambda r, pieces, count: draws.copy())
    monkeypatch.setattr(chance, "_pieces", lambda target: [])
    base = np.ones(6)
    does = {"a": np.eye(6)[0] * 3.0, "b": np.eye(6)[1], "tiny": np.eye(6)[0] * 1e-4}
    target: Any = SimpleNamespace(
        count=6, whitened=lambda values: base + sum((does[name] for name, _ in values), np.zeros(6))
    )
    tried: Any = [SimpleNamespace(name=name, coarse=[{(name, "k"): 1.0}]) for name in does]
    expected = float(np.quantile(draws[:, 0] ** 2, 0.95)) / 6.0
    assert chance_gain(target, {}, tried, draws=20) == pytest.approx(expected)
    assert chance_gain(target, {("a", "k"): 1.0}, tried, draws=20) == 0.0
    fitted = np.eye(6)[:1]
    assert chance_gain(target, {}, tried, jacobian=fitted, draws=20) == 0.0
    slanted = np.array([[1.0, 1.0, 0.0, 0.0, 0.0, 0.0]])
    half = chance_gain(target, {}, tried, jacobian=slanted, draws=20)
    assert half == pytest.approx(0.5 * expected)  # of each draw and of each change half stands beside what is fitted


# --- held-out data, scales, and the size of a car


class Chooser(SettledSearch):
    """A search near a bound: what is left of the data fitted on, and squares on those that judge."""

    def __init__(self, level: float, held: dict[str, int]) -> None:
        super().__init__()
        self.level, self.held = level, held

    def trial(self, names: Any, values: Any = None, zoom: bool = False) -> Any:
        return SimpleNamespace(names=tuple(names), values={"held": self.held[names[0]]}, chi2=self.level)

    def in_place_of(self, best: Any, name: str, among: Any) -> list[Any]:
        return [self.trial(("b",))] if name == "a" else []


@pytest.mark.parametrize(
    ("level", "before", "held", "taken"),
    [(2000.0, 200, 190, True), (1999.0, 200, 190, False), (2000.0, 200, 191, False),
     (2000.0, 50, 45, True), (2000.0, 50, 46, False), (2000.0, 100, 95, True)],
)  # fmt: skip
def test_a_rival_is_taken_for_five_percent_from_twice_the_noise_on(
    level: float, before: int, held: int, taken: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of 100 samples: 5 % of what is left, or of the samples where less than the noise is left."""
    monkeypatch.setattr(held_out_choice, "refit_on_fold", lambda search, fold, trial: trial)
    monkeypatch.setattr(held_out_choice, "whole_actuators", lambda search, final: iter(()))
    judge: Any = SimpleNamespace(count=100, whitened=lambda values: np.ones(values["held"]))
    search: Any = Chooser(level, {"a": before, "b": held})
    found = chosen(search, SearchResult(search.trial(("a",)), {"a": ("b",)}, ()), (Fold(None, judge),))
    assert found.final.names == (("b",) if taken else ("a",))


def test_scales_of_pedals_are_plausible_up_to_their_bounds() -> None:
    assert implausible_scales({"full_throttle": 15.0, "full_brake": 1.0, "other": 1e9}, Inputs()) == []
    assert len(implausible_scales({"full_throttle": 0.4999, "full_brake": 15.001}, Inputs())) == 2


def turning(monkeypatch: pytest.MonkeyPatch, n: int = 100, **given: Any) -> str:
    """What is said of a car of 2.5 m whose steering and yaw rate imply another wheelbase."""
    m = a_motion(n, **given)
    monkeypatch.setattr(wheelbase_check, "motion", lambda log, model: m)
    model: Any = SimpleNamespace(car=SimpleNamespace(wheelbase=2.5))
    return wrong_wheelbase({"a": None}, model)  # type: ignore[dict-item]


def test_a_car_of_another_size_is_told_by_a_hundred_gentle_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    """8 m/s, 0.25 rad/s: tan(steer) is the wheelbase over 32 m."""
    steer = math.atan(10.0 / 32.0)
    told = turning(monkeypatch, steer=np.full(100, steer))
    assert told.startswith("steering, yaw rate and speed imply a wheelbase of 10 m, the model has 2.5 m")
    assert turning(monkeypatch, 99, steer=np.full(99, steer)) == ""
    small = math.atan(1.0 / 32.0)
    assert "of 1 m" in turning(monkeypatch, steer=np.full(100, small))
    assert turning(monkeypatch, steer=np.full(100, steer), yaw_rate=np.zeros(100)) == ""  # it does not turn at all
    for wheelbase in (1.3, 2.5, 4.9):
        assert turning(monkeypatch, steer=np.full(100, math.atan(wheelbase / 32.0))) == ""
    assert turning(monkeypatch, steer=np.full(100, -steer)) == ""  # the other way: no size at all
    half = np.arange(100) < 50
    for few in (
        {"moving": half}, {"v": np.where(half, 8.0, 1.0)}, {"yaw_rate": np.where(half, 0.25, 0.375)},
        {"steer": np.where(half, steer, 0.01)},
    ):  # fmt: skip
        assert turning(monkeypatch, **({"steer": np.full(100, steer)} | few)) == ""


def test_a_place_in_a_range_that_is_three_times_as_wide_is_straight() -> None:
    for high, by_ratio in ((3.0, False), (3.001, True)):
        assert Coordinate("effect", Key("k", "-", 1.0, high, 0.0, 0.1)).by_ratio is by_ratio
    assert not Coordinate("effect", Key("k", "-", 0.0, 9.0, 0.0, 0.1)).by_ratio


@pytest.mark.parametrize(("late", "told"), [(0.0, False), (1.0, False), (1.5, True)])
def test_a_car_may_answer_its_steering_up_to_a_second_late(
    late: float, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A slalom of 2.32 rad/s: half a second more turns it by 66 degrees, and two fifths of the turns are left. One of
    half that pace would lose as much in the first second, were it not taken out."""
    for pace in (2.3186, 1.1593) if late <= 1.0 else (2.3186,):
        t = 0.02 * np.arange(3000)
        steer = 0.2 * np.sin(pace * t)
        rate = 8.0 * np.tan(0.2 * np.sin(pace * (t - late))) / 2.5
        v, moving = np.full(3000, 8.0), np.ones(3000, dtype=bool)
        said = turning(monkeypatch, 3000, t=t, step=0.02, v=v, yaw_rate=rate, steer=steer, moving=moving)
        assert bool(said) is told


def test_another_log_is_known_on_its_stamps_also_beside_a_hole() -> None:
    """Ten rows of 0.125 s, none for 10 s, and ten more: it is known at both ends of the hole and not in it."""
    stamps = np.concatenate([1.0 + 0.125 * np.arange(10), 12.0 + 0.125 * np.arange(10)])
    log = Log({"t": stamps, "v": stamps**2})
    asked = np.array([0.5, 1.0, 1.0625, 2.125, 2.126, 7.0, 11.999, 12.0, 13.125, 13.2])
    found = LogSubject(log).at(asked)[:, CHANNELS.index("v")]
    middle = 0.5 * (1.0 + 1.125**2)
    assert found == pytest.approx([np.nan, 1.0, middle, 2.125**2, *[np.nan] * 3, 144.0, 13.125**2, np.nan], nan_ok=True)
    assert np.isnan(LogSubject(log).at(asked)[:, CHANNELS.index("x")]).all()
