"""The guard: what passes, what is finite and fresh, the stop profile, the area. Times in s; a cycle is 20 ms."""

from __future__ import annotations

import ast
import math
from dataclasses import replace
from math import nan
from pathlib import Path

import pytest
from command_gate_drive import FIELD, KEY, LIMITS, NOT_NUMBERS, Drive, is_stop, near

import vehicle.guard.guard
import vehicle.guard.messages
from vehicle.guard.messages import Decision, Limits, Outcome, Output, Request, State, number

# --- what it is made of


@pytest.mark.parametrize("module", [vehicle.guard.guard, vehicle.guard.messages])
def test_it_needs_the_standard_library_only_and_fits_a_head(module: object) -> None:
    text = Path(str(module.__file__)).read_text(encoding="utf-8")
    imported = {n.module for n in ast.walk(ast.parse(text)) if isinstance(n, ast.ImportFrom)}
    assert imported <= {
        "__future__",
        "collections.abc",
        "dataclasses",
        "enum",
        "itertools",
        "math",
        "vehicle.guard.messages",
    }
    assert not [n for n in ast.walk(ast.parse(text)) if isinstance(n, ast.Import)]
    assert len(text.splitlines()) <= 300


def test_messages_cannot_be_changed() -> None:
    decision = Drive().ask(0.0)
    for thing in (LIMITS, KEY, decision, decision.output, decision.request, Drive().motion):
        with pytest.raises(AttributeError):
            setattr(thing, thing.__slots__[0], 1.0)


def test_what_a_log_shows_of_states_and_outcomes() -> None:
    assert [state.value for state in State] == ["dry", "armed", "overridden", "stopped"]
    assert [outcome.value for outcome in Outcome] == ["passed", "clamped", "stop", "handed_over"]


# --- pass


def test_a_command_within_all_bounds_passes_as_asked_and_both_are_logged() -> None:
    drive = Drive()
    drive.ask(0.0)
    decision = drive.ask(0.02, steer=0.005, accel=0.05, throttle=0.02)
    assert decision == Decision(
        0.02,
        Request(0.02, 2, 0.005, 0.05, 0.02, 0.0),
        Output(0.005, 0.05, 0.02, 0.0),
        Outcome.PASSED,
        (),
        State.ARMED,
    )
    assert decision.live
    assert decision.engaged
    assert drive.log[-1] is decision
    assert len(drive.log) == 2


def test_whole_numbers_are_numbers() -> None:
    decision = Drive().ask(0, steer=0, accel=-1, throttle=0, brake=1)
    assert decision.outcome is Outcome.PASSED
    assert [type(value) for value in (decision.output.steer, decision.output.brake)] == [float, float]


def test_a_first_command_finds_no_time_to_move_anything_but_the_brake() -> None:
    output = Drive(steer=0.1).ask(0.0, steer=0.2, accel=2.0, throttle=1.0).output
    assert output == Output(0.1, 0.0, 0.0, 0.0)


# --- finite


@pytest.mark.parametrize("field", ["t", "steer", "accel", "throttle", "brake"])
@pytest.mark.parametrize("value", NOT_NUMBERS, ids=repr)
def test_a_command_that_is_not_finite_is_a_stop_with_the_wheel_held(field: str, value: float) -> None:
    drive = Drive(steer=0.1)
    drive.ask(0.0, steer=0.1)
    request = replace(Request(0.02, 2, 0.1, 0.0, 0.0, 0.0), **{field: value})
    assert is_stop(drive.gate.cycle(0.02, request, replace(drive.motion, t=0.02)), "command_not_finite", steer=0.1)


@pytest.mark.parametrize("value", NOT_NUMBERS, ids=repr)
def test_a_number_of_a_command_that_is_none_is_a_stop(value: int) -> None:
    assert is_stop(Drive().gate.cycle(0.0, Request(0.0, value, 0, 0, 0, 0), Drive().motion), "command_not_finite")


@pytest.mark.parametrize("field", ["t", "x", "y", "yaw", "v", "steer"])
@pytest.mark.parametrize("value", NOT_NUMBERS, ids=repr)
def test_a_measurement_that_is_not_finite_is_a_stop(field: str, value: float) -> None:
    drive = Drive()
    request = Request(0.0, 1, 0.0, 0.0, 0.0, 0.0)
    decision = drive.gate.cycle(0.0, request, replace(drive.motion, **{field: value}))
    assert is_stop(decision, "measurement_not_finite")


def test_no_measurement_at_all_is_a_stop() -> None:
    drive = Drive()
    assert is_stop(drive.gate.cycle(0.0, Request(0.0, 1, 0, 0, 0, 0), None), "measurement_not_finite")


