"""What a wrong start does to a segment: against drives computed twice, and least squares of numpy."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.gap.compare.start_correction import KNOTS, TAKEN_OUT, _reach, _solve, _start, _stops, project
from pytest_dvp.logs.log_contents import FloatArray

STEP = 0.01
N = 300
T = STEP * np.arange(N)


def path(v: FloatArray, curvature: FloatArray, yaw: float = 0.3) -> FloatArray:
    """Output (n, 8) of a car of these speeds [m/s] and curvatures [1/m], by straight pieces at the mean heading."""
    out = np.zeros((N, 8))
    out[:, 2] = yaw + np.concatenate([[0.0], np.cumsum(0.5 * ((v * curvature)[1:] + (v * curvature)[:-1]) * STEP)])
    out[:, 3], out[:, 4] = v, v * curvature
    heading, mean = 0.5 * (out[1:, 2] + out[:-1, 2]), 0.5 * (v[1:] + v[:-1])
    out[1:, 0], out[1:, 1] = np.cumsum(STEP * mean * np.cos(heading)), np.cumsum(STEP * mean * np.sin(heading))
    out[:, 5], out[:, 6] = np.gradient(v, STEP), v * v * curvature
    return out


BEND = 0.05 * np.sin(2.0 * T) + 0.02
V = 8.0 + np.sin(1.3 * T)


def reached(out: FloatArray, free_speed: bool = True) -> FloatArray:
    reach = np.full((N, 5, 1), np.nan)
    _reach(out, T, 0, N, free_speed, 0, reach)
    return reach[:, :, 0]


def started(out: FloatArray, measured: FloatArray, weight: FloatArray, counted: np.ndarray) -> FloatArray:
    """On a flat road."""
    reach = reached(out)[:, :, None]
    rolls = np.ones(N, dtype=bool)
    found: FloatArray = _start(out, measured, weight, 0, N, counted, rolls, 0.0, reach, np.zeros(0))
    return found


def test_one_metre_a_second_more_moves_and_turns_the_car_like_a_second_drive() -> None:
    """The wheels stay as they are, so the curvature of the path stays, and the yaw rate grows with the speed."""
    small = 1e-5
    gain = (path(V + small, BEND) - path(V - small, BEND))[:, :5] / (2.0 * small)
    assert reached(path(V, BEND)) == pytest.approx(gain, abs=2e-4)
    assert np.abs(gain[-1, :3]).min() > 0.05


def test_a_speed_that_is_imposed_cannot_be_wrong() -> None:
    assert not reached(path(V, BEND), free_speed=False).any()


def test_a_wrong_start_speed_ends_where_the_model_stands() -> None:
    v = np.where(T < 1.0, 5.0, 0.0)
    reach = reached(path(v, np.zeros(N), yaw=0.0))
    assert (reach[:100, 3] == 1.0).all()
    assert not reach[100:, 3].any()
    assert reach[99, 0] == pytest.approx(99 * STEP)
    assert reach[150:, 0] == pytest.approx(99.5 * STEP)
    creeping = reached(path(np.where(T < 1.0, 5.0, 0.002), np.zeros(N)))
    assert (creeping[:, 3] == 1.0).all()


def test_a_car_that_starts_at_rest_may_have_a_wrong_speed() -> None:
    reach = reached(path(np.where(T < STEP / 2.0, 0.0, 2.0), np.zeros(N), yaw=0.0))
    assert (reach[:, 3] == 1.0).all()


@pytest.mark.parametrize(("v", "tells"), [(0.49, False), (0.51, True), (-0.51, True)])
def test_below_half_a_metre_a_second_the_curvature_is_not_told(v: float, tells: bool) -> None:
    reach = reached(path(np.full(N, v), np.full(N, 0.2)))
    assert reach[:, 4] == pytest.approx(np.full(N, 0.2 if tells else 0.0))
    assert reach[-1, 2] == pytest.approx(0.2 * STEP * (N - 1) if tells else 0.0)


def test_a_system_of_equations_is_solved_from_its_upper_triangle() -> None:
    rng = np.random.default_rng(3)
    half = rng.normal(size=(6, 4))
    a, b, p = half.T @ half, rng.normal(size=4), np.zeros(4)
    _solve(np.triu(a), b, p)
    assert p == pytest.approx(np.linalg.solve(a, b))


@pytest.mark.parametrize("nothing", range(4))
def test_what_the_data_do_not_determine_stays_nought(nothing: int) -> None:
    rng = np.random.default_rng(4)
    half = rng.normal(size=(6, 4))
    half[:, nothing] = 0.0
    a, b, p = half.T @ half, rng.normal(size=4), np.full(4, 9.0)
    b[nothing] = 0.0
    _solve(np.triu(a), b, p)
    kept = [k for k in range(4) if k != nothing]
    assert p[nothing] == 0.0
    assert p[kept] == pytest.approx(np.linalg.solve(a[np.ix_(kept, kept)], b[kept]))


def test_of_two_unknowns_that_do_the_same_the_first_takes_all() -> None:
    a, p = np.ones((2, 2)), np.zeros(2)
    _solve(a, np.array([3.0, 3.0]), p)
    assert p.tolist() == [3.0, 0.0]
    a[1, 1] = 1.0 + 1e-7  # a hundred times the least that counts
    _solve(a, np.array([3.0, 3.0 + 1e-7]), p)
    assert p == pytest.approx([2.0, 1.0], abs=1e-6)


def moved(out: FloatArray, dx: float, dy: float, turn: float, faster: float) -> FloatArray:
    """What would be measured if the start was off by this: exactly linear, as the first order has it."""
    reach = reached(out)
    found = out.copy()
    found[:, 0] += dx + turn * (out[0, 1] - out[:, 1]) + faster * reach[:, 0]
    found[:, 1] += dy + turn * (out[:, 0] - out[0, 0]) + faster * reach[:, 1]
    found[:, 2] += turn + faster * reach[:, 2]
    found[:, 3] += faster * reach[:, 3]
    found[:, 4] += faster * reach[:, 4]
    found[:, 6] += faster * 2.0 * out[:, 4] * reach[:, 3]  # d(v^2 k)/dv = 2 v k
    return found


WEIGHT = 1.0 / np.array([0.02, 0.03, 0.005, 0.04, 0.006, 0.1, 0.2, 0.01])
START = (0.7, -0.4, 0.02, 0.3)


def test_each_part_of_a_wrong_start_is_found_with_whatever_tells_it() -> None:
    out = path(V, BEND)
    measured = moved(out, *START)
    everything = np.ones(N, dtype=bool)
    assert started(out, measured, WEIGHT, everything) == pytest.approx(START)
    for channels, known in (([0, 1], range(4)), ([2], (2, 3)), ([3], (3,)), ([4], (3,)), ([6], (3,)), ([5, 7], ())):
        weight = np.zeros(8)
        weight[channels] = WEIGHT[channels]
        found = started(out, measured, weight, everything)
        expected = [START[k] if k in known else 0.0 for k in range(4)]
        assert found == pytest.approx(expected, abs=1e-6), channels


def test_where_the_speed_is_not_measured_a_standstill_does_not_make_one_up() -> None:
    """Of a car that stands, the first row alone depends on the speed at the start: noise of the position."""
    measured = (out := path(np.zeros(N), BEND)).copy()
    measured[:, 0] += 0.02 * np.cos(np.arange(N))
    weight = np.where(np.isin(np.arange(8), (0, 1, 2)), WEIGHT, 0.0)
    assert abs(started(out, measured, weight, np.ones(N, dtype=bool))[3]) < 0.01


def test_a_start_is_the_weighted_least_squares_of_all_rows_that_count() -> None:
    out = path(V, BEND)
    rng = np.random.default_rng(5)
    measured = out + rng.normal(size=(N, 8)) / WEIGHT
    measured[::7, 3] = np.nan
    counted = np.arange(N) % 5 != 0
    reach = reached(out)
    columns = np.zeros((N, 8, 4))
    columns[:, 0, 0] = columns[:, 1, 1] = columns[:, 2, 2] = 1.0
    columns[:, 0, 2], columns[:, 1, 2] = out[0, 1] - out[:, 1], out[:, 0] - out[0, 0]
    columns[:, :5, 3], columns[:, 6, 3] = reach, 2.0 * out[:, 4] * reach[:, 3]
    used = np.isfinite(measured) & counted[:, None]
    used[:, [5, 7]] = False
    a = (columns * WEIGHT[None, :, None])[used]
    b = ((measured - out) * WEIGHT)[used]
    assert started(out, measured, WEIGHT, counted) == pytest.approx(np.linalg.lstsq(a, b, rcond=None)[0])


def projected(out: FloatArray, measured: FloatArray, counted: np.ndarray, starts: list[int],
              slopes: float = 0.0) -> tuple[FloatArray, ...]:  # fmt: skip
    values, start = np.empty((N, 8)), np.zeros((len(starts), 4))
    chi2, count = np.zeros(8), np.zeros(8, dtype=np.int64)
    begin = np.array(starts)
    project(out, measured, T, WEIGHT, begin, np.append(begin[1:], N), counted, True, slopes, values, start, chi2, count)
    return values, start, chi2, count


def test_a_wrong_start_of_each_segment_is_taken_out_of_all_channels() -> None:
    out = path(V, BEND)
    measured = out.copy()
    measured[:150] = moved(out, *START)[:150]
    values, start, chi2, count = projected(out, measured, np.ones(N, dtype=bool), [0, 150])
    assert start == pytest.approx(np.array([START, (0.0, 0.0, 0.0, 0.0)]), abs=1e-9)
    assert values == pytest.approx(np.zeros((N, 8)), abs=1e-9)
    assert chi2 == pytest.approx(np.zeros(8), abs=1e-9)
    assert count.tolist() == [N] * 8


@pytest.mark.parametrize("turns", [-2, 1, 3])
def test_whole_turns_of_the_heading_are_no_error(turns: int) -> None:
    out = path(V, BEND)
    measured = out.copy()
    measured[:, 2] += 2.0 * np.pi * turns + 0.01
    values, start, *_ = projected(out, measured, np.ones(N, dtype=bool), [0])
    assert np.abs(values[:, 2]).max() < 0.011
    assert abs(start[0, 2]) < 0.011


def test_an_error_that_no_start_explains_stays_and_counts_by_its_weight() -> None:
    out = path(V, BEND)
    measured = out.copy()
    measured[:, 5], measured[:, 7] = out[:, 5] + 0.3, out[:, 7] - 0.02
    measured[10, 7] = np.nan
    counted = np.ones(N, dtype=bool)
    counted[20:30] = False
    values, start, chi2, count = projected(out, measured, counted, [0])
    assert start == pytest.approx(np.zeros((1, 4)), abs=1e-12)
    assert values[counted, 5] == pytest.approx(0.3)
    assert np.isnan(values[20:30]).all()
    assert chi2[5] == pytest.approx(9.0 * (N - 10))
    assert chi2[7] == pytest.approx(4.0 * (N - 11))
    assert count.tolist() == [N - 10] * 7 + [N - 11]


def test_where_the_model_comes_to_rest_one_row_to_either_side_has_no_acceleration() -> None:
    v = np.where(T < 1.0, 5.0, 0.0)
    out = path(v, np.zeros(N))
    stops = [i for i in range(N) if _stops(out, i, 0, N)]
    assert stops == [99, 100, 101]
    assert [i for i in range(N) if _stops(out, i, 100, N)] == []
    assert [i for i in range(100) if _stops(out, i, 0, 100)] == []
    values, *_ = projected(out, out + 0.01, np.ones(N, dtype=bool), [0])
    assert np.flatnonzero(np.isnan(values[:, 5])).tolist() == [99, 100, 101]
    starts = path(np.where(T < 1.0, 0.0, 5.0), np.zeros(N))
    assert not any(_stops(starts, i, 0, N) for i in range(N))


FLAT = path(V, BEND)
EVERY = np.ones(N, dtype=bool)


def on_a_slope(at: int, push: float) -> FloatArray:
    """What a car shows that is pushed by a slope [m/s^2] at one knot, and less up to its neighbours: a second drive.
    Its wheels and its accelerometer do as before."""
    apart = (N - 1) * STEP / (KNOTS - 1)
    pushes = push * np.maximum(0.0, 1.0 - np.abs(T - at * apart) / apart)
    faster = np.concatenate([[0.0], np.cumsum(0.5 * STEP * (pushes[1:] + pushes[:-1]))])
    found = path(V + faster, BEND)
    found[:, 5] = FLAT[:, 5]
    return found


@pytest.mark.parametrize("at", range(KNOTS))
def test_a_slope_at_a_knot_moves_and_turns_the_car_like_a_second_drive(at: int) -> None:
    reach = np.zeros((N, 5, 1 + KNOTS))
    _reach(FLAT, T, 0, N, True, 1 + at, reach)
    gain = (on_a_slope(at, 1e-5) - on_a_slope(at, -1e-5))[:, :5] / 2e-5
    assert reach[:, :, 1 + at] == pytest.approx(gain, abs=3e-4)
    assert np.abs(gain[-1, 3]) > 0.5


@pytest.mark.parametrize("at", range(KNOTS))
def test_nine_tenths_of_a_slope_are_taken_out_and_what_the_accelerometer_shows_stays(at: int) -> None:
    """What stays of the speed is what a tenth of the slope leaves, less the start that suits it best."""
    measured = on_a_slope(at, 0.1)
    measured[:, 5] += 0.02
    flat, *_ = projected(FLAT, measured, EVERY, [0])
    values, start, *_ = projected(FLAT, measured, EVERY, [0], slopes=1.0)
    assert np.abs(flat[:, 3]).max() > 0.03
    assert np.abs(values[:, 3]).max() == pytest.approx((1.0 - TAKEN_OUT) * np.abs(flat[:, 3]).max(), rel=0.2)
    assert values[:, 5] == pytest.approx(0.02)
    assert np.abs(start).max() < 0.02


def test_a_slope_is_believed_as_far_as_slopes_are_usual() -> None:
    measured = on_a_slope(1, 0.1)
    left = [np.abs(projected(FLAT, measured, EVERY, [0], slopes=s)[0][:, 3]).max() for s in (1e-4, 0.01, 1.0)]
    assert left[0] > 2.0 * left[1] > 2.0 * left[2]


def test_on_hills_ways_do_not_count_from_where_car_or_model_is_slow_on() -> None:
    out = path(np.where(T < 1.0, 5.0, 0.0), np.zeros(N))
    measured = out.copy()
    measured[:, 3] = np.where(T < 0.8, 5.0, 0.29)
    values, *_ = projected(out, measured, EVERY, [0], slopes=0.1)
    assert np.isfinite(values[:80, [0, 1, 3]]).all()
    assert np.isnan(values[80:, [0, 1, 3]]).all()
    assert np.isfinite(values[:, [2, 4]]).all()
    assert np.isnan(values[100:, 5]).all()  # the accelerometer of a car that is held shows the hill
    measured[:, 3] = np.where(T < 0.8, 5.0, 0.31)
    values, *_ = projected(out, measured, EVERY, [0], slopes=0.1)
    assert np.flatnonzero(np.isnan(values[:, 3]))[0] == 100


def test_on_hills_a_start_that_no_row_tells_stays_as_it_was_measured() -> None:
    """A wrong yaw rate of a car that stands would ask for any speed."""
    out = path(np.where(T < STEP / 2.0, 0.0, 0.25), np.full(N, 0.01))
    measured = out.copy()
    measured[:, 4] += 0.05
    _, start, *_ = projected(out, measured, EVERY, [0], slopes=0.1)
    assert abs(start[0, 3]) < 1.0


@pytest.mark.parametrize("slopes", [0.0, 0.1])
def test_a_segment_is_judged_among_others_as_it_is_alone(slopes: float) -> None:
    """On hills too, where one segment ends at rest and the next one is a single row."""
    v = np.where((T > 0.8) & (T < 1.2), 0.0, V)
    out = path(v, BEND)
    measured = out + np.random.default_rng(6).normal(size=(N, 8)) / WEIGHT
    starts = [0, 110, 111, 130]
    values, start, chi2, count = projected(out, measured, EVERY, starts, slopes=slopes)
    assert np.isfinite(start).all()
    total = np.zeros(8)
    for k, (first, end) in enumerate(zip(starts, [*starts[1:], N], strict=True)):
        own, own_start = np.empty((end - first, 8)), np.zeros((1, 4))
        squares, rows = np.zeros(8), np.zeros(8, dtype=np.int64)
        project(out[first:end], measured[first:end], T[first:end], WEIGHT, np.array([0]), np.array([end - first]),
                EVERY[first:end], True, slopes, own, own_start, squares, rows)  # fmt: skip
        assert values[first:end] == pytest.approx(own, rel=1e-9, abs=1e-9, nan_ok=True), k
        assert start[k] == pytest.approx(own_start[0], rel=1e-6, abs=1e-9), k
        total, count = total + squares, count - rows
    assert chi2 == pytest.approx(total)
    assert not count.any()


def test_on_hills_a_start_speed_is_believed_to_three_tenths_of_a_metre_a_second() -> None:
    """One row that shows 0.1 m/s more by a sensor of 0.04 m/s: the weighted mean of that and of none by 0.3 m/s."""
    out = path(V, np.zeros(N))  # straight on, where no turn tells the speed
    measured = out.copy()
    measured[0, 3] += 0.1
    first = np.arange(N) == 0
    _, start, *_ = projected(out, measured, first, [0], slopes=0.1)
    assert start[0] == pytest.approx([0.0, 0.0, 0.0, 0.1 * 625.0 / (625.0 + 1.0 / 0.09)], abs=1e-9)
    _, start, *_ = projected(out, measured, first, [0])
    assert start[0, 3] == pytest.approx(0.1)
