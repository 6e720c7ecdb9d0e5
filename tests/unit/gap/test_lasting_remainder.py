"""A known remainder as an error that lasts: what can be foreseen is no news, and what it imitates is no effect."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.gap.compare.coloured_noise import ORDER, Whitening
from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.gap.diagnose.diagnosis import Estimate, NamedEffect
from pytest_dvp.gap.diagnose.lasting_remainder import LastingRemainder, measured_memory, rounded_imitation
from pytest_dvp.gap.diagnose.least_squares import IMITATED, Coordinate, Fit, widen_imitated
from pytest_dvp.gap.diagnose.standing import _nothing_sure
from pytest_dvp.logs.log import Log
from vehicle.model.effect_catalogue import catalogue
from vehicle.model.remainder_shape import RemainderShape

N, STEP, MEMORY = 20_000, 0.02, 0.5
YAW_RATE = CHANNELS.index("yaw_rate")
NOISE, LEVEL = 0.005, 0.02  # rad/s
STARTS = np.arange(0, N, 250)
FIRST = np.isin(np.arange(N), STARTS)
WHITE = Whitening(np.ones(8), np.zeros((8, ORDER + 1, ORDER)), np.ones((8, ORDER + 1)), np.ones(8))


@pytest.fixture(scope="module")
def rest() -> np.ndarray:
    """Residuals (n, 8): white noise and a first-order Markov process in the yaw rate, nothing in the others."""
    rng = np.random.default_rng(5)
    kept = np.exp(-STEP / MEMORY)
    lasting = np.zeros(N)
    for k in range(N):
        fresh = LEVEL * rng.normal()
        lasting[k] = fresh if FIRST[k] else kept * lasting[k - 1] + np.sqrt(1.0 - kept * kept) * fresh
    found = np.full((N, 8), np.nan)
    found[:, YAW_RATE] = lasting + NOISE * rng.normal(size=N)
    return found


def remainder(level: float) -> LastingRemainder:
    t = STEP * np.arange(N)
    log = Log({"t": t, "v": np.full(N, 8.0)})
    measured = np.full((N, 8), np.nan)
    measured[:, 3], measured[:, 4] = 8.0, 0.0
    noise = np.full(8, np.inf)
    noise[YAW_RATE] = NOISE
    shape = RemainderShape({"yaw_rate": MEMORY})
    return LastingRemainder(log, measured, {"yaw_rate": {"cruise": level}}, shape, noise, WHITE, FIRST)


def test_what_is_left_of_a_remainder_that_lasts_is_white_and_of_size_one(rest: np.ndarray) -> None:
    """Innovations have the variance that the filter says, here 1, and no correlation; 20,000 samples show both to about
    0.01. Counted as noise of the same size, the samples have a correlation of 0.9."""
    news = remainder(LEVEL).freed(rest).reshape(N, 8)[:, YAW_RATE]
    assert np.mean(news**2) == pytest.approx(1.0, abs=0.04)
    assert np.mean(news[1:] * news[:-1]) == pytest.approx(0.0, abs=0.03)
    plain = rest[:, YAW_RATE] / np.std(rest[:, YAW_RATE])
    assert np.mean(plain[1:] * plain[:-1]) > 0.85


def test_without_a_remainder_residuals_are_in_units_of_the_noise(rest: np.ndarray) -> None:
    assert remainder(0.0).freed(rest).reshape(N, 8)[:, YAW_RATE] == pytest.approx(rest[:, YAW_RATE] / NOISE)


def test_a_gap_in_the_data_is_bridged_by_what_is_remembered(rest: np.ndarray) -> None:
    broken = rest.copy()
    broken[100:110] = np.nan
    news = remainder(LEVEL).freed(broken).reshape(N, 8)[:, YAW_RATE]
    assert (news[100:110] == 0.0).all()
    assert np.isfinite(news).all()


def test_the_memory_is_found_again(rest: np.ndarray) -> None:
    """Segments of 5 s are ten memories long and lose about a tenth of it."""
    found = measured_memory([(STEP * np.arange(N), rest, STARTS)], {"yaw_rate": {"cruise": LEVEL}})
    assert found["yaw_rate"] == pytest.approx(MEMORY, rel=0.2)
    assert measured_memory([(STEP * np.arange(N), rest, STARTS)], {}) == {}


def test_intervals_hold_what_the_remainder_imitates() -> None:
    c = Coordinate("drive_gain", catalogue()["drive_gain"].key("g"))
    fit = Fit((c,), {c.name: 0.9}, np.zeros(1), 0.0, np.zeros((1, 1)))
    low, high = widen_imitated(fit, {c.name: (0.87, 0.93)}, {"drive_gain": {"g": 0.04 / IMITATED}})[c.name]
    assert (low, high) == pytest.approx((0.85, 0.95))  # 0.05 = hypot(0.03, 0.04)
    assert widen_imitated(fit, {c.name: (0.87, 0.93)}, {})[c.name] == pytest.approx((0.87, 0.93))


def test_what_a_remainder_imitates_makes_no_interval_wider_than_the_equation_allows() -> None:
    """Of a creep under the brakes there is between none and all."""
    c = Coordinate("creep", catalogue()["creep"].key("braking"))
    fit = Fit((c,), {c.name: 0.6}, np.zeros(1), 0.0, np.zeros((1, 1)))
    assert widen_imitated(fit, {c.name: (0.5, 0.7)}, {"creep": {"braking": 5.0}})[c.name] == (0.0, 1.0)


@pytest.mark.parametrize(
    ("low", "high", "given", "doubted"),
    [
        (0.85, 0.95, {}, False),
        (0.85, 1.01, {}, True),  # 1 does nothing
        (0.85, 1.01, {"g": 0.8}, False),  # the twin has 0.8 already
        (0.85, 0.95, {"g": 0.9}, True),
    ],
)
def test_a_value_that_the_remainder_could_be_is_not_confirmed(
    low: float, high: float, given: dict[str, float], doubted: bool
) -> None:
    e = NamedEffect("drive_gain", {"g": Estimate(0.5 * (low + high), low, high, "-")})
    for excused in (True, False):
        assert bool(_nothing_sure(e, catalogue()["drive_gain"], given, excused=excused)) == doubted


def test_what_is_imitated_is_a_root_mean_square_by_key() -> None:
    assert rounded_imitation({("mass", "ratio"): [0.03, -0.04]}) == {"mass": {"ratio": 0.0354}}