@pytest.mark.parametrize("now", NOT_NUMBERS, ids=repr)
def test_a_time_that_is_not_finite_is_a_stop_and_is_not_remembered(now: float) -> None:
    drive = Drive()
    drive.ask(0.0)
    assert is_stop(drive.gate.cycle(now, None, drive.motion), "measurement_not_finite")
    drive.ask(0.02, accel=-1.0, brake=0.5)
    assert drive.ask(0.04, accel=-4.0, brake=0.6).outcome is Outcome.PASSED


def test_after_a_bad_command_nothing_is_repeated_until_a_good_one_comes() -> None:
    drive = Drive()
    drive.ask(0.0, throttle=0.3)
    drive.ask(0.02, throttle=nan)
    assert is_stop(drive.wait(0.04), "no_command")
    assert is_stop(drive.wait(0.06), "no_command")
    assert drive.ask(0.08, brake=1.0).outcome is not Outcome.STOP


def test_numbers_end_below_1e12() -> None:
    below = math.nextafter(1e12, 0.0)
    assert [number(value) for value in (-1e12, -below, 0, below, 1e12)] == [False, True, True, True, False]


# --- fresh


def test_without_a_command_there_is_a_stop() -> None:
    assert is_stop(Drive().wait(0.0), "no_command")


def test_a_gate_that_was_never_asked_or_disarmed_holds_no_command() -> None:
    drive = Drive(armed=False)
    assert is_stop(drive.wait(0.0), "no_command")
    drive.ask(0.02)
    drive.gate.disarm()
    assert is_stop(drive.wait(0.04), "no_command")


def test_a_command_holds_for_less_than_100_ms_and_the_stop_comes_within_one_cycle_of_20_ms() -> None:
    drive = Drive(steer=0.1)
    drive.ask(0.0, steer=0.1)
    assert [drive.wait(t).outcome for t in (0.02, 0.04, 0.06, 0.08)] == [Outcome.PASSED] * 4
    assert is_stop(drive.wait(0.1), "command_not_fresh", steer=0.1)
    assert is_stop(drive.wait(0.12), "no_command", steer=0.1)


@pytest.mark.parametrize(("stamp", "fresh"), [(0.0, True), (-0.09, True), (-0.1, False), (0.02, True), (0.021, False)])
def test_a_command_is_fresh_below_100_ms_and_up_to_one_cycle_ahead(stamp: float, fresh: bool) -> None:
    decision = Drive().ask(0.0, stamp=stamp)
    assert (decision.outcome is Outcome.PASSED) == fresh
    assert fresh or decision.reasons == ("command_not_fresh",)


@pytest.mark.parametrize(("age", "fresh"), [(0.0, True), (0.09, True), (0.1, False), (-0.02, True), (-0.021, False)])
def test_a_measurement_ages_as_a_command_does(age: float, fresh: bool) -> None:
    drive = Drive()
    decision = drive.gate.cycle(0.0, Request(0.0, 1, 0.0, 0.0, 0.0, 0.0), replace(drive.motion, t=-age))
    assert (decision.outcome is Outcome.PASSED) == fresh
    assert fresh or is_stop(decision, "measurement_not_fresh")


@pytest.mark.parametrize("sequence", [1, 0, -5])
def test_a_number_that_does_not_grow_is_a_duplicate_or_late_and_a_stop(sequence: int) -> None:
    drive = Drive()
    drive.ask(0.0, sequence=1)
    assert is_stop(drive.ask(0.02, sequence=sequence), "command_out_of_order")
    assert is_stop(drive.wait(0.04), "no_command")
    assert drive.ask(0.06, sequence=2, brake=0.5, accel=-4.0).outcome is Outcome.PASSED


def test_a_stamp_may_repeat_but_not_go_back() -> None:
    drive = Drive()
    drive.ask(0.0, stamp=0.01)
    assert drive.ask(0.02, stamp=0.01).outcome is Outcome.PASSED
    assert is_stop(drive.ask(0.04, stamp=0.005), "command_out_of_order")


def test_a_stale_command_uses_up_no_number() -> None:
    drive = Drive()
    drive.hold(0.2)
    assert is_stop(drive.ask(0.22, stamp=0.1, sequence=50), "command_not_fresh")
    assert drive.ask(0.24, sequence=12, brake=0.5, accel=-4.0).outcome is Outcome.PASSED


def test_a_clock_that_steps_back_is_a_stop() -> None:
    drive = Drive()
    drive.ask(0.02)
    assert is_stop(drive.ask(0.01), "clock_stepped_back")


