"""Noise floor and coloured noise by their definitions: strides, quanta, correlations, weights of neighbours."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

from pytest_dvp.gap.compare import coloured_noise
from pytest_dvp.gap.compare.coloured_noise import ORDER, Whitening, _correlation, _level, _levinson, _runs, first_rows
from pytest_dvp.gap.compare.compare import noise_floor
from pytest_dvp.gap.compare.noise_floor import _quantum, _strides, _swing, _white_level, sigma
from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.logs.log_contents import FloatArray

STEP = 1.0 / 64.0


def white(n: int, seed: int = 1) -> FloatArray:
    return np.random.default_rng(seed).standard_normal(n)


def test_the_level_of_white_noise_is_its_standard_deviation() -> None:
    """The third difference of white noise has 1 + 9 + 9 + 1 = 20 times its variance."""
    level, smooth = _white_level(0.3 * white(200_000), 1)
    assert level == pytest.approx(0.3, rel=0.01)
    assert not smooth


def differences(stride: int, window: int) -> FloatArray:
    """What the third difference does to white noise behind a moving mean, as the weights of its samples."""
    third = np.zeros(3 * stride + 1)
    third[::stride] = -1.0, 3.0, -3.0, 1.0
    return np.convolve(third, np.ones(window) / window)


@pytest.mark.parametrize("window", [2, 9, 14])
def test_noise_of_a_moving_mean_is_told_at_the_stride_at_which_it_looks_white(window: int) -> None:
    """White: neighbouring differences are alike by -0.6 or less, and none come back by less than -0.25 later."""
    for stride in (1, 2, 3, 4, 6, 8, 11):
        weights = differences(stride, window)
        alike = np.correlate(weights, weights, "full")[len(weights) - 1 :] / (weights @ weights)
        alike = np.append(alike, np.zeros(80))
        if alike[stride] <= -0.6 and alike[4 * stride : 4 * stride + 32].min() >= -0.25:
            break
    level, smooth = _white_level(np.convolve(white(100_000), np.ones(window) / window, mode="valid"), 12)
    assert smooth is (stride > 1)
    assert level == pytest.approx(float(np.sqrt(weights @ weights / 20.0)), rel=0.02)


def test_noise_that_never_looks_white_has_the_level_of_its_first_differences() -> None:
    y = np.cumsum(np.cumsum(white(5000)))
    level, smooth = _white_level(y, 3)
    d = np.diff(y, 3)
    assert smooth
    assert level == pytest.approx(1.482602 * float(np.median(np.abs(d))) / 20.0**0.5)


@pytest.mark.parametrize(("rows", "pieces"), [(400, 3), (400, 2), (8, 3), (5, 3)])
def test_what_a_line_through_each_standstill_took_out_is_added_again(
    rows: int, pieces: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Weights of neighbours of 0.5 in all and a gain of 1 leave a quarter of the samples as independent ones. A level
    and a slope of each piece took two of them out, at most half of all. Below four the noise counts as white."""
    weights, gain = np.zeros((ORDER + 1, ORDER)), np.ones(ORDER + 1)
    weights[ORDER, :2] = 0.3, 0.2
    monkeypatch.setattr(
        coloured_noise, "_runs", lambda t, still: [slice(k * rows, (k + 1) * rows) for k in range(pieces)]
    )
    monkeypatch.setattr(coloured_noise, "_level", lambda t, y: y)
    monkeypatch.setattr(coloured_noise, "_correlation", lambda given: (np.ones(4), 0.3))
    monkeypatch.setattr(coloured_noise, "_levinson", lambda correlation: (weights, gain))
    n = 1300
    sigma_given = np.full(len(CHANNELS), np.inf)
    sigma_given[3] = 0.2
    found = coloured_noise.whitening(0.02 * np.arange(n), np.zeros((n, len(CHANNELS))), sigma_given)
    samples = 0.25 * rows * pieces
    if samples < 4.0:
        assert (found.sigma[3], found.independent[3]) == (0.2, 1.0)
    else:
        assert found.sigma[3] == pytest.approx(0.3 / max(1.0 - 2.0 * pieces / samples, 0.5) ** 0.5)
        assert found.independent[3] == 0.25
        assert (found.weights[3] == weights).all()


def test_a_constant_has_no_level() -> None:
    assert _white_level(np.full(100, 7.0), 4) == (0.0, True)


@pytest.mark.parametrize(("reach", "strides"), [(1, [1]), (2, [1, 2]), (3, [1, 2, 3]), (12, [1, 2, 3, 4, 6, 8, 11]),
                                               (0, []), (15, [1, 2, 3, 4, 6, 8, 11, 15])])  # fmt: skip
def test_strides_grow_by_two_fifths(reach: int, strides: list[int]) -> None:
    assert _strides(reach) == strides


