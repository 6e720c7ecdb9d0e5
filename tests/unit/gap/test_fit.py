"""Least squares over parameters: closed forms where the model is linear, and what has no derivative."""

from __future__ import annotations

import dataclasses
from typing import cast

import numpy as np
import pytest
from gap_logs import baseline, drive

from pytest_dvp.gap.compare.start_correction import IntArray
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, Values, experiment_set
from pytest_dvp.gap.diagnose.least_squares import Coordinate, Fit, fit, intervals
from pytest_dvp.logs.log_contents import FloatArray
from vehicle.model.effect import Key
from vehicle.model.effect_catalogue import catalogue

SLOPE = Coordinate("line", Key("slope", "-", -5.0, 5.0, neutral=0.0, least=0.1))
HEIGHT = Coordinate("line", Key("height", "-", -5.0, 5.0, neutral=0.0, least=0.1))


class Line:
    """Stands in for a campaign: whitened residual of y = slope x + height at x from 0 to 1, in `parts` segments."""

    def __init__(self, noise: FloatArray, *, parts: int = 20, slope: float = 2.0, height: float = -1.0) -> None:
        self.x = np.linspace(0.0, 1.0, len(noise))
        self.y = slope * self.x + height + noise
        self.parts = parts

    def whitened(self, values: Values) -> FloatArray:
        return self.y - values["line", "slope"] * self.x - values["line", "height"]

    def starts(self) -> IntArray:
        return np.arange(self.parts, dtype=np.int64) * (len(self.x) // self.parts)

    def fitted(self) -> Fit:
        return fit(cast(ExperimentSet, self), (SLOPE, HEIGHT), {SLOPE.name: 0.0, HEIGHT.name: 0.0})

    def covariance(self) -> FloatArray:
        """Of the two values, for white noise of sigma 1."""
        design = np.column_stack([self.x, np.ones_like(self.x)])
        return np.asarray(np.linalg.inv(design.T @ design))


def half(interval: tuple[float, float]) -> float:
    return 0.5 * (interval[1] - interval[0])


def test_a_linear_model_is_fitted_as_the_normal_equations_say() -> None:
    line = Line(np.random.default_rng(1).normal(size=400))
    (slope, height), rest, *_ = np.linalg.lstsq(np.column_stack([line.x, np.ones(400)]), line.y, rcond=None)
    found = line.fitted()
    assert found.values[SLOPE.name] == pytest.approx(slope, abs=1e-4)
    assert found.values[HEIGHT.name] == pytest.approx(height, abs=1e-4)
    assert found.chi2 == pytest.approx(float(rest[0]), rel=1e-6)
    assert found.chi2 == pytest.approx(float(found.residual @ found.residual))


def test_the_interval_under_white_noise_is_that_of_the_textbook_or_half_as_wide_again() -> None:
    """1.96 sigma; more where experience with coloured noise asks for it, but not so much that it says nothing."""
    line = Line(np.random.default_rng(2).normal(size=20_000), parts=400)
    sigma = np.sqrt(np.diag(line.covariance()))
    sure = intervals(line.fitted(), line.starts())
    for place, name in enumerate((SLOPE.name, HEIGHT.name)):
        assert 0.95 * 1.96 * sigma[place] < half(sure[name]) < 1.5 * 1.96 * sigma[place]


def test_twice_the_noise_twice_the_interval() -> None:
    noise = np.random.default_rng(6).normal(size=2000)
    once, twice = Line(noise), Line(2.0 * noise)
    ratio = half(intervals(twice.fitted(), twice.starts())[SLOPE.name]) / half(
        intervals(once.fitted(), once.starts())[SLOPE.name]
    )
    assert ratio == pytest.approx(2.0, rel=0.01)


def coverage(sluggish: float, draws: int = 150) -> float:
    """Share of 95 % intervals that hold the truth, under noise with a constant part of its own in each segment."""
    rng = np.random.default_rng(3)
    hits = 0
    for _ in range(draws):
        noise = rng.normal(size=2000) + sluggish * np.repeat(rng.normal(size=40), 50)
        line = Line(noise, parts=40)
        low, high = intervals(line.fitted(), line.starts())[SLOPE.name]
        hits += low <= 2.0 <= high
    return hits / draws


@pytest.mark.parametrize("sluggish", [0.0, 1.0])
def test_19_of_20_intervals_hold_the_truth_even_under_noise_that_is_coloured_within_segments(sluggish: float) -> None:
    # binomial, 150 draws: three sigma are 5 %; an interval for white noise would hold it in 4 of 10 cases
    assert 0.90 <= coverage(sluggish) <= 1.0


def test_what_the_step_of_integration_moves_is_part_of_the_interval() -> None:
    line = Line(np.random.default_rng(4).normal(size=400))
    found = line.fitted()
    plain = intervals(found, line.starts())
    # integrated exactly, the residual has 0.3 x less: the slope would come out 0.3 lower
    moved = intervals(found, line.starts(), found.residual - 0.3 * line.x)
    assert half(moved[SLOPE.name]) == pytest.approx(half(plain[SLOPE.name]) + 0.3, abs=1e-3)
    assert half(moved[HEIGHT.name]) == pytest.approx(half(plain[HEIGHT.name]), abs=1e-3)


def test_an_interval_ends_where_the_equation_ends() -> None:
    never_negative = Coordinate("line", Key("slope", "-", 0.0, 5.0, neutral=0.0, least=0.1, minimum=0.0))
    line = Line(np.random.default_rng(5).normal(size=40), slope=0.02, parts=8)
    start = {never_negative.name: 1.0, HEIGHT.name: 0.0}
    found = fit(cast(ExperimentSet, line), (never_negative, HEIGHT), start)
    assert found.values[never_negative.name] >= 0.0
    assert intervals(found, line.starts())[never_negative.name][0] == 0.0


def test_what_no_event_hangs_on_is_not_known_and_what_jumps_no_better_than_its_derivative() -> None:
    jumps = Coordinate("line", Key("slope", "-", -5.0, 5.0, neutral=0.0, least=0.1), jumps=True)
    idle = Coordinate("line", Key("next", "-", 1.0, 2.0, neutral=1.5, least=0.1), jumps=True)
    line = Line(1e-6 * np.random.default_rng(5).normal(size=400))
    found = fit(cast(ExperimentSet, line), (jumps, idle), {jumps.name: 0.0, idle.name: 1.7}, fixed={HEIGHT.name: -1.0})
    sure = intervals(found, line.starts())
    assert found.values[idle.name] == 1.7
    assert sure[idle.name] == pytest.approx((0.75, 2.25))  # a quarter of the range outside it, where a search stops
    assert half(sure[jumps.name]) == pytest.approx(0.018 * 10.0, rel=1e-3)


@pytest.mark.parametrize(("most", "truth"), [(2.0, 2.02), (-2.0, -2.02)])
def test_a_value_at_the_end_of_what_the_equation_allows_still_has_an_interval(most: float, truth: float) -> None:
    """The best slope is beyond the end: the fit ends there, as certain to that side as that of any other value."""
    ends = {"maximum": most} if most > 0.0 else {"minimum": most}
    bound = Coordinate("line", Key("slope", "-", -2.0, 2.0, neutral=0.0, least=0.1, **ends))
    line = Line(0.1 * np.random.default_rng(5).normal(size=400), slope=truth)
    found = fit(cast(ExperimentSet, line), (bound, HEIGHT), {bound.name: 0.0, HEIGHT.name: 0.0})
    assert found.values[bound.name] == most
    low, high = intervals(found, line.starts())[bound.name]
    free = intervals(line.fitted(), line.starts())[SLOPE.name]
    assert (high if most > 0.0 else low) == most
    assert high - low == pytest.approx(half(free), rel=0.35)


def test_a_value_returns_from_the_end_of_what_the_equation_allows() -> None:
    """A first step that goes far beyond it does not get lost where nothing moves any more."""
    bound = Coordinate("line", Key("slope", "-", 0.0, 1.0, neutral=0.0, least=0.1, minimum=0.0, maximum=1.0))
    line = Line(0.1 * np.random.default_rng(6).normal(size=400), slope=0.8, height=0.0)
    start = {bound.name: 1.2, HEIGHT.name: -4.0}
    found = fit(cast(ExperimentSet, line), (bound, HEIGHT), start)
    assert found.values[bound.name] == pytest.approx(line.fitted().values[SLOPE.name], abs=1e-3)


def test_what_is_fixed_stays() -> None:
    line = Line(np.zeros(100))
    found = fit(cast(ExperimentSet, line), (SLOPE,), {SLOPE.name: 0.0}, fixed={HEIGHT.name: 0.0})
    assert set(found.values) == {SLOPE.name}
    # the best line through the origin on y = 2 x - 1: 2 - (mean x) / (mean x^2)
    assert found.values[SLOPE.name] == pytest.approx(2.0 - line.x.mean() / (line.x**2).mean(), abs=1e-4)


def test_derivatives_of_another_fit_do_not_decide_where_a_fit_ends() -> None:
    """Lent ones may be wrong by any factor; the last round of a fit has its own."""
    line = Line(np.random.default_rng(1).normal(size=400))
    own = line.fitted()
    wrong = dataclasses.replace(own, jacobian=np.ascontiguousarray(-3.0 * own.jacobian[::-1]))
    lent = fit(cast(ExperimentSet, line), (SLOPE, HEIGHT), {SLOPE.name: 0.0, HEIGHT.name: 0.0}, known=wrong)
    assert lent.chi2 == pytest.approx(own.chi2, rel=1e-6)
    assert lent.jacobian == pytest.approx(own.jacobian, abs=1e-6)


def test_no_coordinate_no_fit() -> None:
    line = Line(np.ones(100), slope=0.0, height=0.0)
    found = fit(cast(ExperimentSet, line), (), {}, fixed={SLOPE.name: 0.0, HEIGHT.name: 0.0})
    assert (found.values, found.chi2) == ({}, 100.0)
    assert intervals(found, line.starts()) == {}


@pytest.mark.parametrize(("low", "high", "by_ratio"), [(0.05, 1.0, True), (0.7, 1.3, False), (-2.0, 2.0, False)])
def test_a_place_is_0_to_1_over_the_range(low: float, high: float, by_ratio: bool) -> None:
    c = Coordinate("any", Key("k", "-", low, high, neutral=0.0, least=0.01))
    assert c.by_ratio is by_ratio
    assert c.value(0.0) == pytest.approx(low)
    assert c.value(1.0) == pytest.approx(high)
    middle = np.sqrt(low * high) if by_ratio else 0.5 * (low + high)
    assert c.value(0.5) == pytest.approx(middle)
    for u in (-0.2, 0.3, 1.2):
        assert c.to_unit(c.value(u)) == pytest.approx(u)
        assert c.slope(u) == pytest.approx((c.value(u + 1e-3) - c.value(u - 1e-3)) / 2e-3, rel=1e-4)


def test_a_lag_may_be_as_small_as_is_worth_a_name() -> None:
    """Typically 0.1 to 0.8 s, looked for by ratio; 0.03 s is the least that is worth a name."""
    tau = Coordinate("lag", Key("tau", "s", 0.1, 0.8, neutral=0.0, least=0.03, minimum=0.0))
    assert not tau.is_at_limit(0.04)
    assert tau.is_at_limit(0.03)
    assert tau.value(tau.within(tau.to_unit(0.01))) == pytest.approx(0.03)


def test_a_value_far_outside_its_range_stands_at_the_edge() -> None:
    c = Coordinate("any", Key("k", "-", 1.0, 3.0, neutral=0.0, least=0.01))
    assert not c.is_at_limit(3.0)
    assert not c.is_at_limit(3.4)
    assert c.is_at_limit(3.5)
    assert c.is_at_limit(0.5)


def test_a_delay_is_found_to_a_fraction_of_the_sample_though_it_has_no_derivative() -> None:
    """Commands come at 50 Hz; the truth is late by whole samples, the start is 60 ms away."""
    target = experiment_set({"log": drive(steer_delay=0.14)}, baseline())
    (key,) = catalogue()["steer_delay"].parameters
    found = fit(target, (Coordinate("steer_delay", key),), {("steer_delay", "T"): 0.2}, zoom=True)
    assert found.values["steer_delay", "T"] == pytest.approx(0.14, abs=0.004)
    assert found.chi2 / target.count == pytest.approx(1.0, abs=0.08)


def test_a_fit_is_never_worse_than_its_start() -> None:
    target = experiment_set({"log": drive(drive_gain=0.9)}, baseline())
    (key,) = catalogue()["steer_backlash"].parameters
    here = {("steer_backlash", "half_width"): 0.003}
    before = target.whitened(here)
    found = fit(target, (Coordinate("steer_backlash", key),), here)
    assert found.chi2 <= float(before @ before)
