"""ISO/TS 18571 ratings against their closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.gap.compare.iso18571 import LONGEST, score

DT = 0.01
T = np.arange(0.0, 10.0, DT)
WAVE = np.sin(T) * np.exp(-0.1 * T)


def test_identical_signals_rate_one() -> None:
    found = score(WAVE, WAVE, DT)
    assert (found.corridor, found.phase, found.magnitude, found.slope, found.total) == pytest.approx((1.0,) * 5)


def test_corridor_is_one_inside_and_zero_outside() -> None:
    constant = np.ones(200)
    assert score(constant, constant + 0.049, DT).corridor == 1.0
    assert score(constant, constant + 0.501, DT).corridor == 0.0


def test_corridor_falls_with_the_square_in_between() -> None:
    constant = np.ones(200)
    assert score(constant, constant + 0.3, DT).corridor == pytest.approx(((0.5 - 0.3) / (0.5 - 0.05)) ** 2)


@pytest.mark.parametrize("late", [10, 50, 100])
def test_phase_falls_linearly_with_the_shift(late: int) -> None:
    pulse = np.exp(-(((T - 4.0) / 0.3) ** 2))
    moved = np.exp(-(((T - 4.0 - late * DT) / 0.3) ** 2))
    assert score(pulse, moved, DT).phase == pytest.approx(1.0 - late / (0.2 * len(T)))
    assert score(moved, pulse, DT).phase == pytest.approx(1.0 - late / (0.2 * len(T)))


def test_shift_alone_costs_neither_magnitude_nor_slope() -> None:
    pulse = np.exp(-(((T - 4.0) / 0.3) ** 2))
    moved = np.exp(-(((T - 4.5) / 0.3) ** 2))
    found = score(pulse, moved, DT)
    assert (found.magnitude, found.slope) == pytest.approx((1.0, 1.0), abs=1e-6)


@pytest.mark.parametrize("gain", [0.8, 1.1, 1.5])
def test_slope_falls_linearly_with_the_gain(gain: float) -> None:
    assert score(WAVE, gain * WAVE, DT).slope == pytest.approx(1.0 - abs(gain - 1.0) / 2.0)


def test_magnitude_of_a_scaled_ramp_is_that_of_its_warping() -> None:
    # A plateau cannot be warped away: its relative error of 0.2 rates 1 - 0.2 / 0.5
    plateau = np.ones(300)
    assert score(plateau, 1.2 * plateau, DT).magnitude == pytest.approx(0.6)


def test_total_is_the_weighted_sum() -> None:
    found = score(WAVE, 1.3 * WAVE + 0.02, DT)
    assert found.total == pytest.approx(0.4 * found.corridor + 0.2 * (found.phase + found.magnitude + found.slope))


def test_warping_is_the_cheapest_path_of_the_plain_recursion() -> None:
    rng = np.random.default_rng(5)
    a, b = np.cumsum(rng.normal(size=60)), np.cumsum(rng.normal(size=60))
    from pytest_dvp.gap.compare.iso18571 import _warp

    n, band = len(a), 6
    cost = np.full((n, n), np.inf)
    paths: dict[tuple[int, int], float] = {}
    for i in range(n):
        for j in range(max(0, i - band), min(n, i + band + 1)):
            before = [(cost[p], p) for p in ((i - 1, j - 1), (i - 1, j), (i, j - 1)) if min(p) >= 0]
            best, where = min(before, default=(0.0, (-1, -1)), key=lambda item: item[0])
            cost[i, j] = best + (a[i] - b[j]) ** 2
            paths[i, j] = abs(a[i] - b[j]) + paths.get(where, 0.0)
    assert _warp(a, b, band)[0] == pytest.approx(paths[n - 1, n - 1])


def test_long_signals_are_warped_in_pieces_and_rate_alike() -> None:
    t = np.arange(5 * LONGEST) * DT
    long = np.sin(t)
    assert score(long, 1.2 * long, DT).magnitude == pytest.approx(
        score(long[:LONGEST], 1.2 * long[:LONGEST], DT).magnitude, abs=0.02
    )


def test_too_short_signals_are_refused() -> None:
    with pytest.raises(ValueError, match="length"):
        score(WAVE[:5], WAVE[:5], DT)
