"""Values that a table only repeats are no samples: a slow sensor in fast rows, and a position that was held."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from drives import Columns, drive, write_csv

from pytest_dvp.doctor import comparable, examine, read_checked_log
from pytest_dvp.doctor.repeated_values import repeats_of
from pytest_dvp.logs.log import Log


@pytest.fixture
def sound() -> Columns:
    return drive(60.0)


def held(
    values: np.ndarray[tuple[int], np.dtype[np.float64]], every: float
) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Each sample of a sensor that gives one in `every` rows, until the next."""
    return values[(np.floor(np.floor(np.arange(len(values)) / every) * every + 1e-9)).astype(int)]


@pytest.mark.parametrize("every", [2, 5, 10])
@pytest.mark.parametrize("names", [("x", "y", "yaw"), ("v",), ("yaw_rate", "ax", "ay")])
def test_a_slow_sensor_is_one_sample_in_so_many_rows(sound: Columns, names: tuple[str, ...], every: int) -> None:
    for name in names:
        sound[name] = held(sound[name], every)
    log = Log(columns=sound)
    first = np.arange(len(sound["t"])) % every == 0
    left = comparable(log).columns
    for name in names:
        moving = sound["v"] > 1.0  # a car that stands may give the same value twice
        assert np.array_equal(np.isfinite(left[name])[moving], first[moving]), name
    (told,) = [each for each in examine(log) if each.code == "log.held_values"]
    assert (
        told.element
        == f"column {', '.join(name for name in ('x', 'y', 'yaw', 'v', 'yaw_rate', 'ax', 'ay') if name in names)}"
    )
    assert f"each value stands in {every} rows: a sensor of about {50 / every:.3g} Hz" in told.message
    assert set(repeats_of(log)) == set(names)


def test_a_rate_that_is_no_part_of_that_of_the_rows_is_one_too(sound: Columns) -> None:
    sound["v"] = held(sound["v"], 2.5)  # 20 Hz: two rows, three rows
    assert set(repeats_of(Log(columns=sound))) == {"v"}
    (told,) = [each for each in examine(Log(columns=sound)) if each.code == "log.held_values"]
    assert told.message.startswith("each value stands in 2.5 rows: a sensor of about 20 Hz in rows of 50 Hz")


@pytest.mark.parametrize("silent", [slice(0, 100), slice(1500, 1600)])
def test_a_slow_sensor_that_was_silent_for_a_while_is_one_too(sound: Columns, silent: slice) -> None:
    """Before its first fix, or in a tunnel, its rows are empty."""
    for name in ("x", "y", "v"):
        sound[name] = held(sound[name], 5)
        sound[name][silent] = np.nan
    log = Log(columns=sound)
    first = (np.arange(len(sound["t"])) % 5 == 0) & (sound["v"] > 1.0)
    for name, rows in repeats_of(log).items():
        assert not rows[first].any(), name
        assert rows[(sound["v"] > 1.0) & ~first].all(), name
    assert set(repeats_of(log)) == {"x", "y", "v"}
    assert "log.held_position" not in [each.code for each in examine(log)]
    assert repeats_of(comparable(log)) == {}


@pytest.mark.parametrize("jitter", [0.005, 0.015, 0.02])
def test_a_slow_sensor_whose_samples_come_unevenly_is_one_too(jitter: float) -> None:
    """10 Hz behind an operating system, in rows of 100 Hz."""
    columns = drive(60.0, rate=100.0)
    t = columns["t"]
    came = np.sort(np.arange(0.0, 60.0, 0.1) + np.random.default_rng(2).normal(0.0, jitter, 600))
    came[0] = 0.0
    row = np.searchsorted(came, t, side="right") - 1
    for name in ("x", "y", "yaw"):
        columns[name] = np.interp(came, t, columns[name])[row]
    log = Log(columns=columns)
    found = repeats_of(log)
    moves = columns["v"] > 1.0
    new = np.concatenate([[True], np.diff(row) > 0])
    assert all(np.array_equal(found[name][moves], ~new[moves]) for name in ("x", "y", "yaw"))
    codes = [each.code for each in examine(log)]
    assert codes == ["log.held_values"]


def test_a_coarse_channel_that_climbs_evenly_is_no_slow_one() -> None:
    """A circle with a heading in steps of 0.01 rad, and a ramp with a speed in steps of 0.1 m/s; rows of 100 Hz."""
    t = np.arange(0.0, 60.0, 0.01)
    ramp = np.interp(t, [0.0, 5.0, 25.0, 30.0, 50.0, 60.0], [0.0, 0.0, 20.0, 20.0, 0.0, 0.0])
    assert repeats_of(Log(columns={"t": t, "yaw": np.round(0.25 * t, 2), "v": np.round(ramp, 1)})) == {}
    way = held(np.cumsum(ramp) * 0.01, 10)  # without noise, and at one speed for a while
    assert set(repeats_of(Log(columns={"t": t, "x": way}))) == {"x"}


def test_a_position_that_was_held_was_not_measured(sound: Columns) -> None:
    lost = slice(1000, 1040)  # 0.8 s
    for name in ("x", "y", "yaw"):
        sound[name][lost] = sound[name][1000]
    found = repeats_of(Log(columns=sound))
    assert set(found) == {"x", "y", "yaw"}
    assert all(np.flatnonzero(rows).tolist() == list(range(1001, 1040)) for rows in found.values())
    assert [each.code for each in examine(Log(columns=sound))] == ["log.held_position"]


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("coarse", [0.0, 0.05, 0.2])
def test_what_is_coarse_or_stands_repeats_nothing(seed: int, coarse: float) -> None:
    columns = drive(60.0, seed=seed)
    if coarse:
        for name in ("x", "y", "v", "ax", "ay"):
            columns[name] = np.round(columns[name] / coarse) * coarse
    assert repeats_of(Log(columns=columns)) == {}


def test_a_car_that_stands_keeps_its_values(sound: Columns) -> None:
    for name in ("x", "y", "yaw", "v"):
        sound[name][:500] = 0.0 if name == "v" else sound[name][0]
    assert repeats_of(Log(columns=sound)) == {}


def test_a_car_that_does_what_it_is_told_step_by_step_has_no_slow_sensor(sound: Columns) -> None:
    """As a twin without dynamics and noise: its steering and acceleration are the held commands."""
    for name, command in (("steer", "steer_cmd"), ("ax", "accel_cmd")):
        sound[command] = held(sound[command], 5)
        sound[name] = 0.9 * sound[command]
    assert repeats_of(Log(columns=sound)) == {}


def test_empty_rows_between_samples_are_left_alone(sound: Columns) -> None:
    for name in ("x", "y"):
        sound[name][np.arange(len(sound["t"])) % 5 != 0] = np.nan
    assert repeats_of(Log(columns=sound)) == {}


def test_what_is_compared_is_read_without_repeats(sound: Columns, tmp_path: Path) -> None:
    sound["yaw_rate"] = held(sound["yaw_rate"], 5)
    log, findings = read_checked_log(write_csv(tmp_path / "log.csv", sound))
    assert [each.code for each in findings] == ["log.held_values"]
    assert np.mean(np.isfinite(log.columns["yaw_rate"])) == pytest.approx(0.2, abs=0.01)
