"""The guard: speed, angle, rate, traction, lateral acceleration and jerk; limits that are none."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product
from math import atan, nan, tan

import pytest
from command_gate_drive import LIMITS, NOT_NUMBERS, Drive, is_stop, near

from vehicle.guard.messages import Limits, Outcome, Output

# --- speed


@pytest.mark.parametrize("v", [20.0, 21.0, -20.0])
def test_at_the_highest_speed_there_is_no_traction(v: float) -> None:
    drive = Drive(v=19.0)
    drive.hold(0.2, accel=1.0, throttle=0.4)
    drive.motion = replace(drive.motion, v=v)
    decision = drive.ask(0.22, accel=1.0, throttle=0.4)
    assert decision.output == Output()
    assert decision.reasons == ("speed",)


def test_below_it_there_is() -> None:
    drive = Drive(v=19.99)
    assert drive.hold(0.4, accel=1.0, throttle=0.4).outcome is Outcome.PASSED


def test_at_the_highest_speed_braking_passes() -> None:
    assert Drive(v=21.0).ask(0.0, accel=-3.0, brake=0.4).output == Output(0.0, -3.0, 0.0, 0.4)


def test_a_pedal_below_zero_is_not_blamed_on_the_speed() -> None:
    assert Drive(v=21.0).ask(0.0, throttle=-0.1).reasons == ("traction",)


def test_ten_percent_above_it_the_car_brakes() -> None:
    assert Drive(v=22.0).ask(0.0).outcome is Outcome.PASSED
    assert is_stop(Drive(v=22.01).ask(0.0), "overspeed")
    assert is_stop(Drive(v=-22.01).ask(0.0), "overspeed")


# --- angle and what pedals can do


@pytest.mark.parametrize("asked", [0.36, 1.0, 1e9, -0.36, -1e9])
def test_the_wheel_turns_no_further_than_it_can(asked: float) -> None:
    drive = Drive()
    decision = drive.hold(1.2, steer=asked)
    assert decision.output.steer == math.copysign(0.35, asked)
    assert decision.reasons == ("angle",)


def test_at_the_lock_nothing_is_clamped() -> None:
    assert Drive().hold(1.2, steer=0.35).outcome is Outcome.PASSED


def test_traction_is_that_of_the_car() -> None:
    decision = Drive().hold(1.2, accel=9.0, throttle=7.0)
    assert (decision.output.accel, decision.output.throttle) == (2.5, 1.0)
    assert decision.reasons == ("traction",)
    assert Drive().hold(1.2, accel=2.5, throttle=1.0).outcome is Outcome.PASSED


@pytest.mark.parametrize("pedal", ["throttle", "brake"])
def test_a_pedal_below_zero_is_zero_and_named(pedal: str) -> None:
    decision = Drive().ask(0.0, **{pedal: -0.1})
    assert decision.output == Output()
    assert decision.reasons == ({"throttle": "traction", "brake": "brake"}[pedal],)


def test_a_brake_beyond_all_is_all() -> None:
    decision = Drive().ask(0.0, brake=1.5)
    assert decision.output.brake == 1.0
    assert decision.reasons == ("brake",)


@pytest.mark.parametrize("accel", [-8.0, -12.0, -20.0])
def test_braking_passes_at_once_and_beyond_what_the_data_sheet_says(accel: float) -> None:
    assert Drive().ask(0.0, accel=accel, brake=1.0).output == Output(0.0, accel, 0.0, 1.0)


def test_two_g_is_where_numbers_end() -> None:
    decision = Drive().ask(0.0, accel=-21.0)
    assert decision.output.accel == -20.0
    assert decision.reasons == ("traction",)


# --- rate


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_wheel_turns_no_faster_than_it_can(sign: float) -> None:
    drive = Drive()
    drive.ask(0.0)
    decision = drive.ask(0.02, steer=sign * 0.3)
    assert near(decision, steer=sign * 0.4 * 0.02)
    assert decision.reasons == ("steer_rate",)


def test_traction_comes_with_5_m_s3_and_goes_at_once() -> None:
    drive = Drive()
    drive.ask(0.0)
    decision = drive.ask(0.02, accel=2.0, throttle=1.0)
    assert near(decision, accel=0.1, throttle=0.1 / 2.5)
    assert decision.reasons == ("jerk",)
    assert drive.ask(0.04).outcome is Outcome.PASSED


def test_the_pedal_alone_is_limited_too() -> None:
    drive = Drive()
    drive.ask(0.0)
    decision = drive.ask(0.02, throttle=1.0)
    assert decision.reasons == ("jerk",)
    assert near(decision, throttle=0.04)


def test_a_gap_is_no_leave_to_jump() -> None:
    drive = Drive()
    drive.ask(0.0)
    assert near(drive.ask(5.0, steer=0.3, accel=2.0, throttle=1.0), steer=0.04, accel=0.5, throttle=0.2)


def test_braking_ends_traction() -> None:
    drive = Drive()
    drive.hold(0.2, throttle=0.4)
    decision = drive.ask(0.22, throttle=0.4, brake=0.01)
    assert decision.output == Output(0.0, 0.0, 0.0, 0.01)
    assert decision.reasons == ("brake_wins",)


# --- brake and traction in one command; full brake is 8 m/s^2

SMALLEST = 5e-324


BEFORE = ({}, {"accel": 2.0, "throttle": 1.0}, {"accel": -4.0}, {"accel": -8.0, "brake": 1.0})


@pytest.mark.parametrize("before", BEFORE, ids=["nothing", "traction", "slowing down", "full brake"])
def test_the_brake_wins_over_every_traction(before: dict[str, float]) -> None:
    asked = product((SMALLEST, 0.5, 1.0, 1.5), (SMALLEST, 2.0, 99.0), (0.0, SMALLEST, 0.5, 2.0), (0.0, 20.0, 21.0))
    for brake, accel, throttle, v in asked:
        drive = Drive(v=v)
        drive.hold(0.1, **before)
        decision = drive.ask(0.12, accel=accel, throttle=throttle, brake=brake)
        out, pressed = decision.output, min(brake, 1.0)
        assert out.throttle == 0.0
        assert out.brake >= pressed
        assert out.accel <= -8.0 * pressed
        assert decision.outcome is Outcome.CLAMPED
        assert "brake_wins" in decision.reasons


@pytest.mark.parametrize("brake", [SMALLEST, 0.5, 1.0])
@pytest.mark.parametrize("accel", [0.0, -SMALLEST, -0.5, -8.0, -20.0])
def test_a_brake_without_traction_passes_as_asked(accel: float, brake: float) -> None:
    decision = Drive().ask(0.0, accel=accel, brake=brake)
    assert decision.output == Output(0.0, accel, 0.0, brake)
    assert decision.reasons == ()


@pytest.mark.parametrize("brake", [0.0, -0.0, -SMALLEST, -1.0])
def test_a_brake_that_is_off_takes_no_traction(brake: float) -> None:
    drive = Drive()
    drive.ask(0.0)
    decision = drive.ask(0.02, accel=0.05, throttle=0.02, brake=brake)
    assert decision.output == Output(0.0, 0.05, 0.02, 0.0)
    assert "brake_wins" not in decision.reasons


@pytest.mark.parametrize("traction", [{"accel": 2.0}, {"throttle": 0.5}, {"accel": 2.0, "throttle": 0.5}])
def test_traction_waits_until_the_brake_has_gone(traction: dict[str, float]) -> None:
    """The brake goes by 5 m/s^3, so 0.125 in 0.2 s; accelerations from -0.1 m/s^2 would be above zero sooner."""
    drive = Drive()
    drive.ask(0.0, accel=-0.1, brake=0.1)
    for k in range(1, 8):
        decision = drive.ask(0.02 * k, **traction)
        assert decision.output.brake == pytest.approx(0.1 - 0.0125 * k)
        assert (decision.output.accel <= 0.0, decision.output.throttle) == (True, 0.0)
    assert "brake_wins" in decision.reasons
    assert drive.ask(0.16, **traction).output.brake == pytest.approx(0.0, abs=1e-12)
    decision = drive.ask(0.18, **traction)
    assert decision.output.brake == 0.0
    assert max(decision.output.accel, decision.output.throttle) > 0.0
    assert "brake_wins" not in decision.reasons


# --- lateral acceleration and jerk, a = v^2 tan(steer)/2.5 m


@pytest.mark.parametrize("v", [8.0, 15.0, -15.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_bend_is_taken_with_3_m_s2_at_most(v: float, sign: float) -> None:
    decision = Drive(v=v).hold(2.0, steer=sign * 0.3)
    assert v * v * tan(decision.output.steer) / 2.5 == pytest.approx(sign * 3.0)
    assert decision.reasons[-1] == "lateral_acceleration"


def test_a_bend_is_entered_with_5_m_s3_at_most() -> None:
    drive = Drive(v=10.0)
    drive.hold(0.1)
    for k, sign in enumerate((1, 1, -1, -1, -1)):
        before = drive.log[-1].output.steer
        decision = drive.ask(0.12 + 0.02 * k, steer=0.3 * sign)
        assert 100.0 * (tan(decision.output.steer) - tan(before)) / 2.5 == pytest.approx(sign * 5.0 * 0.02)
        assert decision.reasons == ("steer_rate", "lateral_jerk")


def test_between_the_bounds_of_a_bend_the_wheel_is_free() -> None:
    drive = Drive(v=10.0)
    drive.hold(0.1)
    steer = atan(0.09 * 2.5 / 100.0)  # 4.5 m/s^3
    assert drive.ask(0.12, steer=steer).outcome is Outcome.PASSED
    assert drive.ask(0.14, steer=0.0).outcome is Outcome.PASSED


@pytest.mark.parametrize("v", [0.0, 1e-4, 0.5])
def test_standing_and_creeping_only_the_wheel_itself_is_a_limit(v: float) -> None:
    drive = Drive(v=v)
    drive.ask(0.0)
    assert near(drive.ask(0.02, steer=0.3), steer=0.008)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_bend_that_became_too_fast_is_opened_as_fast_as_the_wheel_turns_and_no_further(sign: float) -> None:
    drive = Drive(v=5.0)
    drive.hold(1.0, steer=sign * 0.25)
    drive.motion = replace(drive.motion, v=10.0)
    decision = drive.ask(1.02, steer=sign * 0.25)
    assert near(decision, steer=sign * (0.25 - 0.008))
    assert decision.reasons == ("lateral_acceleration",)
    for k in range(40):
        decision = drive.ask(1.04 + 0.02 * k, steer=sign * 0.25)
        assert decision.output.steer * sign >= atan(3.0 * 2.5 / 100.0) - 1e-12
    assert near(decision, steer=sign * atan(3.0 * 2.5 / 100.0))


def test_opening_a_bend_lets_no_stack_swing_to_the_other_side() -> None:
    drive = Drive(v=5.0)
    drive.hold(1.0, steer=0.1)
    drive.motion = replace(drive.motion, v=8.75)  # 0.0977 rad would be 3 m/s^2
    decision = drive.ask(1.02, steer=-0.3)
    assert 8.75**2 * tan(decision.output.steer) / 2.5 == pytest.approx(3.0 - 5.0 * 0.02)
    assert decision.reasons == ("steer_rate", "lateral_jerk")


def test_at_the_bound_of_a_bend_it_may_be_opened() -> None:
    drive = Drive(v=8.0)
    drive.hold(2.0, steer=0.3)
    decision = drive.ask(2.02, steer=0.0)
    assert 64.0 * tan(decision.output.steer) / 2.5 == pytest.approx(3.0 - 5.0 * 0.02)


@pytest.mark.parametrize(("v", "dt", "swing"), [(0.5, 1e-3, 0.05), (0.0, 1e-8, 0.125), (1e-3, 1e-8, 0.125)])
def test_with_a_very_fast_wheel_jerk_counts_down_to_1_mm_s(v: float, dt: float, swing: float) -> None:
    drive = Drive(replace(LIMITS, max_steer_rate=1e9), v=v)
    drive.ask(0.0)
    assert tan(drive.ask(dt, steer=0.3).output.steer) == pytest.approx(swing)  # 5 m/s^3 * 2.5 m * dt/v^2


# --- limits


@pytest.mark.parametrize("name", [name for name in Limits.__slots__ if name != "area"])
@pytest.mark.parametrize("value", [0.0, -1.0, *NOT_NUMBERS], ids=repr)
def test_a_limit_is_a_positive_number(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"{name} = .*positive number"):
        replace(LIMITS, **{name: value})


@pytest.mark.parametrize(
    ("wrong", "why"),
    [
        ({"max_steer": 1.5}, "degrees"),
        ({"max_steer": 20.0}, "degrees"),
        ({"max_deceleration": 20.1}, "more than 20.0"),
        ({"stop_deceleration": 8.1}, "more than the car can do"),
        ({"area": ((0.0, 0.0), (1.0, 0.0))}, "three corners"),
        ({"area": ((0.0, 0.0), (1.0, 0.0), (1.0, nan))}, "two numbers"),
    ],
)
def test_limits_that_are_none_are_refused(wrong: dict[str, float], why: str) -> None:
    with pytest.raises(ValueError, match=why):
        replace(LIMITS, **wrong)


def test_limits_at_the_edge_are_taken() -> None:
    edge = replace(LIMITS, max_steer=1.49, max_deceleration=20.0, stop_deceleration=20.0, max_speed=0.5)
    assert replace(edge, area=((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))).stop_deceleration == 20.0