def test_swing_is_how_far_a_signal_leaves_a_straight_line() -> None:
    """Of y = t^2 the second difference over 2 x 5 samples is 2 x 25 everywhere, so its range is 0; a sine of a period
    of 20 samples, over 2 x 10 of them, goes from -4 to 4."""
    assert _swing(np.arange(100.0), np.arange(100.0) ** 2, 5) == 0.0
    wave = np.sin(2.0 * np.pi * np.arange(4001) / 20.0)
    assert _swing(np.arange(float(len(wave))), wave, 10) == pytest.approx(8.0, rel=0.01)
    jumps = np.zeros(10_000)
    jumps[5000] = 1.0  # one sample in ten thousand is no habit
    assert _swing(np.arange(float(len(jumps))), jumps, 5) == 0.0
    assert _swing(np.arange(10.0), np.arange(10.0), 5) == 0.0


def test_a_quantised_signal_has_the_step_of_its_grid() -> None:
    y = np.round(3.0 * np.sin(0.05 * np.arange(2000)) / 0.1) * 0.1
    assert _quantum(y) == pytest.approx(0.1)
    assert _quantum(np.sin(0.05 * np.arange(2000))) == 0.0
    assert _quantum(np.repeat([0.0, 1.0, 2.0, 1.0], 2)) == 0.0  # too few jumps


def test_a_steady_climb_is_no_grid_unless_a_tenth_of_its_changes_differ() -> None:
    climb = np.full(1000, 0.2)
    climb[::20] = 0.1
    assert _quantum(np.cumsum(climb)) == 0.0
    climb[::8] = 0.1
    assert _quantum(np.cumsum(climb)) == pytest.approx(0.1)


def test_a_signal_that_mostly_stays_is_a_grid() -> None:
    changes = np.zeros(1000)
    changes[::20], changes[10::20] = 0.5, -0.5
    assert _quantum(np.cumsum(changes)) == pytest.approx(0.5)


def test_sixteen_samples_have_a_noise_floor_and_fifteen_have_not() -> None:
    t, y = STEP * np.arange(16), white(16)
    assert np.isfinite(sigma(t, y))
    assert np.isnan(sigma(t[:15], y[:15]))
    y[3] = np.nan
    assert np.isnan(sigma(t, y))
    assert np.isnan(sigma(np.zeros(16), white(16)))


@pytest.mark.parametrize(("filtered", "share"), [(False, 0.0002), (True, 0.005)])
def test_a_floor_is_a_share_of_how_far_the_signal_bends_within_a_second(filtered: bool, share: float) -> None:
    """A little white noise on a slow wave. Half a second is 32 samples: 2 A (1 - cos(32 w)) to either side."""
    t = STEP * np.arange(64_000)
    w = 0.01
    y = 5.0 * np.sin(w * np.arange(64_000)) + 1e-4 * white(64_000)
    swing = 2.0 * 2.0 * 5.0 * (1.0 - np.cos(32 * w))
    assert sigma(t, y, filtered=filtered) == pytest.approx(share * swing, rel=0.01)


def test_the_step_of_a_grid_over_the_root_of_twelve_is_a_floor() -> None:
    t = STEP * np.arange(6400)
    y = np.round(np.sin(0.003 * np.arange(6400)) / 0.25) * 0.25
    assert sigma(t, y) == pytest.approx(0.25 / np.sqrt(12.0), rel=0.05)


def test_a_residual_lowers_the_noise_and_never_raises_it() -> None:
    t = STEP * np.arange(6400)
    y, small = 0.1 * white(6400, 1), 0.02 * white(6400, 2)
    assert sigma(t, y, small) == pytest.approx(0.02, rel=0.05)
    assert sigma(t, y, 5.0 * y) == pytest.approx(sigma(t, y))
    few = np.full(6400, np.nan)
    few[:15] = small[:15]
    assert sigma(t, y, few) == pytest.approx(0.1, rel=0.05)


def test_no_channel_is_better_than_the_best_sensor_of_a_car() -> None:
    """1 cm of satellites with corrections, 0.0005 rad and rad/s of a fibre-optic gyro, 1 cm/s of wheel encoders."""
    t = STEP * np.arange(640)
    found = noise_floor(t, np.zeros((640, 8)), CHANNELS)
    assert found.tolist() == [0.01, 0.01, 0.0005, 0.01, 0.0005, 0.02, 0.02, 0.001]
    part = noise_floor(t, np.full((640, 8), np.nan), ["v", "ax"])
    assert np.isinf(part).all()
    assert np.isfinite(noise_floor(t, np.zeros((640, 8)), ["v"])).tolist() == [k == 3 for k in range(8)]


def test_only_position_and_heading_count_as_filtered() -> None:
    t = STEP * np.arange(6400)
    wave = 50.0 * np.sin(0.01 * np.arange(6400))[:, None] + 1e-3 * white(6400 * 8).reshape(6400, 8)
    found = noise_floor(t, wave, CHANNELS)
    swing = 2.0 * 2.0 * 50.0 * (1.0 - np.cos(32 * 0.01))
    assert found[:3] == pytest.approx(0.005 * swing, rel=0.02)
    assert found[3] == pytest.approx(max(0.0002 * swing, 0.01), rel=0.02)


