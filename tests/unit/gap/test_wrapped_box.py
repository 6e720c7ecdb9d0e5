"""Command path and sensors of the kernel around a model made elsewhere, against closed forms and a truth of its own."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

import numpy as np
import pytest
from gap_logs import WHEELBASE, drive

from pytest_dvp.gap.compare.compare import noise_floor
from pytest_dvp.gap.compare.compared_model import ComparedModel, LogSubject, ModelSubject, Values
from pytest_dvp.gap.compare.python_model import StepSubject
from pytest_dvp.gap.compare.segments import CHANNELS, cut, measured_array, residuals
from pytest_dvp.logs.log import Log
from vehicle.model.effect_catalogue import catalogue, find_effect
from vehicle.model.errors import ModelError

EVERYTHING = CHANNELS[:7]


def bicycle(state: dict[str, float], inputs: Mapping[str, float], dt: float) -> Mapping[str, float]:
    """The car without any effect, as a user would write it."""
    after = max(state["v"] + inputs["accel_cmd"] * dt, 0.0)
    bend = math.tan(inputs["steer_cmd"]) / WHEELBASE
    way = 0.5 * (state["v"] + after) * dt
    heading = state["yaw"] + 0.5 * way * bend
    return {
        "x": state["x"] + way * math.cos(heading), "y": state["y"] + way * math.sin(heading),
        "yaw": state["yaw"] + way * bend, "v": after, "yaw_rate": after * bend,
        "ax": (after - state["v"]) / dt, "ay": after * after * bend,
    }  # fmt: skip


def left(log: Log, subject: ComparedModel, values: Values) -> dict[str, float]:
    """chi^2/N by channel with these values."""
    measured = measured_array(log.columns)
    segments = cut(log.t, measured)
    output = subject.output(log, segments, values)
    sigma = noise_floor(log.t, measured, EVERYTHING)
    return dict(zip(CHANNELS, residuals(output, measured, log.t, sigma, segments).chi2, strict=True))


def test_dead_time_of_the_steering_in_front_of_a_function_explains_a_late_car() -> None:
    log, box = drive(steer_delay=0.2), StepSubject(bicycle)
    assert left(log, box, {})["yaw_rate"] > 5.0
    assert left(log, box, {("steer_delay", "T"): 0.2})["yaw_rate"] == pytest.approx(1.0, abs=0.1)


def test_brake_gain_in_front_of_a_function_explains_weak_brakes() -> None:
    log, box = drive(brake_gain=0.8), StepSubject(bicycle)
    assert left(log, box, {})["v"] > 2.0
    assert left(log, box, {("brake_gain", "g"): 0.8})["v"] == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({("steer_ratio", "g"): 1.2}, lambda t: np.where(t < 1.0, 0.0, 0.12)),
        ({("steer_offset", "offset"): 0.01}, lambda t: np.where(t < 1.0, 0.01, 0.11)),
        ({("steer_delay", "T"): 0.11}, lambda t: np.where(t < 1.11 - 1e-9, 0.0, 0.1)),
        ({("steer_lag", "tau"): 0.25}, lambda t: np.where(t < 1.0, 0.0, 0.1 * (1.0 - np.exp((1.0 - t) / 0.25)))),
        ({("steer_rate_limit", "limit"): 0.2}, lambda t: np.clip(0.2 * (t - 1.0), 0.0, 0.1)),
        ({("steer_backlash", "half_width"): 0.01}, lambda t: np.where(t < 1.0, 0.0, 0.09)),
    ],
)  # fmt: skip
def test_step_of_steering_arrives_as_the_equation_says(values: Values, expected: object) -> None:
    from vehicle.model.wrapped_model import Wrapped

    t = np.arange(200) * 0.02
    acting = Wrapped(t).commands({"steer_cmd": np.where(t < 1.0 - 1e-9, 0.0, 0.1)}, values)
    assert callable(expected)
    assert acting.start["steer_cmd"] == pytest.approx(expected(t), abs=1e-12)
    # what acts from one stamp to the next is the mean of what goes on between them
    fine = (np.arange(200 * 200) + 0.5) * 1e-4
    assert acting.mean["steer_cmd"] == pytest.approx(expected(fine).reshape(200, 200).mean(axis=1), abs=1e-6)


@pytest.mark.parametrize(
    ("values", "channel", "expected"),
    [
        ({("gyro_bias", "b"): 0.02}, "yaw_rate", lambda t, x: 0.5 + 0.02 + 0.0 * t),
        ({("wheel_radius", "ratio"): 1.05}, "v", lambda t, x: 1.05 * 5.0 + 0.0 * t),
        ({("accelerometer_bias", "b"): -0.3}, "ax", lambda t, x: -0.3 + 0.0 * t),
        ({("imu_misalignment", "angle"): 0.1}, "ax", lambda t, x: 2.5 * math.sin(0.1) + 0.0 * t),
        ({("imu_misalignment", "angle"): 0.1}, "ay", lambda t, x: 2.5 * math.cos(0.1) + 0.0 * t),
        ({("gnss_lever_arm", "x"): 1.0, ("gnss_lever_arm", "y"): 0.0}, "x", lambda t, x: x + np.cos(0.5 * t)),
        ({("gnss_latency", "T"): 0.1}, "x", lambda t, x: np.interp(t - 0.1, t, x, left=np.nan)),
        ({("heading_bias", "b"): 0.05}, "yaw", lambda t, x: 0.5 * t + 0.05),
    ],
)  # fmt: skip
def test_sensor_shows_a_steady_circle_as_the_equation_says(values: Values, channel: str, expected: object) -> None:
    from vehicle.model.wrapped_model import Wrapped

    t = np.arange(300) * 0.02
    x, y = 10.0 * np.sin(0.5 * t), 10.0 * (1.0 - np.cos(0.5 * t))  # 5 m/s on a circle of 10 m
    rest = [np.full(300, value) for value in (5.0, 0.5, 0.0, 2.5, np.nan)]
    shown = Wrapped(t).sensors(np.column_stack([x, y, 0.5 * t, *rest]), values)
    assert callable(expected)
    wanted = expected(t, x)
    known = np.isfinite(wanted)
    assert shown[known, CHANNELS.index(channel)] == pytest.approx(wanted[known], abs=1e-9)


def test_past_of_a_late_receiver_goes_along_when_the_box_is_put_elsewhere() -> None:
    from vehicle.model.wrapped_model import Wrapped

    t = np.arange(200) * 0.02
    x = 5.0 * t + np.where(np.arange(200) < 100, 0.0, 7.0)  # straight on at 5 m/s, put 7 m ahead in row 100
    motion = np.column_stack([x, *np.zeros((2, 200)), np.full(200, 5.0), *np.zeros((4, 200))])
    before = np.array([[0.0, 0.0, 0.0], [5.0 * t[100], 0.0, 0.0]])
    shown = Wrapped(t).sensors(motion, {("gnss_latency", "T"): 0.1}, starts=np.array([0, 100]), before=before)
    assert shown[:, 0] == pytest.approx(x - 0.5, abs=1e-9)


def test_second_log_takes_sensor_effects() -> None:
    log = drive()
    biased = Log({**log.columns, "yaw_rate": log["yaw_rate"] + 0.03})
    other = LogSubject(drive(noise=0.0))
    assert left(biased, other, {})["yaw_rate"] > 20.0
    assert left(biased, other, {("gyro_bias", "b"): 0.03})["yaw_rate"] == pytest.approx(1.0, abs=0.1)


def test_which_effects_can_be_judged_around_a_function_is_said() -> None:
    box, log = StepSubject(bicycle), drive(20.0)
    can = {name for name, effect in catalogue().items() if not box.why_not(effect, log, EVERYTHING)}
    assert {catalogue()[name].slot for name in can} == {"command", "actuator", "sensor"}
    outside = {name for name, effect in catalogue().items() if effect.slot in ("command", "actuator", "sensor")}
    # controllers see the car's own speed, a released pedal brakes with a force, a swaying body feels true forces, a
    # force rises from nought where a car stands, a filter smooths what went on between two rows
    seeing = {
        "accelerometer_filter",
        "accel_controller",
        "speed_controller",
        "lift_off_braking",
        "body_roll",
        "body_pitch",
        "force_rise",
    }
    # a speed heats a brake, changes a gear or the ratio of a steering, ends a push, or says that the car stands
    seeing |= {"brake_fade", "gear_changes", "steer_assist", "steer_sticking", "speed_limit", "creep"}
    seeing |= {"torque_converter"}  # whose turbine turns with the wheels
    seeing |= {
        "wheel_slip",
        "front_wheel_speed",
    }  # wheels slip by the forces on them; the front ones run along their own path
    assert outside - can <= seeing


@pytest.mark.parametrize(
    ("effect", "reason"),
    [
        ("aero_drag", "acts inside the model (force)"),
        ("road_bank", "acts inside the model (road)"),
        ("speed_controller", "needs what only the model itself knows (speed_cmd, speed_gain, vx)"),
        ("imu_misalignment", "the model gives no ax"),
        ("drive_lag", "the model is not driven by accel_cmd"),
        ("detection_range", "acts on detected objects"),
    ],
)
def test_effect_that_cannot_be_judged_says_why(effect: str, reason: str) -> None:
    log = drive(20.0)
    steered = dataclasses.replace(log, columns={k: v for k, v in log.columns.items() if k != "accel_cmd"})
    given = [name for name in EVERYTHING if name != "ax"]
    assert StepSubject(bicycle).why_not(find_effect(effect), steered, given) == reason


def test_second_log_and_our_own_model_say_what_they_cannot() -> None:
    from gap_logs import baseline

    log = drive(20.0)
    other = LogSubject(log)
    assert other.why_not(find_effect("steer_lag"), log, EVERYTHING) == "acts on commands, and a log is not driven again"
    assert other.why_not(find_effect("gyro_bias"), log, EVERYTHING) == ""
    assert ModelSubject(baseline()).why_not(find_effect("aero_drag"), log, EVERYTHING) == ""


def test_other_sensors_need_no_other_drive() -> None:
    calls = 0

    def counted(state: dict[str, float], inputs: Mapping[str, float], dt: float) -> Mapping[str, float]:
        nonlocal calls
        calls += 1
        return bicycle(state, inputs, dt)

    log, box = drive(20.0), StepSubject(counted)
    segments = cut(log.t, measured_array(log.columns))
    plain = box.output(log, segments)
    before = calls
    biased = box.output(log, segments, {("gyro_bias", "b"): 0.01})
    assert calls == before
    assert biased[:, 4] == pytest.approx(plain[:, 4] + 0.01)


def test_force_around_a_function_is_refused() -> None:
    with pytest.raises(
        ModelError, match=r"aero_drag.*cannot be wrapped|cannot be wrapped around step.*inside the model"
    ):
        left(drive(20.0), StepSubject(bicycle), {("aero_drag", "k"): 0.01})
