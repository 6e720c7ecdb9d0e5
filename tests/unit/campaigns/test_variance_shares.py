"""Shares of a variance where they are known: linear results of normal and of constrained parameters."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm, qmc

from pytest_dvp.campaigns.variance_shares import first_order, shapley, with_error


def normals(correlation: float, count: int = 1024, more: int = 0) -> np.ndarray:
    """Two standard normal columns of a correlation, and `more` independent ones, as shares (count, 2 + more)."""
    even = norm.ppf(np.clip(qmc.Sobol(2 + more, seed=np.random.default_rng(3)).random(count), 1e-9, 1.0 - 1e-9))
    even[:, 1] = correlation * even[:, 0] + np.sqrt(1.0 - correlation**2) * even[:, 1]
    return np.asarray(norm.cdf(even))


def owen_prieur(b: tuple[float, float], r: float) -> list[float]:
    """Shapley effects of b1 x1 + b2 x2, x standard normal of correlation r (Owen and Prieur 2017, section 4.1)."""
    total = b[0] ** 2 + 2.0 * r * b[0] * b[1] + b[1] ** 2
    half = r**2 / 2.0 * (b[1] ** 2 - b[0] ** 2)
    return [(b[0] ** 2 + r * b[0] * b[1] + half) / total, (b[1] ** 2 + r * b[0] * b[1] - half) / total]


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.9, -0.6])
@pytest.mark.parametrize("weights", [(1.0, 1.0), (1.0, 2.0), (1.0, 0.0)])
def test_shapley_effects_of_a_linear_result_of_two_normals(correlation: float, weights: tuple[float, float]) -> None:
    x = normals(correlation)
    y = norm.ppf(x) @ np.array([weights, weights]).T
    for result in shapley(x, y).T:
        assert result == pytest.approx(owen_prieur(weights, correlation), abs=0.05)


def test_a_parameter_without_a_part_of_its_own_gets_one_by_what_it_depends_on() -> None:
    """x2 does nothing and follows x1 with 0.9: half of 0.81 falls to it. Alone, each explains most: 1 and 0.81."""
    x = normals(0.9)
    y = norm.ppf(x[:, :1])
    assert shapley(x, y)[1, 0] == pytest.approx(0.405, abs=0.04)
    assert first_order(x, y).sum() > 1.7


@pytest.mark.parametrize("more", [1, 6])
def test_shares_add_up_to_one_and_what_does_nothing_has_none(more: int) -> None:
    """Of three columns by all subsets, of eight by some orders."""
    x = normals(0.5, more=more)
    y = norm.ppf(x[:, :2]).sum(axis=1, keepdims=True)
    found = shapley(x, y)[:, 0]
    assert found.sum() == pytest.approx(1.0)
    assert np.abs(found[2:]).max() < 0.1
    assert found[:2] == pytest.approx([0.5, 0.5], abs=0.1)


def test_shapley_effects_of_the_function_of_ishigami() -> None:
    """Known in closed form: S1 + S13/2, S2, S13/2 of its indices 0.3139, 0.4424, 0.2437 (a = 7, b = 0.1)."""
    x = qmc.Sobol(3, seed=np.random.default_rng(8)).random(512)
    z = np.pi * (2.0 * x - 1.0)
    y = np.sin(z[:, 0]) + 7.0 * np.sin(z[:, 1]) ** 2 + 0.1 * z[:, 2] ** 4 * np.sin(z[:, 0])
    assert shapley(x, y[:, None])[:, 0] == pytest.approx([0.4358, 0.4424, 0.1218], abs=0.04)


def test_the_error_of_a_share_is_what_other_draws_of_it_differ_by() -> None:
    rng = np.random.default_rng(5)
    draws = []
    for _ in range(40):
        x = rng.random((150, 2))
        draws.append(with_error(first_order, x, x[:, :1] + x[:, 1:] + 0.3 * rng.standard_normal((150, 1))))
    spread = np.std([share for share, _ in draws], axis=0)
    told = np.mean([error for _, error in draws], axis=0)
    assert (told > 0.6 * spread).all()
    assert (told < 2.0 * spread).all()