def test_a_stretch_has_more_than_eight_times_as_many_rows_as_neighbours_count() -> None:
    t = STEP * np.arange(400)
    rows = np.zeros(400, dtype=bool)
    rows[10:34], rows[50:75], rows[380:400], rows[300:325] = True, True, True, True
    assert _runs(t, rows) == [slice(50, 75), slice(300, 325)]
    assert _runs(t, np.ones(400, dtype=bool)) == [slice(0, 400)]


def test_a_gap_parts_a_stretch() -> None:
    t = STEP * np.arange(100)
    t[40:] += 0.51 * STEP
    assert _runs(t, np.ones(100, dtype=bool)) == [slice(0, 40), slice(40, 100)]
    t[40:] -= 0.02 * STEP
    assert _runs(t, np.ones(100, dtype=bool)) == [slice(0, 100)]


def test_rows_without_a_neighbour_are_starts_and_those_after_a_gap() -> None:
    t = STEP * np.array([0.0, 1.0, 2.0, 3.6, 4.6, 6.0])
    assert np.flatnonzero(first_rows(t, np.array([0, 4, 6]))).tolist() == [0, 3, 4]
    assert first_rows(t[:1], np.array([0])).tolist() == [True]


def test_the_level_of_a_stretch_is_what_is_left_beside_a_line() -> None:
    t = 3.0 + STEP * np.arange(50)
    y = white(50)
    line = np.polyval(np.polyfit(t, y, 1), t)
    assert _level(t, y) == pytest.approx(y - line)
    assert _level(t, y + 7.0 - 40.0 * t) == pytest.approx(y - line)


def test_a_correlation_is_the_mean_product_of_samples_so_many_steps_apart() -> None:
    pieces = [lfilter([1.0], [1.0, -0.8], white(n, n)) for n in (70, 40)]
    found, level = _correlation(pieces)
    square = np.concatenate(pieces) @ np.concatenate(pieces) / 110.0
    for lag in range(ORDER + 1):
        products = np.concatenate([p[lag:] * p[: len(p) - lag] for p in pieces])
        assert found is not None
        assert found[lag] == pytest.approx(products.mean() / square)
    assert level == pytest.approx(np.sqrt(square))


@pytest.mark.parametrize(("n", "told"), [(99, False), (100, True)])
def test_a_hundred_samples_tell_a_correlation(n: int, told: bool) -> None:
    found, level = _correlation([np.sin(0.3 * np.arange(n))])
    assert (found is not None) is told
    assert (level > 0.0) is told
    assert _correlation([np.zeros(n)]) == (None, 0.0)


@pytest.mark.parametrize(("correlation", "told"), [(0.36, True), (0.34, False)])
def test_neighbours_alike_by_more_than_0_35_are_coloured(correlation: float, told: bool) -> None:
    """cos(w i) over whole periods: neighbours are alike by cos(w), but for the one pair that is missing."""
    w = 2.0 * np.pi * round(np.arccos(correlation) * 20_000 / (2.0 * np.pi)) / 20_000
    found, _ = _correlation([np.cos(w * np.arange(20_000))])
    assert (found is not None) is told


def test_weights_of_neighbours_solve_the_equations_of_yule_and_walker() -> None:
    correlation = np.array([1.0, 0.8, 0.5, 0.35])
    weights, gain = _levinson(correlation)
    for p in range(ORDER + 1):
        expected = solve_toeplitz(correlation[:p], correlation[1 : p + 1]) if p else np.zeros(0)
        assert weights[p, :p] == pytest.approx(expected)
        assert not weights[p, p:].any()
        assert gain[p] ** 2 == pytest.approx(1.0 - expected @ correlation[1 : p + 1])


def test_neighbours_that_are_the_same_leave_a_little() -> None:
    weights, gain = _levinson(np.ones(4))
    assert weights[1, 0] == pytest.approx(0.999)
    assert gain[1] == pytest.approx(np.sqrt(1.0 - 0.999**2))


def test_of_each_sample_what_its_known_neighbours_say_is_taken() -> None:
    weights, gain = _levinson(np.array([1.0, 0.7, 0.55, 0.3]))
    whitening = Whitening(np.full(8, np.inf), np.zeros((8, 4, 3)), np.ones((8, 4)), np.ones(8))
    whitening.sigma[3], whitening.sigma[6] = 0.5, 0.2
    whitening.weights[3], whitening.gain[3] = weights, gain
    values = np.full((9, 8), np.nan)
    values[:, 3], values[:, 5], values[:, 6] = white(9), 9.0, 1.0
    values[6, 3] = np.nan
    first = np.isin(np.arange(9), [0, 2])
    found = whitening.of(values, first).reshape(9, 8)
    y = values[:, 3]
    known = [0, 1, 0, 1, 2, 3, 0, 0, 1]
    for i, p in enumerate(known):
        expected = (y[i] - sum(weights[p, j] * y[i - 1 - j] for j in range(p))) / (0.5 * gain[p]) if i != 6 else 0.0
        assert found[i, 3] == pytest.approx(expected)
    assert found[:, 6] == pytest.approx(5.0)
    assert not found[:, [0, 1, 2, 4, 5, 7]].any()
    assert whitening.scaled(np.full(8, 2.0)).of(values, first).reshape(9, 8)[:, 5] == pytest.approx(4.5)
