"""Each threshold of the regimes, held from both sides by drives of constant phases.

The step is 1/64 s, so that stamps have no rounding. The window of the smoothing is then 19 samples to either side.
"""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.gap.compare.regimes import _after, _smooth, _usual, regimes, ribbon, speed_bins
from pytest_dvp.logs.log_contents import FloatArray

STEP = 1.0 / 64.0
N = 64 * 100
T = STEP * np.arange(N)
FAST = np.full(N, 20.0)
NONE = np.zeros(N)


def phases(*parts: tuple[float, float, float], default: float = 0.0) -> FloatArray:
    """`default`, and (from [s], to [s], value) in between."""
    found = np.full(N, default)
    for begin, end, value in parts:
        found[round(begin * 64) : round(end * 64)] = value
    return found


def test_usual_is_what_one_in_twenty_exceeds() -> None:
    assert _usual(-np.linspace(0.0, 100.0, 101)) == pytest.approx(95.0, abs=1e-6)
    assert 0.0 < _usual(np.zeros(5)) < 1e-6


def test_smoothing_is_the_mean_of_the_window_and_of_fewer_at_the_ends() -> None:
    y = np.random.default_rng(1).normal(size=30)
    expected = [y[max(i - 4, 0) : i + 5].mean() for i in range(30)]
    assert _smooth(y, 4) == pytest.approx(expected)


def test_after_holds_up_to_its_reach_and_not_beyond_a_break() -> None:
    t = np.arange(12.0)
    cause = np.isin(t, [2.0, 8.0])
    during = ~np.isin(t, [2.0, 8.0, 10.0])
    assert np.flatnonzero(_after(t, cause, during, 3.0)).tolist() == [3, 4, 5, 9]
    assert not _after(t, np.zeros(12, dtype=bool), during, 3.0).any()


def test_a_demand_beyond_half_a_metre_per_second_squared_drives_or_brakes() -> None:
    demand = phases((0, 10, 3.0), (20, 25, 0.51), (25, 30, 0.49), (50, 55, -0.51), (60, 65, -0.49))
    masks = regimes(T, FAST, NONE, demand)
    braking = np.flatnonzero(masks["braking"])
    assert (braking[0], braking[-1]) == (50 * 64, 55 * 64 - 1)
    assert len(braking) == 5 * 64
    lift = np.flatnonzero(masks["lift_off"])  # 2 s after each drive: what follows 3 m/s^2 and what follows 0.51
    assert lift.tolist() == [*range(10 * 64, 12 * 64), *range(25 * 64, 27 * 64)]
    assert not masks["launch"].any()


def test_where_little_is_usual_a_fifth_of_it_counts() -> None:
    demand = phases((0, 10, 1.0), (20, 25, 0.21), (25, 30, 0.19), (50, 55, -0.21), (60, 65, -0.19))
    masks = regimes(T, FAST, NONE, demand)
    assert np.flatnonzero(masks["braking"]).tolist() == list(range(50 * 64, 55 * 64))
    assert masks["lift_off"][25 * 64 : 27 * 64].all()
    assert not masks["lift_off"][27 * 64 :].any()


def test_strong_acceleration_below_two_fifths_of_the_usual_speed_is_a_launch() -> None:
    v = phases((20, 25, 7.9), (40, 45, 8.1), default=20.0)
    demand = phases((21, 24, 2.0), (41, 44, 2.0))
    launch = regimes(T, v, NONE, demand)["launch"]
    assert np.flatnonzero(launch).tolist() == list(range(21 * 64, 24 * 64))


def test_the_first_three_seconds_from_standstill_are_a_launch_unless_it_brakes() -> None:
    v = phases((0, 10, 0.0), default=20.0)
    demand = phases((11, 12, -1.0))
    masks = regimes(T, v, NONE, demand)
    assert masks["standstill"].sum() == 10 * 64
    launch = np.flatnonzero(masks["launch"])
    assert launch.tolist() == [*range(10 * 64, 11 * 64), *range(12 * 64, 13 * 64)]
    unbroken = regimes(T, v, NONE, phases((60, 70, -1.0)))["launch"]
    assert np.flatnonzero(unbroken).tolist() == list(range(10 * 64, 13 * 64))


def test_reverse_is_neither_standstill_nor_braking() -> None:
    v = phases((0, 30, -5.0), default=20.0)
    masks = regimes(T, v, NONE, phases((5, 10, -2.0), (40, 42, -2.0)))
    assert masks["reverse"][: 29 * 64].all()
    assert np.flatnonzero(masks["braking"]).tolist() == list(range(40 * 64, 42 * 64))


def test_without_a_demand_the_change_of_speed_tells() -> None:
    accel = phases((10, 14, 2.0), (30, 34, -2.0))
    v = 20.0 + np.cumsum(accel) * STEP
    for demand in (None, np.full(N, np.nan)):
        braking = np.flatnonzero(regimes(T, v, NONE, demand)["braking"]) * STEP
        assert braking[0] == pytest.approx(30.0, abs=0.6)
        assert braking[-1] == pytest.approx(34.0, abs=0.6)


def test_a_demand_with_gaps_is_bridged() -> None:
    demand = phases((50, 55, -2.0))
    demand[51 * 64 : 54 * 64] = np.nan
    assert regimes(T, FAST, NONE, demand)["braking"].sum() == 5 * 64


