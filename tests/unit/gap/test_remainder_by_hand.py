"""A remainder that lasts, against the covariance matrix that it is; and how long it lasts, on series made by hand."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.gap.diagnose.lasting_remainder import (
    LONGEST,
    _fallen,
    _innovations,
    measured_memory,
    rounded_imitation,
)
from pytest_dvp.logs.log_contents import FloatArray

N = 12
BEGINS = np.isin(np.arange(N), [0, 7])


def news(rest: FloatArray, noise: float, levels: FloatArray, kept: float) -> FloatArray:
    """Residuals times the inverse of the Cholesky factor of their covariance, each piece for itself (Aitken 1935)."""
    out = np.zeros(N)
    for piece in (range(7), range(7, N)):
        state = np.zeros((len(piece), len(piece)))
        for a, i in enumerate(piece):
            grown = (1.0 - kept**2) * levels[i] ** 2 if a else 0.0
            state[a, a] = kept**2 * state[a - 1, a - 1] + grown if a else levels[i] ** 2
            for b in range(a):
                state[a, b] = state[b, a] = kept ** (a - b) * state[b, b]
        known = np.isfinite(rest[piece])
        rows = np.array(piece)[known]
        whole = state[np.ix_(known, known)] + noise**2 * np.eye(len(rows))
        out[rows] = np.linalg.solve(np.linalg.cholesky(whole), rest[rows])
    return out


@pytest.mark.parametrize("hole", [(), (3, 4), (0, 7), (6, 11)])
def test_the_news_are_what_least_squares_with_the_whole_covariance_has(hole: tuple[int, ...]) -> None:
    rng = np.random.default_rng(5)
    rest, levels = rng.normal(size=(N, 8)), rng.uniform(0.2, 3.0, size=(N, 8))
    noise, kept = rng.uniform(0.3, 2.0, 8), rng.uniform(0.2, 0.99, 8)
    rest[list(hole), :] = np.nan
    noise[2], noise[5] = np.inf, 0.0
    found = _innovations(rest, noise, levels, kept, BEGINS).reshape(N, 8)
    assert not found[:, [2, 5]].any()  # not judged
    for k in (0, 1, 3, 4, 6, 7):
        assert found[:, k] == pytest.approx(news(rest[:, k], noise[k], levels[:, k], kept[k]), abs=1e-12)


def test_correlation_is_followed_to_1_over_e_of_that_of_neighbours() -> None:
    """A triangle of 2 m - 1 samples is the correlation of m equal ones with themselves: m - k pairs at a shift of k.

    The mean over pairs takes the falling number of pairs out: m ones and m noughts have m - k of 2 m - k products.
    """
    m = 20
    rest = np.append(np.ones(m), np.zeros(m))
    mean = [(m - k) / (2 * m - k) if k < m else 0.0 for k in range(2 * m)]
    expected = next(k for k in range(1, 2 * m) if mean[k] < mean[1] / np.e)
    starts = np.array([0])
    assert _fallen(rest, starts) == expected
    assert _fallen(np.tile(rest, 2), np.array([0, 2 * m])) == expected  # no pair reaches over a start
    gone = rest.copy()
    gone[m:] = np.nan
    assert _fallen(gone, starts) == expected


def test_a_series_without_memory_has_none_and_one_that_never_falls_has_the_longest() -> None:
    assert _fallen(np.tile([1.0, -1.0], 30), np.array([0])) == 0
    assert _fallen(np.ones(LONGEST + 50), np.array([0])) == LONGEST
    assert _fallen(np.array([1.0, 1.0, 0.0, 0.0]), np.array([0])) == 2  # 2/4, 1/3, 0/2


def test_the_memory_is_the_longest_of_the_logs_in_seconds() -> None:
    short, long = np.append(np.ones(4), np.zeros(36)), np.append(np.ones(20), np.zeros(20))
    k, other = CHANNELS.index("v"), CHANNELS.index("yaw")
    parts = []
    for step, series in ((0.1, short), (0.0213, long), (0.1, short)):
        rest = np.zeros((40, 8))
        rest[:, k] = series
        rest[:, other] = np.tile([1.0, -1.0], 20)
        parts.append((step * np.arange(40), rest, np.array([0])))
    remainder = {"yaw": {"all": 0.1}, "v": {"all": 0.1}}
    lags = [_fallen(series, np.array([0])) for series in (short, long)]
    assert lags[0] * 0.1 < lags[1] * 0.0213
    assert measured_memory(parts, remainder) == {"v": float(f"{lags[1] * 0.0213:.3g}")}
    parts[1] = (0.1 * np.arange(40), *parts[1][1:])
    assert measured_memory(parts, remainder) == {"v": float(f"{lags[1] * 0.1:.3g}")}
    assert measured_memory(parts, {"yaw": {"all": 0.1}}) == {}


def test_what_is_imitated_has_three_digits() -> None:
    found = {("drag", "k"): [3.0, 4.0], ("drag", "c"): [1.0, -1.0], ("lag", "tau"): [0.12345]}
    assert rounded_imitation(found) == {"drag": {"k": 3.54, "c": 1.0}, "lag": {"tau": 0.123}}
