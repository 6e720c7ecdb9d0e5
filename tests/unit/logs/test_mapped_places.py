"""Positions and headings of a mapping in the forms that receivers write them in."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.read_log import read_log

# WGS 84 at 60 degrees: a degree of latitude is 111,412 m, one of longitude 55,800 m (series of NIMA TR8350.2).
NORTH, EAST = 111_412.0, 55_800.0
T = 0.1 * np.arange(200)
FAR = np.linspace(0.0, 500.0, 200)  # m to the north and to the east
LATITUDE, LONGITUDE = 60.0 + FAR / NORTH, 10.0 + FAR / EAST


def read(folder: Path, columns: dict[str, np.ndarray], entries: str, head: str = "") -> Log:
    names = ["t [s]", *columns]
    table = np.column_stack([T, *columns.values()])
    np.savetxt(folder / "a.csv", table, delimiter=",", header=",".join(names), comments="", fmt="%.12g")
    (folder / "map.toml").write_text(f'[log]\nonly = true\ntime = "t"\n{head}{entries}', encoding="utf-8")
    return read_log(folder / "a.csv", mapping=folder / "map.toml")


def fixes(more: str = "") -> str:
    return "".join(
        f'[[signal]]\nname = "{name}"\nfield = "{field}"\nunit = "{unit}"\n{more}'
        for name, field, unit in (("x", "lon", "longitude"), ("y", "lat", "latitude"))
    )


def test_degrees_in_whole_numbers_of_1e_7_have_a_scale(tmp_path: Path) -> None:
    columns = {"lat": np.round(1e7 * LATITUDE), "lon": np.round(1e7 * LONGITUDE)}
    log = read(tmp_path, columns, fixes("scale = 1e-7\n"))
    assert log["x"] == pytest.approx(FAR, abs=0.05)
    assert log["y"] == pytest.approx(FAR, abs=0.05)


def test_degrees_to_the_west_with_a_sign_fit_an_origin_in_degrees(tmp_path: Path) -> None:
    west = '[[signal]]\nname = "x"\nfield = "lon"\nunit = "longitude"\nsign = -1\n'
    north = '[[signal]]\nname = "y"\nfield = "lat"\nunit = "latitude"\n'
    columns = {"lat": LATITUDE, "lon": -(LONGITUDE - 20.0)}  # 10 degrees west, written as +10
    log = read(tmp_path, columns, west + north, "origin = [60.0, -10.0]\n")
    assert log["x"] == pytest.approx(FAR, abs=0.05)


def test_the_way_across_the_meridian_of_180_degrees_is_short(tmp_path: Path) -> None:
    longitude = 179.996 + FAR / EAST
    log = read(tmp_path, {"lat": LATITUDE, "lon": np.where(longitude > 180.0, longitude - 360.0, longitude)}, fixes())
    assert log["x"] == pytest.approx(FAR, abs=0.05)


def test_latitude_and_longitude_0_are_no_fix(tmp_path: Path) -> None:
    none = (np.arange(200) < 20) | (np.arange(200) == 100)
    log = read(tmp_path, {"lat": np.where(none, 0.0, LATITUDE), "lon": np.where(none, 0.0, LONGITUDE)}, fixes())
    assert np.isnan(log["x"]).tolist() == none.tolist() == np.isnan(log["y"]).tolist()
    assert log["x"][~none] - log["x"][20] == pytest.approx(FAR[~none] - FAR[20], abs=0.05)


def test_the_length_of_a_quaternion_does_not_matter_and_0_states_nothing(tmp_path: Path) -> None:
    yaw = np.linspace(0.0, 7.0, 200)
    size = np.where(np.arange(200) == 50, 0.0, 2.0)
    columns = {"q.x": 0.0 * T, "q.y": 0.0 * T, "q.z": size * np.sin(yaw / 2), "q.w": size * np.cos(yaw / 2)}
    log = read(tmp_path, columns, '[[signal]]\nname = "yaw"\nfield = "q"\nunit = "quaternion"\n')
    assert np.flatnonzero(np.isnan(log["yaw"])).tolist() == [50]
    assert log["yaw"][size > 0.0] == pytest.approx(yaw[size > 0.0], abs=1e-9)


@pytest.mark.parametrize("frame", ["frd", "ned"])
@pytest.mark.parametrize(
    ("name", "unit"),
    [("vy", "m/s"), ("ay", "m/s^2"), ("yaw_rate", "rad/s"), ("steer", "rad"), ("steer_cmd", "rad")],
)
def test_what_a_car_measures_turns_round_with_its_z_axis(tmp_path: Path, frame: str, name: str, unit: str) -> None:
    entry = f'[[signal]]\nname = "{name}"\nfield = "a"\nunit = "{unit}"\nframe = "{frame}"\n'
    assert read(tmp_path, {"a": T}, entry)[name] == pytest.approx(-T)


@pytest.mark.parametrize(("frame", "of_east"), [("frd", 0.0), ("ned", np.pi / 2)])
def test_a_yaw_that_counts_clockwise_is_turned_round(tmp_path: Path, frame: str, of_east: float) -> None:
    entry = f'[[signal]]\nname = "yaw"\nfield = "a"\nunit = "rad"\nframe = "{frame}"\n'
    assert read(tmp_path, {"a": 0.1 * T}, entry)["yaw"] == pytest.approx(of_east - 0.1 * T)


def test_a_frame_that_says_nothing_of_x_is_refused(tmp_path: Path) -> None:
    entry = '[[signal]]\nname = "x"\nfield = "a"\nunit = "m"\nframe = "ned"\n'
    with pytest.raises(LogError, match=r"x\.frame: found 'ned', allowed: none; x takes the field of the east"):
        read(tmp_path, {"a": T}, entry)


def test_a_frame_that_says_nothing_of_a_latitude_is_refused(tmp_path: Path) -> None:
    entry = '[[signal]]\nname = "y"\nfield = "a"\nunit = "latitude"\nframe = "frd"\n'
    with pytest.raises(LogError, match=r"y\.frame: found 'frd', allowed: none; degrees of latitude and longitude"):
        read(tmp_path, {"a": 48.0 + 1e-5 * T}, entry)
