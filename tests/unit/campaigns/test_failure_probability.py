"""How likely a failure is: against problems whose probability is known on paper."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm

sys.path[:0] = [str(Path(__file__).parent)]
import planted  # noqa: E402

from pytest_dvp.campaigns.failure_probability import clopper_pearson, weighted  # noqa: E402
from pytest_dvp.campaigns.measured_probability import counted_probability, measured_probability  # noqa: E402
from pytest_dvp.campaigns.one_drive import Drive  # noqa: E402
from pytest_dvp.campaigns.rare_failures import Judge, rare_probability  # noqa: E402
from pytest_dvp.campaigns.store import Row, Store  # noqa: E402

REPEATS = 6


def half_space(size: int, p: float) -> Judge:
    """Fails beyond a plane: P(sum of normals / sqrt(d) > beta) = p."""
    beta = -norm.ppf(p)
    return lambda u: beta - norm.ppf(u).sum(axis=1) / np.sqrt(size)


def two_sides(size: int, p: float) -> Judge:
    """Fails in two regions on opposite sides, p/2 each."""
    beta = -norm.ppf(p / 2)
    return lambda u: beta - np.abs(norm.ppf(u[:, 0]))


def corner(size: int, p: float) -> Judge:
    """Fails in a corner of the cube, where all shares are large: p is the product of its sides."""
    return lambda u: (1.0 - p ** (1.0 / size)) - u.min(axis=1)


@pytest.mark.parametrize(("problem", "size", "p"), [(half_space, 5, 1e-4), (two_sides, 3, 1e-2), (corner, 2, 1e-5)])
@pytest.mark.nightly(by_day=3)
def test_the_interval_holds_the_known_probability(problem: Callable[[int, float], Judge], size: int, p: float) -> None:
    answers = [rare_probability(problem(size, p), size, 1000, seed) for seed in range(REPEATS)]
    # Of 6 intervals at 95 % fewer than 4 hold the truth with a probability of 0.002; `make campaigns` repeats it more.
    assert sum(answer.low <= p <= answer.high for answer in answers) >= 4
    assert max(answer.runs for answer in answers) <= 1100
    relative = np.sqrt(np.mean([(answer.estimate / p - 1.0) ** 2 for answer in answers]))
    plain = (1.0 - p) / p / relative**2  # drives whose share of failures has this relative error
    assert plain > 10 * 1000 or p > 1e-3


def test_zero_failures_in_n_runs_give_the_rule_of_three() -> None:
    bound = clopper_pearson(0, 0, 300)
    assert (bound.estimate, bound.low) == (0.0, 0.0)
    assert bound.high == pytest.approx(1.0 - 0.05 ** (1 / 300))  # (1 - p)^300 = 5 %
    assert bound.high == pytest.approx(3.0 / 300, rel=0.01)


def test_the_interval_of_a_share_is_that_of_the_tables() -> None:
    # Clopper and Pearson 1934: 10 of 100 at 95 %.
    found = clopper_pearson(10, 0, 100)
    assert (found.low, found.high) == (pytest.approx(0.0490, abs=1e-4), pytest.approx(0.1762, abs=1e-4))


def test_undecided_drives_widen_both_ways() -> None:
    found = clopper_pearson(10, 5, 100)
    assert found.low == clopper_pearson(10, 0, 100).low  # all of them might pass
    assert found.high == clopper_pearson(15, 0, 100).high  # or fail
    ones, five = np.ones(1000), np.arange(1000) < 5
    plain = weighted(ones, (np.arange(1000) >= 900).astype(float), np.zeros(1000), 1000, "")
    open_ = weighted(ones, (np.arange(1000) >= 900).astype(float), five.astype(float), 1000, "")
    assert (open_.low, open_.high > plain.high) == (plain.low, True)


@pytest.mark.parametrize("count", [(0, 0, 0), (3, 0, 2), (2, 2, 3), (-1, 0, 5)])
def test_what_is_no_share_is_refused(count: tuple[int, int, int]) -> None:
    with pytest.raises(ValueError, match="no share of them"):
        clopper_pearson(*count)


def test_where_nothing_fails_there_is_a_bound_and_no_zero() -> None:
    found = rare_probability(lambda u: np.ones(len(u)), 2, 400, 3)
    assert found.estimate == 0.0
    assert 3.0 / 400 < found.high <= 1.0  # the few final draws prove less than 400 plain ones would


def test_a_campaign_measures_and_keeps_each_drive(tmp_path: Path) -> None:
    with Store(tmp_path / "out", writes=True) as store:
        one = planted.campaign(tmp_path, store)  # a + b > 1.8 in the unit square: 0.2^2 / 2
        found = measured_probability(one, 400, 3)
        assert found.low <= 0.02 <= found.high
        assert len(store.rows()) == pytest.approx(found.runs, abs=5)  # few points fall on the same values
        again = measured_probability(planted.campaign(tmp_path, store, _unwanted), 400, 3)
    assert again == found


def _unwanted(order: Drive) -> Row:
    raise AssertionError(f"driven twice: {order.parameters}")


def test_an_error_of_the_run_is_undecided(tmp_path: Path) -> None:
    with Store(tmp_path / "out", writes=True) as store:
        rows = planted.campaign(tmp_path, store, lambda order: planted.row(order, None)).rows([(0.1, 0.1)], "sample")
    assert (counted_probability(rows).undecided, counted_probability(rows).high) == (1, 1.0)
