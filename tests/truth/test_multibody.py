"""The recordings of CommonRoad's multi-body cars: sane, and what their parameter files say."""

from __future__ import annotations

import numpy as np
import pytest

from tests.truth.generate import SIGMA, UNITS
from tests.truth.multibody import CARS, FOLDER, make_multibody_log, recorded

CAR_NAMES = sorted(CARS)


def test_the_recordings_stay_small() -> None:
    files = list(FOLDER.glob("*.csv.gz"))
    assert len(files) == 2 * len(CARS)
    assert sum(f.stat().st_size for f in files) < 4_000_000


@pytest.mark.parametrize("car", CAR_NAMES)
@pytest.mark.parametrize(("drive", "length"), [("rich", 120.0), ("urban", 45.0)])
def test_a_recording_is_whole_and_sane(car: str, drive: str, length: float) -> None:
    log = recorded(car, drive)  # type: ignore[arg-type]
    assert set(log) == set(UNITS) - {"speed_cmd"}
    assert log["t"] == pytest.approx(np.arange(round(length * 50)) * 0.02)
    assert all(np.all(np.isfinite(column)) for column in log.values())
    assert log["v"].min() >= 0.0
    assert log["v"].max() < 13.5
    assert np.max(np.abs(log["ay"])) < 5.0
    assert log["v"][-1] == 0.0


@pytest.mark.parametrize("car", CAR_NAMES)
def test_position_is_that_of_the_rear_axle(car: str) -> None:
    """Where the rear axle hardly slips, the path runs along the heading: slow driving."""
    log = recorded(car, "rich")
    slow = (log["v"][:-1] > 1.0) & (log["v"][:-1] < 5.0)
    dx, dy = np.diff(log["x"]), np.diff(log["y"])
    side = (np.cos(log["yaw"][:-1]) * dy - np.sin(log["yaw"][:-1]) * dx) / 0.02
    assert np.max(np.abs(side[slow])) < 0.25
    assert np.mean(np.abs(side[slow])) < 0.06


@pytest.mark.parametrize("car", CAR_NAMES)
def test_turning_wheels_make_the_car_heavier_than_commanded(car: str) -> None:
    log = recorded(car, "rich")
    straight = (log["v"] > 2.0) & (log["accel_cmd"] > 1.0) & (np.abs(log["steer_cmd"]) < 0.001)
    ratio = np.median(log["accel_cmd"][straight] / np.gradient(log["v"], 0.02)[straight])
    assert ratio == pytest.approx(CARS[car].mass_ratio, rel=0.01)


@pytest.mark.parametrize("car", CAR_NAMES)
def test_the_steering_turns_no_faster_than_its_limit(car: str) -> None:
    log, known = recorded(car, "rich"), CARS[car]
    slow = (log["v"] > 3.0) & (log["v"] < 5.5)
    wheel = np.arctan(log["yaw_rate"] * known.wheelbase / np.maximum(log["v"], 1.0))
    rate = np.abs(np.gradient(wheel, 0.02))[slow]
    assert np.percentile(rate, 99.0) == pytest.approx(known.steer_rate, rel=0.06)
    asked = np.abs(np.gradient(log["steer_cmd"], 0.02))[slow]
    assert asked.max() > 2.0 * known.steer_rate


def test_noise_is_added_to_measurements_only() -> None:
    clean, log = recorded("bmw_320i", "urban"), make_multibody_log("bmw_320i", "urban", 3, "mid")
    assert np.array_equal(clean["steer_cmd"], log["steer_cmd"])
    assert np.std(log["yaw_rate"] - clean["yaw_rate"]) == pytest.approx(SIGMA["yaw_rate"], rel=0.05)


def test_a_delay_on_top_moves_the_command_ahead_of_the_car() -> None:
    clean = recorded("bmw_320i", "rich")
    log = make_multibody_log("bmw_320i", "rich", 3, "none", {"steer_delay": {"T": 0.2}})
    assert np.array_equal(log["steer_cmd"][:-10], clean["steer_cmd"][10:])
    assert np.array_equal(log["yaw_rate"], clean["yaw_rate"])


@pytest.mark.parametrize(
    ("effects", "column"),
    [
        ({"drive_gain": {"g": 0.8}}, "accel_cmd"),
        ({"brake_gain": {"g": 0.8}}, "accel_cmd"),
        ({"drive_delay": {"T": 0.1}}, "accel_cmd"),
        ({"steer_ratio": {"g": 0.8}}, "steer_cmd"),
        ({"steer_asymmetry": {"g_left": 0.8, "g_right": 1.0}}, "steer_cmd"),
        ({"steer_offset": {"offset": 0.01}}, "steer_cmd"),
        ({"wheel_radius": {"ratio": 0.95}}, "v"),
        ({"gyro_bias": {"b": 0.01}}, "yaw_rate"),
        ({"accelerometer_bias": {"b": 0.2}}, "ax"),
        ({"heading_bias": {"b": 0.02}}, "yaw"),
        ({"yaw_rate_latency": {"T": 0.1}}, "yaw_rate"),
        ({"gnss_latency": {"T": 0.1}}, "x"),
        ({"gnss_lever_arm": {"x": 0.5, "y": 0.0}}, "x"),
        ({"pitch": {"gain": 0.1}}, "ax"),
        ({"roll": {"gain": 0.1}}, "ay"),
        ({"imu_misalignment": {"angle": 0.05}}, "ay"),
    ],
)
def test_an_effect_on_top_shows_in_its_column(effects: dict[str, dict[str, float]], column: str) -> None:
    clean = recorded("ford_escort", "urban")
    log = make_multibody_log("ford_escort", "urban", 0, "none", effects)
    assert not np.array_equal(log[column], clean[column])
    untouched = {"accel_cmd", "steer_cmd"} - {column}
    assert all(np.array_equal(log[c], clean[c]) for c in untouched)


def test_what_cannot_be_put_on_a_recording_is_refused() -> None:
    with pytest.raises(ValueError, match="steer_lag cannot be put on a recording"):
        make_multibody_log("bmw_320i", "urban", effects={"steer_lag": {"tau": 0.2}})
    with pytest.raises(ValueError, match="multiple of"):
        make_multibody_log("bmw_320i", "urban", effects={"steer_delay": {"T": 0.111}})