def test_two_cycles_at_one_time_are_no_step_back() -> None:
    drive = Drive()
    drive.ask(0.02)
    assert drive.ask(0.02).outcome is Outcome.PASSED


# --- stop profile


def test_the_stop_takes_traction_away_and_brakes_in_the_same_cycle() -> None:
    drive = Drive()
    assert drive.hold(0.4, accel=2.0, throttle=0.5).output.throttle == 0.5
    assert drive.ask(0.42, accel=nan).output == Output(0.0, -4.0, 0.0, 0.5)


def test_the_stop_never_releases_a_brake_that_was_harder() -> None:
    drive = Drive()
    drive.ask(0.0, accel=-8.0, brake=1.0)
    assert drive.ask(0.02, accel=nan).output == Output(0.0, -8.0, 0.0, 1.0)


def test_after_a_stop_the_brake_is_released_no_faster_than_5_m_s3() -> None:
    drive = Drive()
    drive.ask(0.0, accel=nan)
    decision = drive.ask(0.02, accel=1.0, throttle=1.0)
    # 5 m/s^3 for 20 ms is 0.1 m/s^2, of 8 m/s^2 that the whole brake does
    assert near(decision, accel=-3.9, brake=0.5 - 0.1 / 8.0)
    assert decision.reasons == ("jerk", "brake_release", "brake_wins")


# --- area


def place(x: float, y: float, v: float = 0.0, yaw: float = 0.0, limits: Limits = FIELD) -> Decision:
    """What becomes of a command at this place."""
    return Drive(limits, x=x, y=y, v=v, yaw=yaw).ask(0.0)


@pytest.mark.parametrize(("x", "y"), [(51.0, 0.0), (-51.0, 0.0), (0.0, 51.0), (0.0, -51.0), (200.0, 200.0)])
def test_outside_its_area_the_car_stops(x: float, y: float) -> None:
    assert is_stop(place(x, y), "area")


@pytest.mark.parametrize(("x", "y"), [(49.0, 0.0), (-49.0, 0.0), (0.0, 49.0), (0.0, -49.0), (-49.0, -49.0)])
def test_inside_it_does_not(x: float, y: float) -> None:
    assert place(x, y).outcome is Outcome.PASSED


def test_a_car_outside_stops_even_where_it_would_come_in() -> None:
    assert is_stop(place(-51.0, 0.0, v=10.0), "area")


def test_of_two_opposite_sides_one_belongs_to_the_area() -> None:
    assert place(-50.0, 0.0).outcome is Outcome.PASSED
    assert place(50.0, 0.0).outcome is Outcome.STOP


@pytest.mark.parametrize("yaw", [0.0, 0.5, 1.5708, 3.1416, -1.5708])
def test_it_stops_while_it_can_still_stop_inside(yaw: float) -> None:
    # 10 m/s: 1 m in 100 ms, then 100/(2*4) = 12.5 m
    far = 50.0 / max(abs(math.cos(yaw)), abs(math.sin(yaw))) - 13.5
    for spare, outcome in ((0.05, Outcome.PASSED), (-0.05, Outcome.STOP)):
        d = far - spare
        assert place(d * math.cos(yaw), d * math.sin(yaw), 10.0, yaw).outcome is outcome


def test_a_car_that_reverses_looks_behind() -> None:
    assert place(-36.4, 0.0, v=-10.0).outcome is Outcome.PASSED
    assert place(-36.6, 0.0, v=-10.0).outcome is Outcome.STOP
    assert place(45.0, 0.0, v=-10.0).outcome is Outcome.PASSED


SLANTED = ((0.0, 0.0), (20.0, 10.0), (0.0, 20.0), (5.0, 10.0))  # an arrow head with a notch behind


@pytest.mark.parametrize(
    ("x", "y", "inside"),
    [(8.0, 5.0, True), (8.0, 3.0, False), (6.0, 10.0, True), (4.0, 10.0, False), (1.9, 17.0, True), (1.0, 17.0, False)],
)
def test_an_area_may_have_slanted_sides_and_notches(x: float, y: float, inside: bool) -> None:
    decision = place(x, y, limits=replace(LIMITS, area=SLANTED))
    assert (decision.outcome is Outcome.PASSED) == inside


def test_an_area_is_forgiven_when_the_car_is_back_in_it() -> None:
    drive = Drive(FIELD, x=60.0)
    drive.ask(0.0)
    drive.motion = replace(drive.motion, x=0.0)
    assert drive.wait(0.02).outcome is Outcome.CLAMPED
