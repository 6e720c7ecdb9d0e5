"""What a log could ever show: every effect of the catalogue is judged by what the drive asked of the vehicle."""

from __future__ import annotations

import numpy as np
import pytest
from drives import Columns, drive, log_of, without

from pytest_dvp.doctor import excitation
from vehicle.model.model_file import parse_model


@pytest.fixture(scope="module")
def sound() -> Columns:
    return drive()


def test_a_log_without_curves_cannot_show_what_curves_need() -> None:
    t = np.arange(2000) * 0.02
    columns = {"t": t, "x": 8 * t, "v": 8 + 0 * t, "yaw_rate": 0 * t, "steer_cmd": 0 * t, "yaw": 0 * t, "y": 0 * t}
    shown = excitation(log_of(columns))
    assert "understeer" in shown.out_of_reach
    assert "steer_delay" in shown.out_of_reach
    assert shown.within_reach == ()


def test_a_lively_log_could_show_actuators_and_says_what_tyres_would_need(sound: Columns) -> None:
    shown = excitation(log_of(sound))
    assert {"steer_delay", "steer_lag", "drive_lag", "brake_gain", "gyro_bias", "wheel_radius"} <= set(
        shown.within_reach
    )
    assert "speed_cmd" in shown.out_of_reach["speed_controller"]


def test_a_model_that_takes_the_speed_from_the_log_shows_nothing_of_it(sound: Columns) -> None:
    sheet = "[model]\nname = 'car'\n[inputs]\nlongitudinal = '{}'\n[parameters]\nwheelbase = 2.5\nmass = 1200.0\n"
    of_speed = {"wheel_radius", "road_grade", "accelerometer_bias", "front_wheel_speed"}
    log = log_of(sound)
    free = excitation(log, parse_model(sheet.format("accel_cmd")))
    imposed = excitation(log, parse_model(sheet.format("v")))
    assert of_speed <= set(free.within_reach) | set(free.hardly)
    assert of_speed <= set(imposed.out_of_reach)
    assert 'longitudinal = "v"' in imposed.out_of_reach["wheel_radius"]
    assert {"gyro_bias", "steer_delay"} <= set(imposed.within_reach)
    assert imposed.out_of_reach["drive_delay"] == "needs a model that is driven by accel_cmd"  # the log has it
    lacking = excitation(log_of(without(sound, "accel_cmd")), parse_model(sheet.format("v")))
    assert lacking.out_of_reach["drive_delay"].startswith("needs a column accel_cmd")


def test_a_wanted_speed_drives_what_lies_behind_the_controller(sound: Columns) -> None:
    """The car's own controller makes an acceleration of it: what is late or weak behind that shows as with a pedal."""
    behind = {"drive_delay", "drive_lag", "drive_gain", "rolling_resistance", "aero_drag", "brake_gain", "brake_lag"}
    wished = {**without(sound, "accel_cmd"), "speed_cmd": np.roll(sound["v"], -25)}
    sheet = "[model]\nname = 'car'\n[inputs]\nlongitudinal = '{}'\n[parameters]\nwheelbase = 2.5\nmass = 1200.0\n"
    for model in (None, parse_model(sheet.format("speed_cmd"))):
        shown = excitation(log_of(wished), model)
        assert behind <= {*shown.within_reach, *shown.hardly}
        assert "coasting" in shown.out_of_reach["lift_off_braking"]  # nobody knows when it asks for nothing
    imposed = excitation(log_of(wished), parse_model(sheet.format("v")))
    assert imposed.out_of_reach["drive_delay"] == "needs a model that is driven by speed_cmd"
    steady = excitation(log_of({**wished, "speed_cmd": np.full(len(sound["t"]), 8.0)}))
    assert behind <= set(steady.out_of_reach)


def test_a_slow_vehicle_shows_strong_resistances(sound: Columns) -> None:
    """At 0 to 2 m/s a resistance of 1/s times the speed takes 2 m/s^2, and one of 0.4 m/s^2 all that a robot has."""
    slow = 2.0 / float(np.max(sound["v"]))
    robot = {**sound, **{name: slow * sound[name] for name in ("x", "y", "v", "yaw_rate", "ay", "accel_cmd")}}
    shown = excitation(log_of(robot))
    assert {"rolling_resistance", "viscous_resistance"} <= set(shown.hardly)
    assert "3 m/s apart" in shown.hardly["viscous_resistance"]
    crawling = excitation(log_of({**robot, "v": 0.1 * robot["v"], "x": 0.1 * robot["x"], "y": 0.1 * robot["y"]}))
    assert {"rolling_resistance", "viscous_resistance"} <= set(crawling.out_of_reach)


def test_without_a_command_nothing_between_command_and_wheel_can_show(sound: Columns) -> None:
    shown = excitation(log_of(without(sound, "steer_cmd", "accel_cmd")))
    assert "steer_delay" in shown.out_of_reach
    assert "drive_lag" in shown.out_of_reach
    assert "steer_ratio" in shown.within_reach


def test_every_effect_of_the_catalogue_is_judged(sound: Columns) -> None:
    from vehicle.model.effect_catalogue import catalogue

    shown = excitation(log_of(sound))
    assert set(catalogue()) - set(shown.within_reach) - set(shown.hardly) - set(shown.out_of_reach) == set()


def test_a_limit_is_judged_by_what_was_asked_for_not_by_what_it_left(sound: Columns) -> None:
    # 4 W/kg cap the drive of a car that is asked for 3 m/s^2 at 10 m/s: 30 W/kg.
    t = np.arange(3000) * 0.02
    v = np.clip(np.sqrt(2.0 * 4.0 * (t % 20.0)), 0.0, 10.0)
    wish = np.where(t % 20.0 < 15.0, 3.0, -1.0)
    capped = excitation(log_of({"t": t, "v": v, "accel_cmd": wish}))
    assert "power_limit" in capped.within_reach
    gentle = excitation(log_of({"t": t, "v": v, "accel_cmd": 0.2 * wish}))
    assert "power_limit" in gentle.hardly


def test_a_slow_drive_could_show_strong_drag_only(sound: Columns) -> None:
    slow = excitation(log_of({**sound, "v": 0.5 * sound["v"]}))  # up to 7 m/s
    assert "10 m/s" in slow.hardly["aero_drag"]
    assert "aero_drag" in excitation(log_of({**sound, "v": 1.5 * sound["v"]})).within_reach
