"""Positions and headings beside what speed and yaw rate say of them: what a force does drops out, a sensor stands."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.dead_reckoning import (
    Reckoned,
    beside_dead_reckoning,
    measured_steps,
    wandering_innovations,
)

N, STEP = 5000, 0.02
T = STEP * np.arange(N)
BEGINS = np.arange(N) % 250 == 0


def motion(v: float = 10.0, rate: float = 0.2) -> np.ndarray:
    """(n, 8) of a car on a circle."""
    found = np.zeros((N, 8))
    found[:, 2] = rate * T
    found[:, 3], found[:, 4] = v, rate
    found[:, 0], found[:, 1] = v / rate * np.sin(rate * T), v / rate * (1.0 - np.cos(rate * T))
    return found


def since_begin(values: np.ndarray) -> np.ndarray:
    """Values (n,) less what they are where their stretch begins."""
    return values - np.repeat(values[BEGINS], 250)


def error(speed: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """(n, 8) residuals of a model that is too slow by speed (n,) [m/s] and turns too little by rate (n,) [rad/s]."""
    true = motion()
    yaw_off = since_begin(np.concatenate([[0.0], np.cumsum(0.5 * STEP * (rate[1:] + rate[:-1]))]))
    found = np.zeros((N, 8))
    found[:, 2], found[:, 3], found[:, 4] = yaw_off, speed, rate
    for k, (wave, other) in enumerate(((np.cos, lambda a: -np.sin(a)), (np.sin, np.cos))):
        rates = wave(true[:, 2]) * speed + other(true[:, 2]) * true[:, 3] * yaw_off
        found[:, k] = since_begin(np.concatenate([[0.0], np.cumsum(0.5 * STEP * (rates[1:] + rates[:-1]))]))
    return found


def test_what_a_wrong_force_does_drops_out() -> None:
    rest = error(0.3 * np.sin(T), 0.02 * np.cos(0.7 * T))
    assert np.abs(rest[:, :3]).max() > 0.02
    left = beside_dead_reckoning(rest, motion(), T, BEGINS)
    assert np.abs(left[:, :3]).max() < 2e-4
    assert np.array_equal(left[:, 3:], rest[:, 3:])


def test_what_a_speed_sensor_does_stays() -> None:
    """Shown 2 % too fast, 10 m/s are 0.2 m/s too much, and positions fall behind by 0.2 m in a second."""
    rest = np.zeros((N, 8))
    rest[:, 3] = 0.2
    left = beside_dead_reckoning(rest, motion(rate=0.0001), T, BEGINS)
    assert left[50, 0] == pytest.approx(-0.2, rel=1e-3)
    assert left[249, 0] == pytest.approx(-0.2 * 249 * STEP, rel=1e-3)
    assert left[250, 0] == 0.0  # a stretch begins


def test_a_residual_that_is_not_known_holds_and_one_that_is_never_known_is_none() -> None:
    rest = np.full((N, 8), np.nan)
    rest[:, 0] = 0.0
    rest[::5, 3] = 0.2
    left = beside_dead_reckoning(rest, motion(rate=0.0001), T, BEGINS)
    assert left[240, 0] == pytest.approx(-0.2 * 240 * STEP, rel=1e-3)
    rest[:, 3] = np.nan
    assert np.abs(beside_dead_reckoning(rest, motion(), T, BEGINS)[:, 0]).max() == 0.0


def walk(along: float, across: float, yaw: float, noise: float, seed: int = 3) -> np.ndarray:
    """(n, 8) residuals that wander by so much in a second, with noise [m] and a tenth of it [rad]."""
    rng = np.random.default_rng(seed)
    heading = motion()[:, 2]
    steps = np.sqrt(STEP) * rng.normal(size=(N, 3)) * (along, across, yaw)
    found = np.zeros((N, 8))
    found[:, 0] = np.cumsum(np.cos(heading) * steps[:, 0] - np.sin(heading) * steps[:, 1])
    found[:, 1] = np.cumsum(np.sin(heading) * steps[:, 0] + np.cos(heading) * steps[:, 1])
    found[:, 2] = np.cumsum(steps[:, 2])
    return found + rng.normal(size=(N, 8)) * np.array([noise, noise, 0.1 * noise, 0, 0, 0, 0, 0])


def reckoned(rest: np.ndarray, noise: float) -> Reckoned:
    sigma = np.array([noise, noise, 0.1 * noise, np.inf, np.inf, np.inf, np.inf, np.inf])
    return Reckoned(T, motion()[:, 2], rest, sigma, BEGINS, {"cruise": T >= 0.0, "braking": T < 0.3})


def test_the_step_of_a_second_is_found_again_along_and_across_the_car() -> None:
    """A hundred seconds hold a hundred steps: a root mean square of them is known to 7 %; overlapping ones help."""
    found = measured_steps([[reckoned(walk(0.1, 0.3, 0.02, 0.02), 0.02)]])
    assert found["along"]["cruise"] == pytest.approx(0.1, rel=0.25)
    assert found["across"]["cruise"] == pytest.approx(0.3, rel=0.25)
    assert found["yaw"]["cruise"] == pytest.approx(0.02, rel=0.25)
    assert set(found["yaw"]) == {"cruise"}  # 15 rows of braking are too few


def test_noise_is_no_walk_and_the_largest_of_the_groups_counts() -> None:
    still, moving = reckoned(walk(0.0, 0.0, 0.0, 0.02), 0.02), reckoned(walk(0.1, 0.1, 0.02, 0.02), 0.02)
    assert measured_steps([[still]])["along"]["cruise"] < 0.007
    assert measured_steps([[still], [moving]]) == measured_steps([[moving]])
    assert measured_steps([[still._replace(heading=np.full(N, np.nan))]]) == {"yaw": measured_steps([[still]])["yaw"]}
    assert measured_steps([[still._replace(noise=np.full(8, np.inf))]]) == {}


def innovations(rest: np.ndarray, steps: tuple[float, float, float], noise: float) -> np.ndarray:
    out = np.ones(N * 8)
    sigma = np.array([noise, noise, 0.1 * noise, np.inf, np.inf, np.inf, np.inf, np.inf])
    wandering_innovations(rest, sigma, np.tile(steps, (N, 1)), motion()[:, 2].copy(), T, BEGINS, out)
    return out.reshape(N, 8)


def test_what_could_not_be_foreseen_of_a_walk_is_white_and_of_size_one() -> None:
    """Of three channels of 5,000 rows; where a stretch begins nothing is foreseen, and its first row says nothing."""
    found = innovations(walk(0.1, 0.3, 0.02, 0.02), (0.1, 0.3, 0.02), 0.02)
    assert np.abs(found[BEGINS, :3]).max() < 0.2
    known = found[~BEGINS, :3]
    assert np.mean(known**2, axis=0) == pytest.approx(np.ones(3), abs=0.1)
    assert np.abs(np.mean(found[1:, :3] * found[:-1, :3], axis=0)).max() < 0.06
    assert abs(np.mean(known[:, 0] * known[:, 1])) < 0.06
    assert (found[:, 3:] == 1.0).all()  # the other channels are left as they are


def test_rows_without_a_position_say_nothing_and_are_bridged() -> None:
    rest = walk(0.1, 0.3, 0.02, 0.02)
    rest[np.arange(N) % 5 != 0, :2] = np.nan
    found = innovations(rest, (0.1, 0.3, 0.02), 0.02)
    measured = np.isfinite(rest[:, 0])
    assert (found[~measured, :2] == 0.0).all()
    assert np.mean(found[measured & ~BEGINS, :2] ** 2) == pytest.approx(1.0, abs=0.15)
