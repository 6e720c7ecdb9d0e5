"""Small laws of comparison and diagnosis against closed forms: what rating, regression and page do with numbers."""

from __future__ import annotations

import dataclasses
from math import cos, sin, sqrt
from types import SimpleNamespace

import numpy as np
import pytest

from pytest_dvp.gap.compare.error_location import locate
from pytest_dvp.gap.compare.iso18571 import _corridor
from pytest_dvp.gap.diagnose.equation_error import _FOLDS, _linear
from pytest_dvp.gap.diagnose.least_squares import Coordinate, Fit, intervals
from pytest_dvp.gap.diagnose.regression_signals import Signals, _judged
from pytest_dvp.gap.words.diagnosis_page import _turned
from vehicle.model.effect_catalogue import find_effect


def test_a_reference_of_zero_is_met_exactly_or_not_at_all() -> None:
    """ISO/TS 18571 scales its corridors with the largest value of the reference: there is none here."""
    assert _corridor(np.zeros(8), np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1e-6, 1.0])) == 0.75


def test_an_unknown_is_fitted_on_the_other_folds_and_not_pulled_to_nought() -> None:
    """The same normal equations A x = B in each fold: the others say x = B / A, and it takes 2 x B - A x^2 away."""
    a, b = 4.0, 6.0
    folds_a, folds_b = np.full((_FOLDS, 1, 1), a), np.full((_FOLDS, 1), b)
    assert _linear(folds_a, folds_b) == pytest.approx(_FOLDS * b * b / a, rel=1e-6)


def test_means_and_slopes_over_a_window_have_the_noise_of_their_samples() -> None:
    """Independent samples: the mean of ten has 1/sqrt(10) of their noise, a slope from two of them sqrt(2) of it over
    the time between them. A lateral acceleration less v r has that of both; the root mean square of this v is 5 m/s."""
    step, w, count = 0.02, 5, 100
    zeros = np.zeros(count)
    v = np.where(np.arange(count) % 2, 7.0, 1.0)
    s = Signals(step=step, w=w, rows=np.arange(10, 90, 5), t=np.arange(count) * step, v=v, rate=zeros, yaw=zeros,
                accel=zeros, steer=zeros, wheelbase=2.5, cg_front=1.2, gyration=1.5, measured={}, noise={})  # fmt: skip
    noise = {"v": 0.03, "ax": 0.2, "yaw_rate": 0.01, "yaw": 0.002, "ay": 0.1}
    _judged(s, dict.fromkeys(noise, zeros), noise)
    assert s.noise["ax"] == pytest.approx(0.2 / sqrt(10.0))
    assert s.noise["r"] == pytest.approx(0.01 / sqrt(10.0))
    assert s.noise["dv"] == pytest.approx(0.03 * sqrt(2.0) / 0.2)
    assert s.noise["dyaw"] == pytest.approx(0.002 * sqrt(2.0) / 0.2)
    assert s.noise["ay"] == pytest.approx(sqrt(0.1**2 + (5.0 * 0.01) ** 2) / sqrt(10.0))
    _judged(s, {"ay": zeros}, {"ay": 0.1})  # no gyroscope: its noise does not come in
    assert s.noise["ay"] == pytest.approx(0.1 / sqrt(10.0))


def test_an_error_of_position_is_drawn_along_and_across_the_cars_heading() -> None:
    """3 m ahead and 1 m to the left of a car that heads 0.6 rad to the left of the map's axis."""
    rest = np.array([[3.0 * cos(0.6) - sin(0.6), 3.0 * sin(0.6) + cos(0.6), 0.0]])
    along, across = _turned(rest, SimpleNamespace(measured=np.array([[0.0, 0.0, 0.6]])))  # type: ignore[arg-type]
    assert (along[0], across[0]) == pytest.approx((3.0, 1.0))