def test_a_turn_is_half_a_metre_per_second_squared_sideways() -> None:
    side = phases((0, 10, 3.0), (20, 30, 0.52), (40, 50, 0.48), (60, 70, -0.52))
    steady = regimes(T, FAST, side / 20.0)["steady_turn"]
    for begin, turns in ((2, True), (22, True), (42, False), (62, True), (82, False)):
        assert steady[begin * 64 : (begin + 6) * 64].all() == turns, begin
        assert steady[begin * 64 : (begin + 6) * 64].any() == turns, begin


def test_where_little_turning_is_usual_a_fifth_of_it_counts() -> None:
    side = phases((0, 10, 1.0), (20, 30, 0.21), (40, 50, 0.19))
    steady = regimes(T, FAST, side / 20.0)["steady_turn"]
    assert steady[22 * 64 : 28 * 64].all()
    assert not steady[42 * 64 : 48 * 64].any()


def ramped(*ramps: tuple[float, float]) -> FloatArray:
    """Sideways acceleration [m/s^2] that rises for 4 s from each time [s] at a rate [m/s^3], stays 4 s and falls."""
    side = np.zeros(N)
    for begin, rate in ramps:
        side += rate * (np.clip(T - begin, 0.0, 4.0) - np.clip(T - begin - 8.0, 0.0, 4.0))
    return side


def test_a_turn_is_entered_where_the_sideways_acceleration_changes_by_three_fifths_of_the_bend() -> None:
    """The bend is 0.5 m/s^2, so 0.3 m/s^3. It counts from 0.3 of the bend on, which 0.32 m/s^3 reach after 0.47 s."""
    side = ramped((40.0, 0.32)) + ramped((60.0, 0.28)) + phases((0, 15, 3.0))
    masks = regimes(T, FAST, side / 20.0)
    entering = masks["turn_in"]
    assert entering[round(40.6 * 64) : round(43.6 * 64)].all()
    assert entering[round(48.4 * 64) : round(51.4 * 64)].all()
    assert not entering[round(44.4 * 64) : round(47.6 * 64)].any()
    assert not entering[(58 * 64) :].any()
    first = np.flatnonzero(entering[30 * 64 :])[0] * STEP + 30.0
    assert first == pytest.approx(40.0 + 0.15 / 0.32, abs=2.5 * STEP)
    assert masks["steady_turn"][round(62.0 * 64) : round(70.0 * 64)].all()


def test_among_hard_turns_a_quarter_of_the_usual_change_enters() -> None:
    """Ramps of 4 m/s^3 are usual here, so 1 m/s^3 is the limit."""
    hard = np.where((T >= 10.0) & (T < 26.0), 4.0 * np.abs((T - 10.0) % 8.0 - 4.0), 0.0)
    side = hard + ramped((40.0, 1.06)) + ramped((70.0, 0.94))
    entering = regimes(T, FAST, side / 20.0)["turn_in"]
    assert entering[(41 * 64) : round(43.6 * 64)].all()
    assert not entering[(60 * 64) :].any()


@pytest.mark.parametrize(
    ("top", "width"),
    [(3.0, 1.0), (4.4, 1.0), (7.0, 2.0), (9.5, 2.0), (11.0, 2.5), (19.0, 5.0), (30.0, 10.0), (40.0, 10.0)],
)
def test_bins_of_speed_have_round_edges_and_are_about_four(top: float, width: float) -> None:
    v = np.linspace(0.0, top, 2001)
    bins = speed_bins(-v)
    assert list(bins) == [f"speed {k * width:g}-{(k + 1) * width:g} m/s" for k in range(len(bins))]
    for k, mask in enumerate(bins.values()):
        inside = v < (k + 1) * width if k < len(bins) - 1 else np.ones(len(v), dtype=bool)
        assert (mask == (inside & (v >= k * width))).all()


def test_a_few_faster_samples_do_not_widen_the_bins_and_are_in_the_last() -> None:
    v = np.full(1000, 18.0)
    v[:500] = 3.0
    v[-4:] = 300.0
    bins = speed_bins(v)
    assert list(bins) == ["speed 0-5 m/s", "speed 15-20 m/s"]
    assert bins["speed 15-20 m/s"].sum() == 500


def test_a_ribbon_has_each_run_from_its_first_row_to_the_row_after_its_last() -> None:
    t = np.arange(6.0)
    masks = {"a": np.array([1, 1, 0, 0, 1, 1], dtype=bool), "b": np.array([0, 0, 1, 1, 0, 0], dtype=bool)}
    assert ribbon(masks, ("b", "a"), t) == [("a", 0.0, 2.0), ("b", 2.0, 4.0), ("a", 4.0, 5.0)]
    paused = np.where(t < 3.0, t, t + 28.0)  # within b, between 2 and 31 s
    assert ribbon(masks, ("b", "a"), paused) == [("a", 0.0, 2.0), ("b", 2.0, 2.0), ("b", 31.0, 32.0), ("a", 32.0, 33.0)]
    at_its_end = np.where(t < 4.0, t, t + 28.0)  # b ends where the log pauses, and not where it goes on
    assert ribbon(masks, ("b",), at_its_end) == [("b", 2.0, 3.0)]


@pytest.mark.parametrize(("pause", "runs"), [(1.25, [("a", 0.0, 2.75)]), (1.5, [("a", 0.0, 0.5), ("a", 2.0, 3.0)])])
def test_a_log_pauses_where_a_step_is_more_than_five_usual_ones(
    pause: float, runs: list[tuple[str, float, float]]
) -> None:
    t = np.concatenate([[0.0, 0.25, 0.5], 0.5 + pause + 0.25 * np.arange(5)])
    assert ribbon({"a": np.ones(8, dtype=bool)}, ("a",), t) == runs
