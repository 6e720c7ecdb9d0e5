"""Wheels that turn too slowly for their sensors: a speed of 0 is no standstill then, near its ends."""

from __future__ import annotations

import numpy as np
import pytest
from drives import Columns, drive

from pytest_dvp.doctor import comparable, examine
from pytest_dvp.doctor.dead_speed import dead_band
from pytest_dvp.logs.log import Log


def stops(rate: float = 50.0, noise: float = 0.01) -> Columns:
    """Six times from rest to 4 m/s and back, 1 m/s^2 near the stops, 10 s of standstill between; straight on."""
    t = np.arange(0.0, 180.0, 1.0 / rate)
    v = np.maximum(4.0 * np.sin(2.0 * np.pi * (t - 5.0) / 30.0) - 0.8, 0.0)
    rng = np.random.default_rng(2)
    shown = np.where(v > 0.0, v + rng.normal(0.0, noise, len(t)), 0.0)
    return {"t": t, "x": np.cumsum(v) / rate, "y": 0.0 * t, "yaw": 0.0 * t, "v": shown, "true": v}


def blind_below(columns: Columns, speed: float) -> Columns:
    """As a toothed wheel shows it: what turns more slowly stands."""
    return {**columns, "v": np.where(np.abs(columns["v"]) < speed, 0.0, columns["v"])}


@pytest.mark.parametrize("speed", [0.4, 0.7, 1.0])
@pytest.mark.parametrize("rate", [20.0, 50.0, 100.0])
def test_a_speed_that_jumps_from_0_is_told_and_not_measured_near_it(speed: float, rate: float) -> None:
    log = Log(columns=blind_below(stops(rate), speed))
    (told,) = [each for each in examine(log) if each.code == "log.dead_speed"]
    assert told.severity == "warning"
    found = dead_band(log)
    assert found is not None
    assert found.speed == pytest.approx(speed, abs=0.06)
    left = comparable(log).columns["v"]
    rolls = (log["true"] > 0.0) & (log["v"] == 0.0)
    assert np.count_nonzero(rolls) > 10
    assert np.isnan(left[rolls]).all()  # it rolled, and was said to stand
    shown = log["v"] != 0.0
    assert np.array_equal(left[shown], log["v"][shown])
    assert np.count_nonzero(left == 0.0) > 0.5 * np.count_nonzero(log["true"] == 0.0)  # a standstill is one


@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_the_same_speed_without_a_dead_band_shows_all(noise: float) -> None:
    assert dead_band(Log(columns=stops(noise=noise))) is None


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("rate", [5.0, 10.0, 50.0])
def test_a_speed_that_is_shown_down_to_0_has_no_dead_band(seed: int, rate: float) -> None:
    columns = drive(60.0, seed=seed, rate=rate, noise=0.0)
    columns["v"] = np.round(columns["v"] / 0.1) * 0.1  # coarse, and exactly 0 where the car stands
    assert dead_band(Log(columns=columns)) is None


@pytest.mark.parametrize("v", [np.zeros(500), np.full(500, 5.0), np.full(500, np.nan)])
def test_a_speed_that_never_changes_has_none(v: np.ndarray[tuple[int], np.dtype[np.float64]]) -> None:
    assert dead_band(Log(columns={"t": np.arange(500) * 0.02, "v": v})) is None
