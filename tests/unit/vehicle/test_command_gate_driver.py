"""The guard: override, emergency stop, arming with two keys."""

from __future__ import annotations

from dataclasses import replace
from math import inf, nan

import pytest
from command_gate_drive import FIELD, KEY, LIMITS, Drive, is_stop, near

from vehicle.guard.guard import ArmingRefused, Guard
from vehicle.guard.messages import Arming, Outcome, Output, State

# --- driver


@pytest.mark.parametrize("pressed", [True, 1, None, 0])
def test_an_override_latches_in_its_cycle_and_the_driver_has_the_car(pressed: bool) -> None:
    drive = Drive(steer=0.1)
    drive.hold(0.2, steer=0.1, throttle=0.4)
    drive.motion = replace(drive.motion, override=pressed, steer=0.12)
    decision = drive.ask(0.22, steer=0.1, throttle=0.4)
    assert decision.outcome is Outcome.HANDED_OVER
    assert decision.reasons[-1] == "override"
    assert decision.output == Output(steer=0.12)
    assert (decision.live, decision.engaged, decision.state) == (True, False, State.OVERRIDDEN)
    drive.motion = replace(drive.motion, override=False)
    assert drive.ask(0.24).state is State.OVERRIDDEN


def test_for_the_driver_the_brake_fades_and_never_falls_away() -> None:
    drive = Drive()
    drive.ask(0.0, accel=-1.0, brake=0.02)
    drive.motion = replace(drive.motion, override=True)
    assert near(drive.ask(0.02), accel=-0.9, brake=0.02 - 0.1 / 8.0)
    assert near(drive.ask(0.04, brake=1.0), accel=-0.8, brake=0.0)


def test_the_driver_keeps_the_car_when_stack_clock_and_measurement_fail() -> None:
    drive = Drive(steer=0.1)
    drive.ask(0.0, brake=0.5, accel=-2.0)
    drive.motion = replace(drive.motion, override=True)
    drive.wait(0.02)
    for now, measured in ((0.3, None), (0.2, drive.motion), (nan, replace(drive.motion, steer=nan))):
        decision = drive.gate.cycle(now, None, measured)
        assert decision.outcome is Outcome.HANDED_OVER
        assert decision.output.steer == 0.1
    # 20 ms, then 100 ms for the gap, then nothing
    assert near(decision, steer=0.1, accel=-2.0 + 0.6, brake=0.5 - 0.6 / 8.0)


@pytest.mark.parametrize(("measured", "held"), [(0.5, 0.35), (-0.5, -0.35)])
def test_the_wheel_follows_the_drivers_hands_as_far_as_it_may(measured: float, held: float) -> None:
    drive = Drive()
    drive.motion = replace(drive.motion, override=True, steer=measured)
    assert drive.ask(0.0).output.steer == held


@pytest.mark.parametrize("pressed", [True, 1, None, 0])
def test_the_emergency_stop_latches_in_its_cycle(pressed: bool) -> None:
    drive = Drive(steer=0.1)
    drive.motion = replace(drive.motion, emergency_stop=pressed)
    decision = drive.ask(0.0, steer=0.1)
    assert is_stop(decision, "emergency_stop", steer=0.1)
    assert (decision.live, decision.engaged, decision.state) == (True, True, State.STOPPED)
    drive.motion = replace(drive.motion, emergency_stop=False)
    assert is_stop(drive.ask(0.02, throttle=1.0), "emergency_stop", steer=0.1)


def test_latches_are_set_by_a_measurement_that_is_stale_and_not_finite_otherwise() -> None:
    drive = Drive()
    drive.gate.cycle(1.0, None, replace(drive.motion, v=nan, emergency_stop=True))
    assert drive.gate.state is State.STOPPED


def test_no_measurement_is_no_button() -> None:
    drive = Drive()
    assert drive.gate.cycle(0.0, None, None).state is State.ARMED


def test_the_emergency_stop_goes_over_an_override_and_not_the_other_way() -> None:
    drive = Drive()
    drive.motion = replace(drive.motion, override=True)
    drive.ask(0.0)
    drive.motion = replace(drive.motion, emergency_stop=True)
    assert drive.ask(0.02).state is State.STOPPED
    drive.motion = replace(drive.motion, emergency_stop=False)
    assert drive.ask(0.04).state is State.STOPPED


def test_the_emergency_stop_can_be_called() -> None:
    drive = Drive()
    drive.gate.emergency_stop()
    assert is_stop(drive.ask(0.0), "emergency_stop")


# --- arming


def test_it_begins_dry_where_all_is_decided_and_nothing_is_live() -> None:
    drive = Drive(armed=False)
    drive.ask(0.0)
    decision = drive.ask(0.02, steer=0.3)
    assert near(decision, steer=0.008)
    assert decision.reasons == ("steer_rate", "not_armed")
    assert (decision.live, decision.engaged, decision.state) == (False, False, State.DRY)


def test_by_default_a_vehicle_is_real() -> None:
    gate = Guard(FIELD, vehicle="car", scenario="a.xosc", record=[].append)
    with pytest.raises(ArmingRefused, match="wrong vehicle"):
        gate.arm(0.0, Drive().motion)


def test_a_dry_run_has_no_latches() -> None:
    drive = Drive(armed=False)
    drive.motion = replace(drive.motion, override=True, emergency_stop=True)
    drive.gate.emergency_stop()
    assert drive.ask(0.0).state is State.DRY


def test_a_real_car_is_armed_by_its_name_and_a_humans_word() -> None:
    drive = Drive(FIELD, armed=False, real=True)
    drive.gate.arm(0.0, drive.motion, "car", KEY)
    assert drive.ask(0.0).state is State.ARMED


