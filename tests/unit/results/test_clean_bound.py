"""Bounds beyond clean drives keep the rate that they state, for tails of several kinds."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.mutation.clean_bound import lower_bound, upper_bound

RATE = 1e-4


@pytest.mark.parametrize(("draw", "most"), [("normal", 100), ("uniform", 100), ("gamma", 100), ("exponential", 1000)])
def test_fresh_values_are_beyond_no_more_often_than_stated(draw: str, most: int) -> None:
    """200 bounds from 60 values each, and 5,000 fresh values each: a million, of which 100 may be beyond.

    An exponential tail itself is told by six of the 60 values: there it is up to ten times the rate, as documented.
    """
    rng = np.random.default_rng(9)

    def values(n: int) -> np.ndarray:
        return np.asarray(rng.gamma(4.0, size=n) if draw == "gamma" else getattr(rng, draw)(size=n))

    beyond = sum(int((values(5000) > upper_bound(values(60).tolist(), RATE)).sum()) for _ in range(200))
    assert beyond <= most


def test_the_lower_bound_mirrors_the_upper_one() -> None:
    some = np.random.default_rng(1).gamma(2.0, size=50).tolist()
    assert lower_bound(some, RATE) == -upper_bound([-v for v in some], RATE)


def test_equal_values_leave_the_margin() -> None:
    assert upper_bound([2.0] * 20, RATE, margin=0.1) == pytest.approx(2.1)


@pytest.mark.parametrize(("count", "rate"), [(9, RATE), (50, 0.0), (50, 0.2)])
def test_too_few_values_or_no_rate_are_refused(count: int, rate: float) -> None:
    with pytest.raises(ValueError, match="at least 10, and between 0 and"):
        upper_bound([1.0] * count, rate)
