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