@pytest.mark.parametrize(
    ("named", "arming", "why"),
    [
        (None, KEY, "wrong vehicle"),
        ("cart", KEY, "wrong vehicle: it is 'car', but 'cart' was named"),
        ("car", None, "arming file"),
        ("car", replace(KEY, vehicle="cart"), "arming file"),
        ("car", replace(KEY, scenario="b.xosc"), "arming file: no arming for 'car' and 'a.xosc'"),
    ],
)
def test_with_one_key_or_a_wrong_one_it_stays_dry(named: str | None, arming: Arming | None, why: str) -> None:
    drive = Drive(FIELD, armed=False, real=True)
    with pytest.raises(ArmingRefused, match=why):
        drive.gate.arm(0.0, drive.motion, named, arming)
    assert drive.ask(0.0).state is State.DRY


def test_a_real_car_without_a_declared_area_is_never_armed() -> None:
    drive = Drive(LIMITS, armed=False, real=True)
    with pytest.raises(ArmingRefused, match="area"):
        drive.gate.arm(0.0, drive.motion, "car", KEY)


def test_an_arming_serves_once() -> None:
    drive = Drive(FIELD, armed=False, real=True)
    drive.gate.arm(0.0, drive.motion, "car", KEY)
    drive.gate.disarm()
    for again in (KEY, replace(KEY, written=0)):
        with pytest.raises(ArmingRefused, match="was used"):
            drive.gate.arm(0.0, drive.motion, "car", again)
    drive.gate.arm(0.0, drive.motion, "car", replace(KEY, written=2))
    assert drive.gate.state is State.ARMED


@pytest.mark.parametrize("latch", ["override", "emergency_stop"])
@pytest.mark.parametrize("real", [True, False])
def test_after_a_latch_every_vehicle_needs_both_keys(latch: str, real: bool) -> None:
    drive = Drive(FIELD, armed=False, real=real)
    drive.gate.arm(0.0, drive.motion, "car", KEY)
    drive.gate.cycle(0.0, None, replace(drive.motion, **{latch: True}))
    later = replace(KEY, written=2)
    for named, arming in ((None, None), ("car", None), (None, later)):
        with pytest.raises(ArmingRefused):
            drive.gate.arm(0.0, drive.motion, named, arming)
    drive.gate.arm(0.0, drive.motion, "car", later)
    assert drive.gate.state is State.ARMED


@pytest.mark.parametrize("button", ["override", "emergency_stop"])
@pytest.mark.parametrize("pressed", [True, None])
def test_nothing_is_armed_against_a_pressed_button(button: str, pressed: bool) -> None:
    drive = Drive(armed=False)
    with pytest.raises(ArmingRefused, match="pressed"):
        drive.gate.arm(0.0, replace(drive.motion, **{button: pressed}))


@pytest.mark.parametrize(("field", "value"), [("steer", nan), ("v", None), ("t", -0.1), ("t", 0.021), ("t", inf)])
def test_nothing_is_armed_without_a_fresh_measurement(field: str, value: float) -> None:
    drive = Drive(armed=False)
    with pytest.raises(ArmingRefused, match="measurement"):
        drive.gate.arm(0.0, replace(drive.motion, **{field: value}))
    drive.gate.arm(0.0, replace(drive.motion, t=-0.09))
    drive.gate.arm(0.0, replace(drive.motion, t=0.02), "car", KEY)


@pytest.mark.parametrize("now", [nan, None, inf])
def test_nothing_is_armed_at_no_time(now: float) -> None:
    with pytest.raises(ArmingRefused):
        Drive(armed=False).gate.arm(now, Drive().motion)


def test_a_command_of_before_the_arming_does_not_count() -> None:
    drive = Drive(armed=False)
    drive.ask(0.0)
    drive.gate.arm(0.01, drive.motion)
    assert is_stop(drive.wait(0.02), "no_command")


def test_armed_again_the_wheel_begins_where_it_is_and_the_brake_is_not_released_at_once() -> None:
    drive = Drive()
    drive.gate.emergency_stop()
    drive.ask(0.0)
    drive.gate.arm(0.0, replace(drive.motion, steer=0.2), "car", KEY)
    assert near(drive.ask(0.02, steer=0.2), steer=0.2, accel=-3.9, brake=0.5 - 0.1 / 8.0)


@pytest.mark.parametrize(("measured", "begins"), [(0.5, 0.35), (-0.5, -0.35)])
def test_a_wheel_measured_beyond_its_lock_begins_at_the_lock(measured: float, begins: float) -> None:
    assert is_stop(Drive(steer=measured).wait(0.0), "no_command", steer=begins)


def test_armed_while_a_dry_run_accelerates_traction_begins_at_nothing() -> None:
    drive = Drive(armed=False)
    drive.hold(0.4, accel=1.0, throttle=0.4)
    drive.gate.arm(0.4, replace(drive.motion, t=0.4))
    assert near(drive.ask(0.42, accel=1.0, throttle=0.4), accel=0.1, throttle=0.04)


def test_disarmed_nothing_of_the_drive_before_is_left() -> None:
    drive = Drive(steer=0.2)
    drive.ask(5.0, sequence=9, steer=0.2, brake=1.0)
    drive.gate.disarm()
    drive.gate.arm(0.0, drive.motion)
    assert is_stop(drive.wait(0.0), "no_command", steer=0.2)
    drive.gate.disarm()
    drive.gate.arm(0.0, replace(drive.motion, steer=0.0))
    assert drive.ask(0.0, sequence=1).output == Output()
