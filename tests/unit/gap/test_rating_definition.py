"""ISO/TS 18571 by its definitions, computed the slow way: shift by correlation, slope by differences, warping."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from pytest_dvp.gap.compare.iso18571 import LONGEST, _corridor, _rated, _shift, _slope, _warp, _warped, score
from pytest_dvp.logs.log_contents import FloatArray


def best_shift(reference: FloatArray, curve: FloatArray) -> int:
    """The shift of the best correlation of what overlaps, of at most a fifth of the length."""
    n = len(reference)
    found = {}
    for late in range(-int(0.2 * n), int(0.2 * n) + 1):
        a, b = (reference[: n - late], curve[late:]) if late >= 0 else (reference[-late:], curve[:late])
        found[late] = float(np.corrcoef(a, b)[0, 1])
    return max(found, key=lambda late: found[late])


@pytest.mark.parametrize("seed", range(12))
def test_the_shift_is_that_of_the_best_correlation_of_what_overlaps(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(20, 90))
    base = np.cumsum(rng.normal(size=2 * n)) + 40.0
    late = int(rng.integers(-n // 6, n // 6 + 1))
    reference = base[n // 2 : n // 2 + n]
    curve = base[n // 2 - late : n // 2 - late + n] + 0.05 * rng.normal(size=n)
    assert _shift(reference, curve) == best_shift(reference, curve)
    noise = rng.normal(size=n)
    assert _shift(reference, noise) == best_shift(reference, noise)


def test_a_signal_that_does_not_vary_has_no_shift() -> None:
    assert _shift(np.full(50, 3.0), np.sin(np.arange(50.0))) == 0
    assert _shift(np.sin(np.arange(50.0)), np.full(50, 3.0)) == 0


@pytest.mark.parametrize(("size", "late"), [(1.0, 3), (1e-5, 3), (1e-7, 0)])
def test_what_varies_by_a_millionth_of_the_other_does_not_vary(size: float, late: int) -> None:
    """Squares count, from 1e-12 of the larger sum on: beside it the rest is rounding, whichever of the two is small."""
    curve = size * np.sin(2.0 * np.pi * (np.arange(200) - 3.0) / 20.0)
    wave = np.sin(2.0 * np.pi * np.arange(200) / 20.0)
    assert _shift(wave, curve) == late
    assert _shift(curve, wave) == -late


def test_of_equally_good_shifts_the_least_counts() -> None:
    wave = np.sin(2.0 * np.pi * np.arange(200) / 20.0)  # repeats each 20 samples; 40 are searched
    assert _shift(wave, wave) == 0
    assert _shift(wave, np.sin(2.0 * np.pi * (np.arange(200) - 3.0) / 20.0)) == 3
    assert _shift(wave, np.sin(2.0 * np.pi * (np.arange(200) + 4.0) / 20.0)) == -4


def test_a_slope_is_the_mean_of_nine_differences_and_of_fewer_at_the_ends() -> None:
    y = np.random.default_rng(1).normal(size=40)
    raw = np.gradient(y, 0.02)
    expected = [raw[i - k : i + k + 1].mean() for i in range(40) for k in [min(i, 39 - i, 4)]]
    assert _slope(y, 0.02) == pytest.approx(expected)


@pytest.mark.parametrize(("error", "norm", "rated"),
                         [(0.0, 2.0, 1.0), (1.0, 2.0, 0.0), (0.25, 2.0, 0.75), (3.0, 2.0, 0.0),
                                                     (0.0, 0.0, 1.0), (0.1, 0.0, 0.0)])  # fmt: skip
def test_an_error_rates_by_its_share_of_the_norm(error: float, norm: float, rated: float) -> None:
    assert _rated(error, norm, 0.5, 1) == pytest.approx(rated)
    assert _rated(error, norm, 0.5, 2) == pytest.approx(rated**2)


def test_a_corridor_is_a_twentieth_to_a_half_of_the_largest_reference() -> None:
    reference = np.array([2.0, -4.0, 1.0, 0.0])  # full marks to 0.2, none from 2.0 on
    curve = reference + np.array([0.19, -2.01, 1.1, -0.65])
    assert _corridor(reference, curve) == pytest.approx((1.0 + 0.0 + 0.5**2 + 0.75**2) / 4.0)


def warped_slowly(a: FloatArray, b: FloatArray, band: int) -> tuple[float, float]:
    """Dynamic time warping by its recursion, squared cost, inside a band; ties by the diagonal, then up, then left."""
    n = len(a)
    best: dict[tuple[int, int], tuple[float, float, float]] = {}
    for i in range(n):
        for j in range(max(0, i - band), min(n, i + band + 1)):
            before = [best[p] for p in ((i - 1, j - 1), (i - 1, j), (i, j - 1)) if p in best]
            cost, error, norm = min(before, key=lambda one: one[0], default=(0.0, 0.0, 0.0))
            best[i, j] = cost + (a[i] - b[j]) ** 2, error + abs(a[i] - b[j]), norm + abs(a[i])
    return best[n - 1, n - 1][1:]


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("band", [1, 3, 25])
def test_warping_is_the_cheapest_path_in_its_band(seed: int, band: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = np.cumsum(rng.normal(size=25)) + 2.0, np.cumsum(rng.normal(size=25))
    assert _warp(a, b, band) == pytest.approx(warped_slowly(a, b, band))


@pytest.mark.parametrize(("n", "edges"), [(1024, [0, 1024]), (1025, [0, 512, 1025]), (2048, [0, 1024, 2048]),
                                          (2049, [0, 683, 1366, 2049])])  # fmt: skip
def test_pieces_are_of_equal_length_and_not_longer_than_1024(n: int, edges: list[int]) -> None:
    rng = np.random.default_rng(n)
    a = np.cumsum(rng.normal(size=n))
    b = a + 0.3 * rng.normal(size=n)
    parts = [_warp(a[i:j], b[i:j], int(0.1 * (j - i))) for i, j in itertools.pairwise(edges)]
    assert _warped(a, b) == pytest.approx(tuple(np.sum(parts, axis=0)))
    assert LONGEST == 1024


@pytest.mark.parametrize(("late", "error"), [(10, 0.0), (11, 2.0)])
def test_a_sample_is_met_at_most_a_tenth_of_the_length_later(late: int, error: float) -> None:
    """A pulse of one sample among 100; one that no other meets lies beside nothing, and so does the other one."""
    a, b = np.zeros(100), np.zeros(100)
    a[40] = b[40 + late] = 1.0
    assert _warped(a, b) == pytest.approx((error, 1.0))


def test_a_band_has_at_least_one_sample() -> None:
    a, b = np.array([0.0, 5.0, 5.0, 1.0]), np.array([0.0, 0.0, 5.0, 1.0])
    assert _warped(a, b) == (0.0, 11.0)


@pytest.mark.parametrize("late", [-15, 0, 12])
def test_ratings_follow_from_the_parts(late: int) -> None:
    """A fifth of 200 samples is the largest shift. What overlaps is then rated as it is, shifted back."""
    rng = np.random.default_rng(7)
    t = np.arange(300)
    base = np.sin(0.05 * t) + 0.3 * np.sin(0.021 * t)
    reference, curve = base[50:250], 1.1 * base[50 - late : 250 - late] + 0.001 * rng.normal(size=200)
    found = score(reference, curve, 0.1)
    assert found.phase == pytest.approx(1.0 - abs(late) / 40.0)
    a, b = (reference[: 200 - late], curve[late:]) if late >= 0 else (reference[-late:], curve[:late])
    error, norm = warped_slowly(a, b, int(0.1 * len(a)))
    assert found.magnitude == pytest.approx(1.0 - error / norm / 0.5)
    slopes = [np.convolve(np.gradient(one, 0.1), np.ones(9) / 9.0, mode="valid") for one in (a, b)]
    assert found.slope == pytest.approx(
        1.0 - np.abs(slopes[1] - slopes[0]).sum() / np.abs(slopes[0]).sum() / 2.0, abs=0.01
    )
    assert found.corridor == _corridor(reference, curve)


@pytest.mark.parametrize(("n", "m"), [(9, 9), (20, 19), (19, 20)])
def test_signals_of_different_length_or_below_ten_samples_are_refused(n: int, m: int) -> None:
    with pytest.raises(ValueError, match=f"found {n} and {m}"):
        score(np.arange(float(n)), np.arange(float(m)), 0.1)
    assert score(np.arange(10.0), np.arange(10.0), 0.1).total == pytest.approx(1.0)
