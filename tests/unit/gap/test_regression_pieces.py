"""What a regression of an error is built from, each piece against its closed form."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.compare.smoothed_motion import Motion, bridged, mean_around
from pytest_dvp.gap.compare.time_alignment import _without_slow, coverage, grid, on_grid
from pytest_dvp.gap.diagnose import residual_regression
from pytest_dvp.gap.diagnose.linear_algebra import broyden_update, gram, orthonormal, row_products, square
from pytest_dvp.gap.diagnose.regression_signals import (
    Signals,
    _judged,
    lagged,
    rate_limited,
    with_play,
    with_stiction,
)
from pytest_dvp.gap.diagnose.residual_recurrence import (
    _comes_back,
    _ranks,
    at_same_place,
    at_speed,
    in_same_direction,
    over_time,
)
from pytest_dvp.gap.diagnose.residual_regression import TermSums, _add, _gain, _rows, _solved, term_sums
from pytest_dvp.gap.diagnose.residual_spectrum import _peak, _vertex, peaks
from pytest_dvp.logs.log_contents import FloatArray

RNG = np.random.default_rng(0)


def test_a_mean_around_each_sample_has_fewer_at_the_ends() -> None:
    y = RNG.normal(size=20)
    assert mean_around(y, 3) == pytest.approx([y[max(i - 3, 0) : i + 4].mean() for i in range(20)])


def test_gaps_are_bridged_and_nothing_known_is_nought() -> None:
    t = np.arange(5.0)
    assert bridged(t, np.array([np.nan, 1.0, np.nan, 3.0, np.nan])) == pytest.approx([1.0, 1.0, 2.0, 3.0, 3.0])
    assert bridged(t, np.full(5, np.nan)).tolist() == [0.0] * 5


@pytest.mark.parametrize(("n", "half"), [(300, 125), (100, 49), (2, 1)])
def test_slow_changes_are_the_mean_over_five_seconds_or_of_what_is_there(n: int, half: int) -> None:
    y = RNG.normal(size=n) + 3.0
    half = min(half, (n - 1) // 2)
    expected = [y[i] - y[max(i - half, 0) : i + half + 1].mean() for i in range(n)]
    assert _without_slow(y, 0.02) == pytest.approx(expected)


def test_a_row_stands_for_the_time_to_the_next_and_before_a_gap_for_the_usual_step() -> None:
    t = np.array([0.0, 1.0, 2.0, 3.0, 9.0, 10.0])
    known = np.array([True, False, True, True, True, True])
    assert coverage(t, known, 5.0) == pytest.approx((1.0 + 1.0 + 1.0 + 1.0) / 10.0)
    assert coverage(t, known, 6.0) == pytest.approx((1.0 + 1.0 + 6.0 + 1.0) / 10.0)


def test_an_even_time_base_has_the_usual_step_and_reaches_the_end() -> None:
    assert grid(np.array([1.0, 1.5, 2.0, 2.75, 3.25])) == pytest.approx([1.0, 1.5, 2.0, 2.5, 3.0])
    assert grid(0.1 * np.arange(8)) == pytest.approx(0.1 * np.arange(8))
    even = np.array([0.0, 0.5, 2.5])
    assert on_grid(even, np.arange(3.0), np.array([0.0, np.nan, 4.0])) == pytest.approx([0.0, 1.0, 4.0])
    assert np.isnan(on_grid(even, np.arange(3.0), np.full(3, np.nan))).all()


def test_products_are_those_of_numpy() -> None:
    rows, r = RNG.normal(size=(3, 40)), RNG.normal(size=40)
    assert square(r) == pytest.approx(float(r @ r))
    assert row_products(rows, r) == pytest.approx(rows @ r)
    assert gram(rows) == pytest.approx(rows @ rows.T)


def test_a_corrected_derivative_says_what_was_seen_and_keeps_what_stands_at_right_angles() -> None:
    rows, step, change = RNG.normal(size=(3, 40)), np.array([0.3, -0.2, 0.5]), RNG.normal(size=40)
    before = rows.copy()
    broyden_update(rows, step, change)
    assert step @ rows == pytest.approx(change)
    across = np.array([0.2, 0.3, 0.0])
    assert across @ step == pytest.approx(0.0)
    assert across @ rows == pytest.approx(across @ before)
    broyden_update(rows, np.zeros(3), 5.0 * change)
    assert step @ rows == pytest.approx(change)


def test_orthonormal_rows_span_the_same_and_leave_out_what_is_no_news() -> None:
    rows = RNG.normal(size=(2, 40))
    tiny = rows[0] + 1e-5 * RNG.normal(size=40)
    found = orthonormal(
        np.array([rows[0], rows[1], rows[0] + 2.0 * rows[1], tiny, np.zeros(40), rows[0] * (1.0 + 1e-9)])
    )
    assert found.shape == (3, 40)
    assert found @ found.T == pytest.approx(np.eye(3), abs=1e-12)
    for row in (*rows, tiny):
        assert (found @ row) @ found == pytest.approx(row)
    assert orthonormal(np.zeros((2, 7))).shape == (0, 7)
    close = np.array([rows[0], rows[0] + 1e-5 * rows[1]])
    assert orthonormal(close)[0] @ orthonormal(close)[1] == pytest.approx(0.0, abs=1e-14)


def test_a_lag_answers_a_step_by_an_exponential_as_the_mean_of_each_step() -> None:
    u, share = np.array([2.0, 5.0, 5.0, 5.0]), np.full(4, 0.3)
    k = np.arange(3.0)
    mean = 5.0 - 3.0 * (np.exp(-0.3 * k) - np.exp(-0.3 * (k + 1.0))) / 0.3
    assert lagged(u, share) == pytest.approx([2.0, *mean])
    assert lagged(u, np.zeros(4)) == pytest.approx([2.0] * 4)
    assert lagged(u, np.full(4, 1e-8)) == pytest.approx([2.0] * 4, abs=1e-6)


def test_a_limited_rate_ramps_and_gives_the_mean_of_each_step() -> None:
    """From 0 to 2.5 with 1 a step: means of the ramp, in the last step half of it is at rest: 2.5 - 0.25 x 0.5."""
    u = np.array([0.0, 2.5, 2.5, 2.5, 2.5, -0.5])
    assert rate_limited(u, 1.0) == pytest.approx([0.0, 0.5, 1.5, 2.375, 2.5, 2.0])


def test_play_and_stiction_follow_late() -> None:
    u = np.array([0.0, 0.3, 1.0, 0.9, 0.4, -1.0])
    assert with_play(u, 0.25) == pytest.approx([0.0, 0.05, 0.75, 0.75, 0.65, -0.75])
    assert with_stiction(u, 0.5) == pytest.approx([0.0, 0.0, 1.0, 1.0, 0.4, -1.0])
    assert with_stiction(np.array([0.0, 0.5, 0.9]), 0.5) == pytest.approx([0.0, 0.5, 0.5])


def a_signal(**given: Any) -> Signals:
    count = 200
    zeros = np.zeros(count)
    fields: dict[str, Any] = {"step": 0.02, "w": 5, "rows": np.arange(10, 180, 5), "t": np.arange(count) * 0.02,
                              "v": zeros + 5.0, "rate": zeros, "yaw": zeros, "accel": zeros, "steer": zeros,
                              "wheelbase": 2.5, "cg_front": 1.2, "gyration": 1.5,
                              "measured": {}, "noise": {}}  # fmt: skip
    return Signals(**(fields | given))


def test_a_mean_over_a_window_is_of_its_ten_rows_and_may_be_older() -> None:
    s, y = a_signal(), RNG.normal(size=200)
    assert s.mean(y) == pytest.approx([y[r - 5 : r + 5].mean() for r in s.rows])
    assert s.late_mean(y, 0.0) == pytest.approx(s.mean(y))
    assert s.late_mean(y, 0.04) == pytest.approx([y[r - 7 : r + 3].mean() for r in s.rows])
    half = [(y[r - 7 : r + 3].sum() + y[r - 8 : r + 2].sum()) / 20.0 for r in s.rows]
    assert s.late_mean(y, 0.05) == pytest.approx(half)


def test_equations_see_means_and_slopes_over_a_window() -> None:
    s = a_signal(yaw=np.full(200, 0.3))
    t = s.t
    of = {"v": 3.0 * t, "ax": 2.0 * t, "yaw_rate": 0.5 * t, "yaw": -0.4 * t, "ay": 6.0 * t, "x": 2.0 * t, "y": -1.0 * t}
    noise = {"v": 0.01, "ax": 0.1, "yaw_rate": 0.02, "yaw": 0.003, "ay": 0.2, "x": 0.05, "y": 0.04}
    _judged(s, of, noise)
    middle = t[s.rows] - 0.01  # the window is that of its ten rows
    assert s.measured["dv"] == pytest.approx(3.0)
    assert s.measured["ax"] == pytest.approx(2.0 * middle)
    assert s.measured["r"] == pytest.approx(0.5 * middle)
    assert s.measured["dyaw"] == pytest.approx(-0.4)
    assert s.measured["ay"] == pytest.approx(6.0 * middle - 5.0 * 0.5 * middle)
    c, d = np.cos(0.3), np.sin(0.3)
    assert s.measured["forward"] == pytest.approx(2.0 * c - d - 3.0 * middle)
    assert s.measured["sideways"] == pytest.approx(-c - 2.0 * d)
    slope = np.sqrt(2.0) / 0.2
    assert s.noise["forward"] == pytest.approx(0.05 * slope)
    assert s.noise["sideways"] == pytest.approx(np.hypot(0.05 * slope, 0.003 / np.sqrt(10.0) * 5.0))
    assert s.noise["ay"] == pytest.approx(np.hypot(0.2, 5.0 * 0.02) / np.sqrt(10.0))


@pytest.mark.parametrize(
    ("given", "series"), [({"accel": None}, {"r", "dyaw", "ay"}), ({"steer": None}, {"dv", "ax", "ay"})]
)
def test_an_equation_needs_its_command(given: dict[str, Any], series: set[str]) -> None:
    s = a_signal(**given)
    of = dict.fromkeys(("v", "ax", "yaw_rate", "yaw", "ay", "x"), np.zeros(200))
    _judged(s, of, dict.fromkeys(of, 0.1))
    assert set(s.measured) == series


def moving(n: int, *, step: float = 0.1, **given: Any) -> Motion:
    zeros = np.zeros(n)
    fields: dict[str, Any] = {"t": step * np.arange(n), "step": step, "x": zeros, "y": zeros, "yaw": zeros,
                              "v": zeros + 5.0, "yaw_rate": zeros, "accel": None, "steer": None,
                              "moving": np.ones(n, dtype=bool), "way": 0.5 * np.arange(n), "braked": zeros,
                              "driven": zeros, "wheelbase": 2.5}  # fmt: skip
    return Motion(**(fields | given))


def test_an_error_that_comes_back_is_predicted_by_the_other_visits() -> None:
    """Six visits each of two cells, 25 s long: +1 and -1 with what a visit adds of its own. Of each is taken the mean
    of the other visits of its cell, but of none within 20 s."""
    own = RNG.normal(size=12) * 0.3
    levels = np.where(np.arange(12) % 2, -1.0, 1.0) + own
    m = moving(12 * 250)
    cell = np.repeat(np.arange(12) % 2, 250)
    error = np.repeat(levels, 250)
    found = _comes_back([error], [m], cell)
    smooth = mean_around(error, 2).reshape(12, 250).mean(axis=1)
    left = sum((smooth[k] - np.mean([smooth[j] for j in range(k % 2, 12, 2) if j != k])) ** 2 for k in range(12))
    assert found == pytest.approx(1.0 - left / np.sum(smooth**2))


@pytest.mark.parametrize(("visits", "told"), [(6, True), (5, False)])
def test_six_visits_are_needed(visits: int, told: bool) -> None:
    cell = np.repeat(np.where(np.arange(2 * visits - 1) % 2, 100 + np.arange(2 * visits - 1), 0), 250)
    found = _comes_back([np.ones(len(cell))], [moving(len(cell))], cell)
    assert (found is not None) is told
    assert found is None or found == pytest.approx(1.0)


@pytest.mark.parametrize(("apart", "told"), [(198, False), (202, True)])
def test_visits_within_twenty_seconds_are_one(apart: int, told: bool) -> None:
    """Three cells, each visited twice for a second, so many rows of 0.1 s from one visit to the next."""
    cell = 1000 + np.arange(3 * 300)  # elsewhere it never comes back
    for k in range(3):
        for begin in (300 * k, 300 * k + apart):
            cell[begin : begin + 10] = k
    found = _comes_back([np.ones(900)], [moving(900)], cell)
    assert found == (pytest.approx(1.0) if told else None)


@pytest.mark.parametrize(("rows", "told"), [(4, True), (3, False)])
def test_a_visit_has_four_rows_on_the_move(rows: int, told: bool) -> None:
    cell = np.tile([*[0] * rows, *[1] * 250], 7)
    cell = np.where(cell == 0, 0, 1000 + np.cumsum(np.diff(cell, prepend=0) != 0))
    assert (_comes_back([np.ones(len(cell))], [moving(len(cell))], cell) is not None) is told
    still = moving(len(cell), moving=np.zeros(len(cell), dtype=bool))
    assert _comes_back([np.ones(len(cell))], [still], cell) is None


def test_visits_of_two_logs_are_apart_and_weigh_by_their_rows() -> None:
    logs = [moving(40), moving(40)]
    cell = np.repeat([0, 1, 2, 3, 0, 1, 2, 3], [10, 10, 10, 10, 4, 12, 12, 12])
    errors = [np.repeat([1.0, 2.0, 3.0, -1.0], 10), np.repeat([1.0, 2.5, 3.0, -2.0], [4, 12, 12, 12])]
    smooth = [mean_around(e, 2) for e in errors]
    first = [smooth[0][k * 10 : (k + 1) * 10].mean() for k in range(4)]
    second = [piece.mean() for piece in np.split(smooth[1], [4, 16, 28])]
    left = sum((10 + n) * (a - b) ** 2 for a, b, n in zip(first, second, [4, 12, 12, 12], strict=True))
    total = sum(10 * a * a + n * b * b for a, b, n in zip(first, second, [4, 12, 12, 12], strict=True))
    assert _comes_back(errors, logs, cell) == pytest.approx(1.0 - left / total)


def test_places_are_cells_of_a_thirtysecond_of_the_map_and_directions_are_eight() -> None:
    """Laps of a circle of 2 pi x 20 m in 30 s. An error that depends on the heading comes back in each direction; one
    that has a wave within a sector (a cell has 1.25 m of 3.9 m a row) comes back at its place alone."""
    t = 0.1 * np.arange(300 * 7)
    angle = 2.0 * np.pi * t / 30.0
    m = moving(len(t), x=20.0 * np.sin(angle), y=-20.0 * np.cos(angle), yaw=angle - 9.0)
    by_sector = np.where(np.floor((m.yaw % (2.0 * np.pi)) * 4.0 / np.pi) % 2 == 1, 1.0, -1.0)
    assert in_same_direction([by_sector], [m]) == pytest.approx(1.0, abs=0.02)
    within = np.sin(16.0 * m.yaw)
    assert (at_same_place([within], [m]) or 0.0) > 0.9
    assert in_same_direction([within * np.sign(np.sin(np.floor(angle / 2 / np.pi) * 2.0 + 0.5))], [m]) is not None
    shifted = np.where(np.floor(((m.yaw + np.pi / 8.0) % (2.0 * np.pi)) * 4.0 / np.pi) % 2 == 1, 1.0, -1.0)
    assert abs(in_same_direction([shifted], [m]) or 0.0) < 1.5
    spread = in_same_direction([np.sin(np.floor(angle / (2.0 * np.pi)) * 2.4 + 1.0)], [m])
    assert spread is not None
    assert spread < 0.1


def test_the_bin_of_speed_with_most_error_for_its_time_is_named() -> None:
    v = np.repeat([2.0, 7.0, 12.0, 17.0], [100, 100, 100, 100])
    m = moving(400, v=v, moving=np.arange(400) >= 50)
    error = np.repeat([9.0, 1.0, 2.0, 1.0], [50, 100, 150, 100])
    error[:50] = 99.0
    found = at_speed([error], [m])
    squares = error**2
    total = squares[50:].sum()
    assert found["bin"] == "speed 10-15 m/s"
    assert found["share_of_error"] == pytest.approx(squares[200:300].sum() / total)
    assert found["share_of_time"] == pytest.approx(100 / 350)


def test_an_error_that_grows_with_time_has_a_rank_correlation_of_one() -> None:
    assert over_time([np.array([1.0, 2.0, 5.0, 9.0])]) == pytest.approx(
        {"rank_correlation": 1.0, "share_in_second_half": 14.0 / 17.0}
    )
    assert over_time([np.array([4.0, 3.0, 2.0, 1.0, 0.0])])["rank_correlation"] == pytest.approx(-1.0)
    assert over_time([np.array([4.0, 3.0, 2.0, 1.0, 0.0])])["share_in_second_half"] == pytest.approx(3.0 / 10.0)
    both = over_time([np.array([1.0, 2.0, 5.0, 9.0]), np.array([2.0, 1.0, 1.5, 0.5]), np.array([5.0, 1.0, 1.0])])
    assert both["rank_correlation"] == pytest.approx((17.0 * 1.0 + 5.0 * -0.8) / 22.0)
    assert both["share_in_second_half"] == pytest.approx((14.0 + 2.0) / 22.0)
    nothing = {"rank_correlation": 0.0, "share_in_second_half": 0.5}
    assert over_time([np.array([1.0, 2.0, 3.0]), np.zeros(8)]) == nothing
    assert _ranks(np.array([0.3, 0.1, 0.3, 0.2])).tolist() == [2, 0, 3, 1]


def test_a_wave_is_told_by_its_frequency_and_its_share_of_the_error() -> None:
    step = 0.02
    t, frequency = step * np.arange(4000), 224 / (8192 * step)  # of the grid: 8192 is the power of 2 above 2 x 4000
    rest = RNG.normal(size=4000)
    rest *= 1.0 / rest.std()
    found = _peak("time", "Hz", [np.sqrt(2.0) * np.sin(2.0 * np.pi * frequency * t) * 2.0 + rest + 5.0], step, 10.0)
    assert found is not None
    assert found.frequency == pytest.approx(frequency, abs=0.002)
    assert found.share == pytest.approx(4.0 / 5.0, abs=0.02)
    assert (found.kind, found.unit) == ("time", "Hz")


def test_logs_have_each_their_own_phase() -> None:
    t = 0.02 * np.arange(2000)
    both = [np.sin(2.0 * np.pi * 2.0 * t), np.sin(2.0 * np.pi * 2.0 * t + 2.0)]
    found = _peak("time", "Hz", [*both, np.full(15, 9.0)], 0.02, 10.0)
    assert found is not None
    assert found.share == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize(("frequency", "usable"), [(0.05, False), (0.1, True), (9.5, True), (10.5, False)])
def test_a_wave_has_three_cycles_in_the_log_and_is_not_faster_than_ten_hertz(frequency: float, usable: bool) -> None:
    t = 0.02 * np.arange(2000)
    found = _peak("time", "Hz", [np.sin(2.0 * np.pi * frequency * t)], 0.02, 10.0)
    assert found is not None
    assert (abs(found.frequency - frequency) < 0.02 and found.share > 0.5) is usable


def test_a_short_or_still_log_has_no_peak() -> None:
    wave = np.sin(0.9 * np.arange(64))
    assert _peak("time", "Hz", [wave], 0.02, 10.0) is not None
    assert _peak("time", "Hz", [wave[:63]], 0.02, 10.0) is None
    assert _peak("time", "Hz", [np.full(64, 3.0)], 0.02, 10.0) is None
    assert _peak("time", "Hz", [wave], 0.02, 1.0) is None


def test_a_peak_lies_at_the_vertex_of_a_parabola() -> None:
    f = np.arange(6.0) * 0.5
    power = 4.0 - (f - 1.2) ** 2
    assert _vertex(f, power, 2) == pytest.approx(1.2)
    assert _vertex(f, power, 0) == 0.0
    assert _vertex(f, power, 5) == 2.5
    assert _vertex(f, np.ones(6), 2) == 1.0
    assert _vertex(f, power[::-1].copy(), 3) == pytest.approx(2.5 - 1.2)


def test_peaks_are_looked_for_over_time_and_over_the_way_driven() -> None:
    """A wheel out of round at a changing speed: 0.5 cycles a metre."""
    t = 0.02 * np.arange(5000)
    way = np.cumsum(0.02 * (8.0 + 4.0 * np.sin(0.3 * t)))
    way[1000:1100] = way[1000]
    way = np.maximum.accumulate(way)
    found = peaks([np.sin(2.0 * np.pi * 0.5 * way)], [t], [way])
    assert found[0].kind == "distance"
    assert found[0].frequency == pytest.approx(0.5, abs=0.002)
    assert found[0].share > 0.9 > found[1].share
    still = peaks([np.sin(2.0 * np.pi * 3.0 * t)], [t], [way])
    assert (still[0].kind, still[0].unit) == ("time", "Hz")
    assert still[0].frequency == pytest.approx(3.0, abs=0.002)


def sums(columns: FloatArray, y: FloatArray, folds: int, places: tuple[slice, ...]) -> TermSums:
    p = columns.shape[1]
    a, b = np.zeros((folds, p, p)), np.zeros((folds, p))
    size = len(y) // folds
    for k in range(folds):
        own = slice(k * size, (k + 1) * size)
        _add(a[k], b[k], columns[own], y[own])
        assert a[k] == pytest.approx(columns[own].T @ columns[own])
        assert b[k] == pytest.approx(columns[own].T @ y[own])
    squares = np.array([float(y[k * size : (k + 1) * size] @ y[k * size : (k + 1) * size]) for k in range(folds)])
    return TermSums(a, b, squares, np.full(folds, size / 4.0), places)


def test_terms_explain_what_least_squares_says_of_the_excess() -> None:
    columns = RNG.normal(size=(100, 3))
    columns[:7, 0], columns[7:14, 0] = 0.0, 1.0
    y = columns @ np.array([2.0, -1.0, 0.5]) + 0.3 * RNG.normal(size=100)
    found = sums(columns, y, 5, (slice(0, 2), slice(2, 3)))
    excess = float(y @ y) - 25.0
    assert found.excess == pytest.approx(excess)
    share, theta = found.fitted([0])
    best, left, *_ = np.linalg.lstsq(columns[:, :2], y, rcond=None)
    assert theta == pytest.approx(best, rel=1e-4)
    assert share == pytest.approx((float(y @ y) - float(left[0])) / excess, rel=1e-5)
    assert found.fitted([0, 1])[1] == pytest.approx(np.linalg.lstsq(columns, y, rcond=None)[0], rel=1e-4)
    assert found.fitted([1])[1] == pytest.approx([columns[:, 2] @ y / (columns[:, 2] @ columns[:, 2])], rel=1e-4)
    gain = 0.0
    for k in range(5):
        out = np.arange(20 * k, 20 * k + 20)
        rest = np.setdiff1d(np.arange(100), out)
        other = np.linalg.lstsq(columns[rest], y[rest], rcond=None)[0]
        gain += float(y[out] @ y[out]) - float(np.sum((y[out] - columns[out] @ other) ** 2))
    assert found.held_out([0, 1]) == pytest.approx(gain / excess, rel=1e-5)
    assert found.left(0.4) == pytest.approx((float(y @ y) - 0.4 * excess) / 25.0)


def test_no_excess_is_not_divided_by() -> None:
    empty = TermSums(np.zeros((1, 1, 1)), np.zeros((1, 1)), np.array([3.0]), np.array([0.0]), (slice(0, 1),))
    assert empty.left(0.0) == pytest.approx(3.0)
    quiet = TermSums(np.zeros((1, 1, 1)), np.zeros((1, 1)), np.array([3.0]), np.array([9.0]), (slice(0, 1),))
    assert quiet.excess == 1e-9
    assert _solved(np.zeros((1, 1)), np.zeros(1)).tolist() == [0.0]
    assert _gain(np.array([[4.0]]), np.array([6.0]), np.array([1.5])) == pytest.approx(9.0)


@pytest.mark.parametrize(("axis", "direct", "summed"), [("longitudinal", 5, 3), ("lateral", 4, 2)])
def test_a_term_shows_at_once_in_one_channel_and_summed_up_in_another(axis: Any, direct: int, summed: int) -> None:
    """A road-wheel angle d turns the car by v d / L; the sum of a rate over time begins with each segment."""
    m = moving(6, v=np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]))
    names = ("x", "y", "yaw", "v", "yaw_rate", "ax", "ay", "steer")
    e = SimpleNamespace(channels=names, sigma=np.arange(1.0, 9.0))
    rest = RNG.normal(size=(6, 8))
    phi = RNG.normal(size=(6, 1))
    (y, x, free), (y2, x2, free2) = _rows(axis, e, rest, m, phi)  # type: ignore[arg-type]
    acts = phi[:, 0] * m.v / 2.5 if axis == "lateral" else phi[:, 0]
    assert (free, free2) == (False, True)
    assert y == pytest.approx(rest[:, direct] / (direct + 1.0))
    assert x[:, 0] == pytest.approx(acts / (direct + 1.0))
    assert y2 == pytest.approx(rest[:, summed] / (summed + 1.0))
    assert x2[:, 0] == pytest.approx(np.cumsum(acts * np.array([0.1] * 5 + [0.0])) / (summed + 1.0))
    e.channels = ("ay",)
    assert list(_rows(axis, e, rest, m, phi)) == []  # type: ignore[arg-type]


def test_where_a_start_is_free_only_what_changes_within_a_segment_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    """A level of its own in each segment explains nothing and costs nothing: sums are those about the segment's means,
    of the residual and of the terms."""
    starts, ends = np.array([0, 12, 30]), np.array([12, 30, 40])
    x, y = RNG.normal(size=(40, 2)), RNG.normal(size=40)
    y[3] = np.nan
    e: Any = SimpleNamespace(segments=SimpleNamespace(starts=starts, ends=ends))
    terms: Any = [SimpleNamespace(columns=x)]
    for free in (True, False):
        monkeypatch.setattr(residual_regression, "_rows", lambda *given, free=free: [(y, x, free)])
        found = term_sums("lateral", SimpleNamespace(experiments=[e]), [x], [None], [terms])  # type: ignore[arg-type,list-item]
        for k, (first, end) in enumerate(zip(starts, ends, strict=True)):
            own = [i for i in range(first, end) if i != 3]
            xx, yy = x[own] - free * x[own].mean(axis=0), y[own] - free * y[own].mean()
            assert found.a[k] == pytest.approx(xx.T @ xx)
            assert found.b[k] == pytest.approx(xx.T @ yy)
            assert (found.chi2[k], found.count[k]) == (pytest.approx(yy @ yy), len(own))
