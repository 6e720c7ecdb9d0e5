"""Values that stand alone are told, and taken for not measured; motions, noise and steps are none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from drives import Columns, drive, log_of, write_csv

from pytest_dvp.doctor import examine, read_checked_log
from pytest_dvp.doctor.spikes import spikes_of, without_spikes

CODE = "log.spikes"


@pytest.fixture
def sound() -> Columns:
    return drive(60.0)


def rows_of(columns: Columns, name: str) -> list[int]:
    found = spikes_of(log_of(columns))
    return np.flatnonzero(found[name]).tolist() if name in found else []


@pytest.mark.parametrize(
    ("name", "by"),
    [
        ("x", 5.0),
        ("y", -40.0),
        ("yaw", 1.0),
        ("v", -8.0),
        ("yaw_rate", 1.5),
        ("ax", 60.0),
        ("ay", -60.0),
        ("steer", 0.5),
    ],
)
@pytest.mark.parametrize("rows", [[1500], [1500, 1501], [1500, 1501, 1502], [400, 2900]])
def test_a_spike_is_told_with_its_place_and_size(sound: Columns, name: str, by: float, rows: list[int]) -> None:
    sound[name][rows] += by
    assert rows_of(sound, name) == rows
    (told,) = [each for each in examine(log_of(sound)) if each.code == CODE]
    assert (told.element, told.severity) == (f"column {name}", "warning")
    assert f"{len(rows)} value{'s stand' if len(rows) > 1 else ' stands'} apart" in told.message
    assert {each.code for each in examine(log_of(sound))} == {CODE}  # and it is taken for nothing else besides


def test_a_spike_is_not_measured_and_the_rest_stays(sound: Columns) -> None:
    sound["x"][1500] = 0.0
    left = without_spikes(log_of(sound)).columns["x"]
    assert np.flatnonzero(np.isnan(left)).tolist() == [1500]
    assert np.array_equal(np.delete(left, 1500), np.delete(sound["x"], 1500))


def test_what_is_compared_is_read_without_spikes(sound: Columns, tmp_path: Path) -> None:
    sound["v"][700] += 9.0
    log, findings = read_checked_log(write_csv(tmp_path / "log.csv", sound))
    assert [each.code for each in findings] == [CODE]
    assert np.flatnonzero(np.isnan(log.columns["v"])).tolist() == [700]


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("noise", [1.0, 10.0])
def test_a_sound_drive_has_none(seed: int, noise: float) -> None:
    assert not spikes_of(log_of(drive(40.0, seed=seed, noise=noise)))


@pytest.mark.parametrize("rate", [5.0, 10.0, 100.0])
def test_a_sound_drive_has_none_at_other_rates(rate: float) -> None:
    assert not spikes_of(log_of(drive(60.0, rate=rate)))


def test_a_step_a_pulse_and_an_oscillation_are_none(sound: Columns) -> None:
    sound["x"][1500:] += 30.0  # a fix that jumped
    sound["v"][1500:1510] -= 3.0  # longer than a spike
    sound["yaw_rate"] += 6.0 * np.sin(2.0 * np.pi * 6.0 * sound["t"])  # of a small car
    assert not spikes_of(log_of(sound))


def test_a_slow_channel_that_is_held_has_spikes_of_several_rows(sound: Columns) -> None:
    held = np.repeat(sound["x"][::10], 10)  # 5 Hz in a file of 50 Hz
    held[1500:1510] += 20.0
    assert rows_of({**sound, "x": held}, "x") == list(range(1500, 1510))
    sparse = np.where(np.arange(len(held)) % 10 == 0, sound["x"], np.nan)
    sparse[1500] += 20.0
    assert rows_of({**sound, "x": sparse}, "x") == [1500]


def test_many_spikes_are_a_faulty_sensor(sound: Columns) -> None:
    sound["ay"][5::50] += 80.0
    (told,) = [each for each in examine(log_of(sound)) if each.code == CODE]
    assert told.severity == "error"


def test_the_edges_of_a_log_are_no_spikes(sound: Columns) -> None:
    sound["x"][0] += 9.0  # nothing before it says that it is wrong
    assert rows_of(sound, "x") == []


@pytest.mark.parametrize("off", [0.003, 0.006])
def test_a_heading_that_a_driver_wraps_has_none(off: float) -> None:
    """A car that goes west, whose receiver tells its heading between -pi and pi: noise makes whole turns of it."""
    t, rng = np.arange(0.0, 60.0, 0.02), np.random.default_rng(0)
    heading = np.pi - off + rng.normal(0.0, 0.003, len(t))
    wrapped = np.remainder(heading + np.pi, 2.0 * np.pi) - np.pi
    assert np.count_nonzero(np.abs(np.diff(wrapped)) > 6.0) > 100
    assert rows_of({"t": t, "yaw": wrapped}, "yaw") == []
    wrapped[1500] = 0.0  # a cell that was not filled
    assert rows_of({"t": t, "yaw": wrapped}, "yaw") == [1500]


def flicked(rate: float) -> Columns:
    """A model car of 0.33 m of wheelbase at 3 m/s flicks its wheels by 0.3 rad for a tenth of a second and less."""
    step = 0.002
    t = np.arange(0.0, 60.0, step)
    wanted = np.zeros(len(t))
    for number, begin in enumerate(np.arange(2.0, 58.0, 1.7)):
        wanted[(t >= begin) & (t < begin + (0.05, 0.08, 0.1)[number % 3])] = 0.3 * (-1.0) ** number
    steer = np.zeros(len(t))
    for row in range(1, len(t)):
        steer[row] = steer[row - 1] + np.clip(wanted[row] - steer[row - 1], -6.0 * step, 6.0 * step)  # a fast servo
    turn = 3.0 * np.tan(steer) / 0.33
    rng, every = np.random.default_rng(1), round(1.0 / rate / step)
    columns = {"steer": steer, "yaw_rate": turn, "ay": 3.0 * turn, "v": np.full(len(t), 3.0)}
    noise = {"steer": 0.005, "yaw_rate": 0.02, "ay": 0.3, "v": 0.02}
    found = {name: (values + rng.normal(0.0, noise[name], len(t)))[::every] for name, values in columns.items()}
    return {"t": t[::every], **found}


@pytest.mark.parametrize("rate", [10.0, 20.0, 50.0])
@pytest.mark.parametrize("lacking", ["steer", "ay", ""])
def test_a_flick_of_a_small_car_that_two_channels_tell_is_none(rate: float, lacking: str) -> None:
    columns = flicked(rate)
    columns.pop(lacking, None)
    assert not spikes_of(log_of(columns))


def test_a_spike_that_another_channel_has_otherwise_stays_one(sound: Columns) -> None:
    sound["yaw_rate"][1500] += 3.0  # a message of an IMU that was spoilt as a whole
    sound["ay"][1500] -= 70.0
    sound["steer"] = np.round(sound["steer"], 3)
    sound["steer"][1500] += 0.002  # a coarse steering angle, which climbs by chance
    assert rows_of(sound, "yaw_rate") == [1500]
