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


def recorded(yaw: np.ndarray) -> np.ndarray:
    log = Log({"t": T, "x": 5.0 * T, "y": 0.0 * T, "yaw": yaw, "v": np.full(50, 5.0)})
    return _of_columns("a.csv", log, CAR).rows


def test_a_row_without_a_heading_lies_between_its_neighbours() -> None:
    holes = np.where(np.arange(50) % 7 == 3, np.nan, YAW)
    assert recorded(holes)[:, 4] == pytest.approx(recorded(YAW)[:, 4], abs=1e-9)


def test_a_recording_without_any_heading_is_one_line() -> None:
    with pytest.raises(LogError, match=r"^a\.csv: a recording needs x, y, yaw and v; its yaw holds no value$"):
        recorded(np.full(50, np.nan))


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