@pytest.mark.parametrize("segments", [3, 4, 26])
def test_an_interval_of_few_segments_is_wider_by_their_number(segments: int) -> None:
    """Ten samples a segment, all off by e with a sign of their own: each segment tells once, so the variance of a mean
    is e^2 / m, and e^2 / (m - 1) as its mean was fitted (Liang and Zeger 1986). The interval is 2.5 standard deviations
    wide; the gain's range of 0.7 to 1.2 makes half a unit of one."""
    (key,) = find_effect("drive_gain").parameters
    assert (key.low, key.high) == (0.7, 1.2)
    e = 0.04
    residual = np.repeat(e * np.where(np.arange(segments) % 2, 1.0, -1.0), 10)
    gain = Coordinate("drive_gain", key)
    found = Fit((gain,), {gain.name: 0.9}, residual, float(residual @ residual), np.ones((1, len(residual))))
    low, high = intervals(found, np.arange(0, len(residual), 10))[gain.name]
    assert 0.5 * (high - low) == pytest.approx(0.5 * 2.5 * e / sqrt(segments - 1.0))


def test_an_interval_says_how_far_the_values_move_without_a_segment() -> None:
    """Twelve values of thirty segments, fitted by numpy to all but one segment after the other."""
    rng = np.random.default_rng(3)
    keys = find_effect("body_roll").parameters
    coordinates = tuple(Coordinate("body_roll", dataclasses.replace(keys[0], name=f"k{k}")) for k in range(12))
    jacobian = np.repeat(rng.normal(size=(12, 30)), 20, axis=1) + 0.3 * rng.normal(size=(12, 600))
    wanted = np.repeat(rng.normal(size=30), 20) + 0.3 * rng.normal(size=600)
    best = np.linalg.lstsq(jacobian.T, wanted, rcond=None)[0]
    residual = wanted - best @ jacobian
    found = Fit(
        coordinates, {c.name: c.value(0.5) for c in coordinates}, residual, float(residual @ residual), jacobian
    )
    sure = intervals(found, np.arange(0, 600, 20))
    left_out = [np.delete(np.arange(600), np.arange(20 * g, 20 * g + 20)) for g in range(30)]
    moved = np.array([np.linalg.lstsq(jacobian.T[rows], wanted[rows], rcond=None)[0] - best for rows in left_out])
    spread = np.sqrt(29.0 / 30.0 * (moved * moved).sum(axis=0))
    for c, each in zip(coordinates, spread, strict=True):
        low, high = sure[c.name]
        assert 0.5 * (high - low) == pytest.approx(2.5 * each * c.slope(0.5), rel=1e-6)


@pytest.mark.parametrize(("known", "left"), [(0.85, 0.15), (0.95, 0.1), (1.0, 0.1)])
def test_a_segment_that_tells_nearly_all_counts_as_leaving_a_tenth(known: float, left: float) -> None:
    """Two segments of ten samples. The first one knows a share of the gain, and by itself would move it by 0.02; the
    other one has no error. Half of the square of what it moves the value by is the variance."""
    (key,) = find_effect("drive_gain").parameters
    gain = Coordinate("drive_gain", key)
    slope = np.repeat([np.sqrt(known), np.sqrt(1.0 - known)], 10)[None, :]
    residual = np.repeat([0.02 / np.sqrt(known), 0.0], 10)
    found = Fit((gain,), {gain.name: 0.9}, residual, 0.0, slope)
    low, high = intervals(found, np.array([0, 10]))[gain.name]
    assert 0.5 * (high - low) == pytest.approx(0.5 * 2.5 * np.sqrt(0.5) * 0.02 / left)


@pytest.mark.parametrize(("rows", "named"), [(19, False), (21, True)])
def test_where_an_error_is_needs_two_thousandths_of_the_time(rows: int, named: bool) -> None:
    count = 10_000
    rest = np.full(count, 0.1)
    rest[:rows] = 5.0
    mask = np.arange(count) < rows
    whole = SimpleNamespace(starts=np.array([0]), ends=np.array([count]))
    where = locate({"v": rest}, {"v": 2.0}, {"launch": mask}, np.arange(count) * 0.02, np.full(count, 8.0), None, whole)  # type: ignore[arg-type]
    assert ("launch" in [each.regime for each in where]) is named
