"""Motion and demand of a log, smoothed: each quantity on a log whose answer is plain."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.gap.compare.smoothed_motion import Motion, _demand, bridged, mean_around, motion
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from vehicle.model.model_file import parse_model

T = 0.02 * np.arange(100)
UP = np.linspace(-1.0, 1.0, 100)


def model(inputs: str = "") -> object:
    return parse_model(f"[inputs]\n{inputs}\n[parameters]\nwheelbase = 2.7\n")


def asked(longitudinal: str, more: str = "", **columns: FloatArray) -> FloatArray | None:
    log = Log({"t": T, "steer_cmd": 0.0 * T, **columns})
    return _demand(log, model(f'longitudinal = "{longitudinal}"\n{more}'), 0.5 + 0.0 * T)  # type: ignore[arg-type]


def test_the_acceleration_asked_for_by_each_kind_of_input() -> None:
    """Full throttle is 3 m/s^2 and full brake 6 m/s^2 where nothing else is declared."""
    assert asked("v", v=UP) is None
    assert asked("accel_cmd", accel_cmd=UP) == pytest.approx(UP)
    assert asked("speed_cmd", speed_cmd=UP) == pytest.approx(UP - 0.5)
    current = asked("motor_current", "full_current = 50.0", motor_current=UP)
    assert current == pytest.approx(np.where(UP > 0.0, 3.0 * UP, 6.0 * UP) / 50.0)
    pedal, brake = np.clip(UP, 0.0, None), np.clip(-UP, 0.0, None)
    assert asked("throttle_cmd", throttle_cmd=pedal) == pytest.approx(3.0 * pedal)
    both = asked(
        "throttle_cmd + brake_cmd", "full_throttle = 2.0\nfull_brake = 8.0", throttle_cmd=pedal, brake_cmd=brake
    )
    assert both == pytest.approx(2.0 * pedal - 8.0 * brake)
    pressure = asked(
        "throttle_cmd + brake_pressure", "full_pressure = 4e6", throttle_cmd=pedal, brake_pressure=2e6 * brake
    )
    assert pressure == pytest.approx(3.0 * pedal - 6.0 * 0.5 * brake)


def moved(inputs: str = "", **columns: FloatArray) -> Motion:
    known = {"t": T, "v": 4.0 + 0.0 * T, "yaw_rate": 0.1 + 0.0 * T, "accel_cmd": 0.0 * T, "steer_cmd": UP}
    return motion(Log({name: c for name, c in (known | columns).items() if c is not None}), model(inputs))  # type: ignore[arg-type]


def test_where_rows_are_rarer_than_a_tenth_of_a_second_speeds_are_smoothed_over_the_neighbours() -> None:
    """4, 7, 4, 7, ... a second each: 5 and 6 in between, and of two at the ends."""
    t = np.arange(6.0)
    v = np.array([4.0, 7.0, 4.0, 7.0, 4.0, 7.0])
    log = Log({"t": t, "v": v, "yaw_rate": 0.1 * v, "accel_cmd": 0.0 * t, "steer_cmd": 0.0 * t})
    found = motion(log, model())  # type: ignore[arg-type]
    assert found.v == pytest.approx([5.5, 5.0, 6.0, 5.0, 6.0, 5.5])
    assert found.yaw_rate == pytest.approx(0.1 * found.v)


def test_speed_and_yaw_rate_follow_from_path_and_heading_where_they_are_not_measured() -> None:
    nothing = np.full(100, np.nan)
    found = moved(v=nothing, yaw_rate=nothing, x=3.0 * T, y=-4.0 * T, yaw=0.7 * T)
    assert found.v == pytest.approx(5.0)
    assert found.yaw_rate == pytest.approx(0.7)
    measured = moved(x=3.0 * T, y=4.0 * T, yaw=0.7 * T)
    assert measured.v == pytest.approx(4.0)
    assert measured.yaw_rate == pytest.approx(0.1)
    assert (found.step, found.wheelbase) == (pytest.approx(0.02), 2.7)
    assert (found.x[-1], found.y[-1], found.yaw[-1]) == pytest.approx((3.0 * T[-1], -4.0 * T[-1], 0.7 * T[-1]))


def test_motion_is_a_mean_over_a_tenth_of_a_second_to_either_side() -> None:
    v = np.where(np.arange(100) == 50, 15.0, 4.0)
    found = moved(v=v).v
    assert found[44] == pytest.approx(4.0)
    assert found[45:56] == pytest.approx(5.0)  # 11 more in one of 11 samples
    assert found[56] == pytest.approx(4.0)


def test_the_steering_is_in_angles_of_the_wheel_and_none_if_it_is_measured_and_missing() -> None:
    assert moved("steer_zero = 0.1\nsteer_scale = 0.5").steer == pytest.approx(0.1 + 0.5 * UP)
    assert moved('steer = "steer"').steer is None
    assert moved('steer = "steer"', steer=2.0 * UP).steer == pytest.approx(2.0 * UP)


def test_way_and_energy_are_summed_up_while_the_car_moves() -> None:
    v = np.where(T < 0.99, -2.0, 0.0)
    push = np.where(T < 0.49, 1.5, -3.0)
    found = moved(v=v, accel_cmd=push)
    dt = np.append(np.diff(T), 0.0)
    smooth = mean_around(v, 5)
    assert found.way == pytest.approx(np.cumsum(np.abs(smooth) * dt))
    moving = np.abs(smooth) > 0.1 * 2.0 + 1e-6  # a tenth of the usual top speed of a slow car
    assert (found.moving == moving).all()
    power = push * smooth * dt * moving  # backwards, throttle takes energy out
    assert found.braked == pytest.approx(np.cumsum(np.where(power < 0.0, -power, 0.0)))
    assert found.driven == pytest.approx(np.cumsum(np.where(power > 0.0, power, 0.0)))
    assert 0.0 < found.braked[-1] < found.driven[-1]
    imposed = moved('longitudinal = "v"', v=4.0 + T)
    assert imposed.accel is None
    assert imposed.driven[60] - imposed.driven[20] == pytest.approx(np.sum((4.0 + T[21:61]) * 0.02))
    assert imposed.braked[60] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("v", "moves"), [(0.09, False), (0.11, True)])
def test_below_a_tenth_of_a_metre_a_second_even_a_small_car_stands(v: float, moves: bool) -> None:
    assert moved(v=np.full(100, v)).moving.all() == moves


def test_gaps_are_bridged_and_what_is_not_there_is_nought() -> None:
    assert bridged(np.arange(4.0), np.array([0.0, np.nan, 4.0, np.nan])).tolist() == [0.0, 2.0, 4.0, 4.0]
    assert bridged(np.arange(2.0), np.full(2, np.nan)).tolist() == [0.0, 0.0]


def test_a_mean_has_fewer_samples_at_the_ends() -> None:
    assert mean_around(np.array([1.0, 2.0, 6.0, 3.0]), 1) == pytest.approx([1.5, 3.0, 11.0 / 3.0, 4.5])
