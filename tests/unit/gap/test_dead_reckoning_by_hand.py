"""Dead reckoning, its steps and its filter by few rows: the trapezoidal rule, mean squares and the textbook."""

from __future__ import annotations

from itertools import pairwise
from math import cos, inf, nan, sin, sqrt
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.dead_reckoning import (
    Reckoned,
    beside_dead_reckoning,
    measured_steps,
    wandering_innovations,
)

# --- what speed and yaw rate make of a position


def reckoned_by_hand(rest: np.ndarray, motion: np.ndarray, t: np.ndarray, begins: np.ndarray) -> np.ndarray:
    """Each stretch alone: residuals hold where they are not known, and are summed by the trapezoidal rule."""
    found = rest.copy()
    edges = sorted({0, *np.flatnonzero(begins), len(t)})
    for first, end in pairwise(edges):
        held = np.zeros((end - first, 3))  # of yaw, speed and yaw rate
        for k, channel in enumerate((2, 3, 4)):
            last = 0.0
            for i in range(first, end):
                last = rest[i, channel] if np.isfinite(rest[i, channel]) else last
                held[i - first, k] = last
        yaw, v = motion[first:end, 2], motion[first:end, 3]
        rates = np.column_stack([
            np.cos(yaw) * held[:, 1] - np.sin(yaw) * v * held[:, 0],
            np.sin(yaw) * held[:, 1] + np.cos(yaw) * v * held[:, 0],
            held[:, 2],
        ])  # fmt: skip
        for k in range(3):
            for i in range(first + 1, end):
                found[i, k] -= np.trapezoid(rates[: i - first + 1, k], t[first : i + 1])
    return found


@pytest.mark.parametrize("starts", [(0, 1, 13, 30), (5, 13)])
def test_positions_and_headings_lose_what_was_summed_since_their_stretch_began(starts: tuple[int, ...]) -> None:
    """The first row begins one, whether it says so or not."""
    rng = np.random.default_rng(5)
    rest, motion = rng.normal(size=(40, 8)), rng.normal(size=(40, 8)) + 2.0
    rest[rng.random(rest.shape) < 0.3] = nan
    rest[0, :5] = (1.0, 2.0, nan, nan, nan)
    t = np.cumsum(rng.uniform(0.02, 0.3, size=40))
    begins = np.isin(np.arange(40), starts)
    left = beside_dead_reckoning(rest, motion, t, begins)
    assert left == pytest.approx(reckoned_by_hand(rest, motion, t, begins), abs=1e-12, nan_ok=True)


# --- the step of a second


def stretch(change: tuple[float, float, float], rows: int = 102, heading: float = 0.0, noise: Any = None) -> Reckoned:
    """A log at 2 Hz that wanders by so much (x, y, yaw) in each second."""
    t: Any = 0.5 * np.arange(rows)
    rest = np.zeros((rows, 8))
    rest[:, :3] = t[:, None] * change
    sigma = np.array([0.1, 0.1, 0.02, inf, inf, inf, inf, inf] if noise is None else noise)
    return Reckoned(t, np.full(rows, heading), rest, sigma, t < 0.0, {"cruise": t >= 0.0})


@pytest.mark.parametrize("heading", [0.0, 0.6, 2.0, -1.2])
def test_a_step_has_the_noise_of_both_its_ends_and_is_seen_from_the_car(heading: float) -> None:
    found = measured_steps([[stretch((0.3, 0.5, 0.05), heading=heading)]])
    along, across = 0.3 * cos(heading) + 0.5 * sin(heading), 0.5 * cos(heading) - 0.3 * sin(heading)
    for name, step in (("along", along), ("across", across)):
        assert found[name]["cruise"] == pytest.approx(sqrt(max(step**2 - 2.0 * 0.01, 0.05**2 * 0.01)), rel=6e-3)
    assert found["yaw"]["cruise"] == pytest.approx(sqrt(0.05**2 - 2.0 * 0.02**2), rel=6e-3)


def test_a_step_is_told_with_three_digits_and_is_a_twentieth_of_the_noise_at_least() -> None:
    found = measured_steps([[stretch((0.0, 1.0, 0.1))]])
    assert found == {"along": {"cruise": 0.005}, "across": {"cruise": 0.99}, "yaw": {"cruise": 0.0959}}


def test_x_and_y_of_different_noise_are_taken_for_one_of_the_mean_square() -> None:
    noise = [0.3, 0.1, inf, inf, inf, inf, inf, inf]
    assert measured_steps([[stretch((1.0, 0.0, 1.0), noise=noise)]]) == {
        "along": {"cruise": 0.949},  # sqrt(1 - 2 x 0.05)
        "across": {"cruise": 0.0112},  # 0.05 sqrt(0.05)
    }


@pytest.mark.parametrize(("rows", "told"), [(102, True), (101, False)])
def test_a_hundred_steps_are_enough(rows: int, told: bool) -> None:
    assert bool(measured_steps([[stretch((1.0, 1.0, 1.0), rows)]])) is told
    short = [stretch((1.0, 1.0, 1.0), n) for n in (2, rows - 52, 54)]
    assert bool(measured_steps([short])) is told  # together; two rows are no second


