"""A recording that is driven again, where some of its rows hold no heading."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from pytest_dvp.drive.playback_source import _of_columns
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_error import LogError
from vehicle.messages import GnssFix, VehicleDescription

T = 0.1 * np.arange(50)
YAW = 0.2 * T
CAR = VehicleDescription(4.0, 1.8, 1.5, 2.5, 1.25, 0.6, 40.0, 3.0, 7.0, 1000.0)


def recorded(yaw: np.ndarray, t: np.ndarray = T, **other: np.ndarray) -> np.ndarray:
    log = Log({"t": t, "x": 5.0 * t, "y": 0.0 * t, "yaw": yaw, "v": np.full(len(t), 5.0)} | other)
    return _of_columns("a.csv", log, CAR).rows


def test_a_row_without_a_heading_lies_between_its_neighbours() -> None:
    holes = np.where(np.arange(50) % 7 == 3, np.nan, YAW)
    assert recorded(holes)[:, 4] == pytest.approx(recorded(YAW)[:, 4], abs=1e-9)


@pytest.mark.parametrize("column", ["x", "y", "yaw", "v"])
def test_a_recording_without_any_value_of_what_it_needs_is_one_line(column: str) -> None:
    with pytest.raises(LogError, match=rf"^a\.csv: a recording needs x, y, yaw and v; its {column} holds no value$"):
        recorded(**{"yaw": YAW, column: np.full(50, np.nan)})


@pytest.mark.parametrize(
    ("silent", "place"),
    [
        ((2.05, 2.65), "from t = 2 to 2.7 s"),
        ((-1.0, 0.65), "from t = 0 to 0.7 s"),
        ((4.25, 9.0), "from t = 4.2 to 4.9"),
    ],
)
@pytest.mark.parametrize("column", ["x", "v"])
def test_a_hole_of_more_than_half_a_second_is_not_bridged(column: str, silent: tuple[float, float], place: str) -> None:
    """Also where the log begins and ends; one of 0.5 s is."""
    values = 5.0 * T
    with pytest.raises(
        LogError, match=rf"its {column} holds no value {place}.*, allowed: holes up to 0\.5 s; a log can"
    ):
        recorded(YAW, **{column: np.where((silent[0] < T) & (silent[1] > T), np.nan, values)})
    recorded(YAW, **{column: np.where((T > 2.05) & (T < 2.45), np.nan, values)})


def test_rows_that_are_not_there_are_a_hole_too() -> None:
    rows = (T < 1.95) | (T > 3.05)
    with pytest.raises(LogError, match=r"its x holds no value from t = 1\.9 to 3\.1 s, allowed: holes up to 0\.5 s"):
        recorded(YAW[rows], T[rows])


def test_a_log_of_1_hz_has_no_holes_between_its_rows() -> None:
    slow = 1.0 * np.arange(10)
    assert recorded(0.2 * slow, slow)[450, 1] == pytest.approx(22.5)


def test_what_is_made_of_columns_is_measured_at_the_reference_point() -> None:
    """The stack takes the mounts of the description off; it must not find any."""
    car = msgspec.structs.replace(CAR, gnss_x=0.18, gnss_y=0.1, imu_x=1.2, imu_y=0.2, imu_yaw=0.1, lidar_x=2.0)
    log = Log({"t": T, "x": 5.0 * T, "y": 0.0 * T, "yaw": YAW, "v": np.full(50, 5.0)})
    recording = _of_columns("a.csv", log, car)
    told = recording.description
    assert (told.gnss_x, told.gnss_y, told.imu_x, told.imu_y, told.imu_yaw) == (0.0,) * 5
    assert told.lidar_x == 2.0
    fix = next(arrived.message for arrived in recording.messages if isinstance(arrived.message, GnssFix))
    assert (fix.x, fix.y) == (0.0, 0.0)