def test_a_step_over_the_beginning_of_a_stretch_or_to_what_is_not_known_does_not_count() -> None:
    log = stretch((1.0, 0.0, 0.1), 110)
    log.rest[50:, 0] += 99.0
    log.begins[50] = True
    log.rest[20:22, 2] = nan
    assert measured_steps([[log]]) == measured_steps([[stretch((1.0, 0.0, 0.1), 110)]])
    log.begins[53] = log.begins[57] = log.begins[61] = True  # 100 of 108 steps are left by four stretches' beginnings
    assert measured_steps([[log]])["along"] == {"cruise": 0.99}
    log.begins[64] = True
    assert "along" not in measured_steps([[log]])


def test_heading_and_regime_are_those_of_the_middle_of_a_step() -> None:
    """A step at 2 Hz goes from row i to i + 2: that with its middle at row 120 is the last one of the first regime."""
    log = stretch((1.0, 0.0, 0.1), 240)
    early = np.arange(240) <= 120
    log = log._replace(heading=np.where(early, 0.0, 0.5 * np.pi), regimes={"cruise": early, "braking": ~early})
    found = measured_steps([[log]])
    assert found["along"] == {"cruise": 0.99, "braking": 0.005}
    assert found["across"] == {"cruise": 0.005, "braking": 0.99}
    log.rest[:, :2] = 0.0
    log.rest[121:, 0] = 10.0  # seen by a step with its middle at row 120, and by one at row 121
    found = measured_steps([[log._replace(heading=np.zeros(240))]])
    assert found["along"] == {"cruise": 0.902, "braking": 0.91}  # sqrt(100 / 120 - 0.02), sqrt(100 / 118 - 0.02)


@pytest.mark.parametrize(("step", "apart"), [(0.02, 50), (0.3, 3), (0.4, 2), (3.0, 1)])
def test_a_step_takes_as_many_rows_as_come_nearest_to_a_second(step: float, apart: int) -> None:
    """Of a walk to and fro with a period of 2 x apart rows, only steps of half a period are all of its whole width."""
    t: Any = step * np.arange(400)
    rest = np.zeros((400, 8))
    rest[:, 0] = np.where((np.arange(400) // apart) % 2, 1.0, 0.0)
    sigma = np.array([0.01, 0.01, inf, inf, inf, inf, inf, inf])
    found = measured_steps([[Reckoned(t, np.zeros(400), rest, sigma, t < 0.0, {"cruise": t >= 0.0})]])
    assert found["along"]["cruise"] == 1.0


# --- the filter


def innovations_by_hand(
    rest: np.ndarray, noise: np.ndarray, steps: np.ndarray, heading: np.ndarray, t: np.ndarray, begins: np.ndarray
) -> np.ndarray:
    """Harvey (1989), sec. 3.4, in matrices: prediction errors, whitened by the Cholesky factor of their covariance."""
    found = np.zeros((len(t), 3))
    state, covariance = np.zeros(3), np.diag([1e4, 1e4, 1e4])
    for i in range(len(t)):
        if begins[i]:
            state, covariance = np.zeros(3), np.diag([1e4, 1e4, 1e4])
        elif i:
            c, s = cos(heading[i]), sin(heading[i])
            turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
            covariance = covariance + turn @ np.diag(steps[i] ** 2 * (t[i] - t[i - 1])) @ turn.T
        seen = [k for block in ((0, 1), (2,)) for k in block
                if all(np.isfinite(noise[j]) and np.isfinite(rest[i, j]) for j in block)]  # fmt: skip
        if seen:
            chosen = np.eye(3)[seen]
            news = rest[i, seen] - state[seen]
            spread = chosen @ covariance @ chosen.T + np.diag(noise[seen] ** 2)
            found[i, seen] = np.linalg.solve(np.linalg.cholesky(spread), news)
            gain = covariance @ chosen.T @ np.linalg.inv(spread)
            state, covariance = state + gain @ news, covariance - gain @ chosen @ covariance
    return found


@pytest.mark.parametrize(
    ("noise", "first"),
    [((0.3, 0.2, 0.1), True), ((0.3, 0.2, 0.1), False), ((inf, 0.2, 0.1), True), ((0.3, inf, 0.1), True),
     ((0.3, 0.2, inf), True)],
)  # fmt: skip
def test_what_could_not_be_foreseen_is_that_of_a_filter_in_matrices(
    noise: tuple[float, float, float], first: bool
) -> None:
    rng = np.random.default_rng(7)
    n = 40
    rest = rng.normal(size=(n, 8))
    rest[rng.random(rest.shape) < 0.15] = nan
    steps, heading = rng.uniform(0.2, 2.0, size=(n, 3)), rng.uniform(-3.0, 3.0, size=n)
    t, sigma = np.cumsum(rng.uniform(0.05, 0.5, size=n)), np.array([*noise, inf, inf, inf, inf, inf])
    begins = np.isin(np.arange(n), (0, 17) if first else (17,))
    out = np.full(n * 8, 9.0)
    wandering_innovations(rest, sigma, steps, heading, t, begins, out)
    expected = innovations_by_hand(rest, sigma, steps, heading, t, begins)
    assert out.reshape(n, 8)[:, :3] == pytest.approx(expected, rel=1e-5, abs=1e-7)
    assert (out.reshape(n, 8)[:, 3:] == 9.0).all()
