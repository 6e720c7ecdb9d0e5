"""Any vehicle behind the gate: what reaches it, when, and what never does."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vehicle.adapter import Hands, Vehicle
from vehicle.guard.guard import ArmingRefused
from vehicle.guard.guarded_vehicle import GuardedVehicle, limits_of
from vehicle.guard.messages import Arming, Decision, Outcome, State
from vehicle.messages import (
    TRACE_COLUMNS,
    Command,
    FloatArray,
    Observation,
    Surroundings,
    VehicleDescription,
    VehicleState,
    no_surroundings,
)

SHEET = VehicleDescription(4.0, 2.0, 1.5, 2.5, 1.2, 0.35, 20.0, 2.5, 8.0, 1000.0)
FIELD = ((-500.0, -500.0), (500.0, -500.0), (500.0, 500.0), (-500.0, 500.0))
START = VehicleState(t=3.0, x=0.0, y=0.0, yaw=0.0, v=5.0)
KEY = Arming("car", "a.xosc", 1)


class Car:
    """Drives straight on at 5 m/s and remembers what it was told."""

    description = SHEET

    def __init__(self, is_real: bool = False) -> None:
        self.is_real = is_real
        self.told: list[Command] = []
        self.steps: list[float] = []
        self.stopped = self.closed = self.dead = False
        self.t = 0.0

    def reset(self, state: VehicleState) -> None:
        self.t = state.t

    def observe(self, surroundings: Surroundings) -> Observation:
        return Observation(t=self.t)

    def apply(self, command: Command) -> None:
        self.told.append(command)

    def step(self, dt: float) -> FloatArray:
        self.steps.append(dt)
        self.t += dt
        rows = np.zeros((0 if self.dead else 1, len(TRACE_COLUMNS)))
        rows[:, 0], rows[:, TRACE_COLUMNS.index("v")] = self.t, 5.0
        return rows

    def stop(self) -> None:
        self.stopped = True

    def close(self) -> None:
        self.closed = True


class DrivenCar(Car):
    """The same with a driver in it."""

    hands = Hands(override=False, emergency_stop=False)


def gated(car: Car) -> tuple[GuardedVehicle, list[Decision]]:
    log: list[Decision] = []
    return GuardedVehicle(car, limits_of(SHEET, area=FIELD), name="car", scenario="a.xosc", record=log.append), log


def command(t: float, brake: float = 0.0) -> Command:
    return Command(t=t, steer=0.0, accel=-8.0 * brake, throttle=0.0, brake=brake)


def test_it_is_a_vehicle_and_tells_what_the_car_is() -> None:
    assert isinstance(gated(Car())[0], Vehicle)
    assert gated(Car())[0].description is SHEET
    assert [gated(Car(real))[0].is_real for real in (False, True)] == [False, True]


def test_a_car_that_is_not_real_is_driven_after_its_reset() -> None:
    car = Car()
    vehicle, log = gated(car)
    assert not vehicle.armed
    vehicle.reset(START)
    assert vehicle.armed
    assert vehicle.observe(no_surroundings()).t == 3.0
    vehicle.apply(command(3.0, brake=0.2))
    assert car.told == [Command(3.0, 0.0, -1.6, 0.0, 0.2)]
    assert log[0].outcome is Outcome.PASSED


@pytest.mark.parametrize("throttle", [0.0, 1.0])
@pytest.mark.parametrize(("accel", "heard"), [(2.0, -4.0), (0.0, -4.0), (-0.5, -4.0), (-4.0, -4.0), (-6.0, -6.0)])
def test_a_car_that_obeys_the_acceleration_alone_brakes_as_the_pedal_asks(
    accel: float, heard: float, throttle: float
) -> None:
    """Half of the brake of a car that can do 8 m/s^2, whatever else is asked for."""
    car = Car()
    vehicle, log = gated(car)
    vehicle.reset(START)
    vehicle.apply(Command(3.0, 0.0, accel, throttle, 0.5))
    assert car.told == [Command(3.0, 0.0, heard, 0.0, 0.5)]
    assert ("brake_wins" in log[0].reasons) == (accel > 0.0)


@pytest.mark.parametrize("wrong", [None, "1", math.nan])
def test_a_brake_that_is_no_number_is_left_to_the_gate(wrong: float) -> None:
    car = Car()
    vehicle, log = gated(car)
    vehicle.reset(START)
    vehicle.apply(Command(3.0, 0.0, -1.0, 0.0, wrong))
    assert log[0].reasons == ("command_not_finite",)


def test_a_car_that_is_not_real_can_be_asked_for_both_keys_as_a_rehearsal() -> None:
    limits, log = limits_of(SHEET, area=FIELD), list[Decision]()
    vehicle = GuardedVehicle(Car(), limits, name="car", scenario="a.xosc", record=log.append, keys=True)
    assert (vehicle.is_real, vehicle.needs_keys, gated(Car())[0].needs_keys) == (False, True, False)
    vehicle.reset(START)
    assert not vehicle.armed
    with pytest.raises(ArmingRefused, match="arming file"):
        vehicle.reset(START, named="car", arming=Arming("car", "b.xosc", 1))
    vehicle.reset(START, named="car", arming=KEY)
    assert vehicle.armed
    nowhere = GuardedVehicle(Car(), limits_of(SHEET), name="car", scenario="a.xosc", record=log.append, keys=True)
    with pytest.raises(ArmingRefused, match="declared area"):
        nowhere.reset(START, named="car", arming=KEY)


def test_a_tick_of_50_ms_is_three_cycles_of_20_ms_at_most_and_no_motion_is_lost() -> None:
    car = Car()
    vehicle, log = gated(car)
    vehicle.reset(START)
    vehicle.apply(command(3.0))
    assert vehicle.step(0.05)[:, 0] == pytest.approx([3.02, 3.04, 3.05])
    assert car.steps == [0.02, 0.02, 0.01]
    assert [decision.t for decision in log] == pytest.approx([3.0, 3.02, 3.04])


def test_without_a_new_command_for_100_ms_the_car_is_braking_within_20_ms() -> None:
    car = Car()
    vehicle, _ = gated(car)
    vehicle.reset(START)
    vehicle.apply(command(3.0))
    for _ in range(4):
        vehicle.step(0.05)
    braking = [told.t for told in car.told if told.brake > 0.0]
    assert 3.1 - 1e-9 <= braking[0] <= 3.12 + 1e-9
    assert all(told.brake == 1.0 for told in car.told if told.t >= braking[0])


def test_a_car_that_falls_silent_is_stopped() -> None:
    car = Car()
    vehicle, log = gated(car)
    vehicle.reset(START)
    car.dead = True
    for k in range(4):
        vehicle.apply(command(3.0 + 0.05 * k))
        vehicle.step(0.05)
    assert log[-1].reasons == ("measurement_not_fresh",)


def test_a_senders_own_numbers_show_what_was_sent_twice() -> None:
    vehicle, log = gated(Car())
    vehicle.reset(START)
    for number in (7, 7):
        vehicle.apply(command(3.0), sequence=number)
    assert log[-1].reasons == ("command_out_of_order",)


def test_a_real_car_without_keys_is_a_dry_run() -> None:
    car = DrivenCar(is_real=True)
    vehicle, log = gated(car)
    vehicle.reset(START)
    vehicle.apply(command(3.0, brake=1.0))
    vehicle.step(0.05)
    vehicle.stop()
    assert not vehicle.armed
    assert car.told == []
    assert not car.stopped
    assert log[0].reasons == ("not_armed",)
    assert log[0].output.brake == 1.0


def test_a_real_car_drives_with_both_keys_once() -> None:
    car = DrivenCar(is_real=True)
    vehicle, _ = gated(car)
    vehicle.reset(START, named="car", arming=KEY)
    vehicle.apply(command(3.0))
    assert len(car.told) == 1
    with pytest.raises(ArmingRefused, match="was used"):
        vehicle.reset(START, named="car", arming=KEY)
    assert not vehicle.armed


@pytest.mark.parametrize(("named", "arming"), [("car", None), (None, KEY)])
def test_one_key_is_none(named: str | None, arming: Arming | None) -> None:
    vehicle, _ = gated(DrivenCar(is_real=True))
    with pytest.raises(ArmingRefused):
        vehicle.reset(START, named=named, arming=arming)


def test_a_real_car_is_armed_from_the_steering_angle_that_it_measures() -> None:
    """0.1 rad where the scenario has 0: held in the first cycle, then back by 0.4 rad/s for 20 ms. The run itself
    begins at its start, with nothing told to the car before."""

    class Steered(DrivenCar):
        def step(self, dt: float) -> FloatArray:
            rows = super().step(dt)
            rows[:, TRACE_COLUMNS.index("steer")] = 0.1
            return rows

    car = Steered(is_real=True)
    vehicle, log = gated(car)
    vehicle.reset(START, named="car", arming=KEY)
    assert car.told == []
    vehicle.apply(command(3.0))
    vehicle.step(0.04)
    assert [told.steer for told in car.told] == pytest.approx([0.1, 0.1 - 0.4 * 0.02])
    assert (log[0].t, car.t) == (3.0, pytest.approx(3.04))


@pytest.mark.parametrize(("late", "says"), [(None, "is missing: no motion within 0.2 s"), (0.1, "is missing or stale")])
def test_a_real_car_whose_own_motion_is_missing_or_old_is_not_armed(late: float | None, says: str) -> None:
    class Late(DrivenCar):
        def step(self, dt: float) -> FloatArray:
            rows = super().step(dt)
            rows[:, 0] -= late or 0.0
            return rows

    car = Late(is_real=True)
    car.dead = late is None
    vehicle, _ = gated(car)
    with pytest.raises(ArmingRefused, match=says):
        vehicle.reset(START, named="car", arming=KEY)
    assert not vehicle.armed


def test_a_real_car_that_cannot_tell_of_its_driver_is_not_armed() -> None:
    vehicle, _ = gated(Car(is_real=True))
    with pytest.raises(ArmingRefused, match="Supervised"):
        vehicle.reset(START, named="car", arming=KEY)


def test_nothing_is_armed_before_its_reset() -> None:
    with pytest.raises(ArmingRefused, match="reset comes first"):
        gated(Car())[0].arm()


def test_the_driver_takes_over_and_stop_leaves_the_car_to_him() -> None:
    car = DrivenCar()
    vehicle, log = gated(car)
    vehicle.reset(START)
    car.hands = Hands(override=True, emergency_stop=False)
    vehicle.apply(command(3.0))
    vehicle.step(0.02)
    vehicle.apply(command(3.02))
    assert log[-1].state is State.OVERRIDDEN
    vehicle.stop()
    assert not car.stopped


@pytest.mark.parametrize(
    ("hands", "state", "brake"), [(Hands(True, False), State.OVERRIDDEN, 0.0), (Hands(False, True), State.STOPPED, 1.0)]
)
def test_the_drivers_hands_count_while_no_motion_is_measured(hands: Hands, state: State, brake: float) -> None:
    """Seen within a cycle, and latched: released in the same outage, they still hold. An override has no brake."""
    car = DrivenCar()
    vehicle, log = gated(car)
    vehicle.reset(START)
    car.dead = True
    vehicle.apply(command(3.0))
    car.hands = hands
    vehicle.step(0.02)
    vehicle.apply(command(3.02))
    assert log[-1].state is state
    car.hands, car.dead = Hands(False, False), False
    vehicle.step(0.04)
    assert log[-1].state is state
    assert car.told[-1].brake == brake


@pytest.mark.parametrize("by", ["button", "call"])
def test_the_emergency_stop_latches_until_both_keys_are_given(by: str) -> None:
    car = DrivenCar()
    vehicle, log = gated(car)
    vehicle.reset(START)
    if by == "call":
        vehicle.emergency_stop()
    else:
        car.hands = Hands(override=False, emergency_stop=True)
        vehicle.step(0.02)
        car.hands = Hands(override=False, emergency_stop=False)
    vehicle.step(0.04)
    assert log[-1].state is State.STOPPED
    assert car.told[-1].brake == 1.0
    with pytest.raises(ArmingRefused, match="wrong vehicle"):
        vehicle.arm()
    vehicle.arm("car", KEY)
    assert vehicle.armed


def test_stop_brakes_with_what_the_car_can_do_and_close_ends_it() -> None:
    car = Car()
    vehicle, _ = gated(car)
    vehicle.reset(START)
    vehicle.stop()
    assert car.stopped
    vehicle.close()
    vehicle.close()
    assert car.closed
    assert not vehicle.armed


@pytest.mark.parametrize("dt", [0.0, -0.01])
def test_time_does_not_stand_still(dt: float) -> None:
    vehicle, _ = gated(Car())
    vehicle.reset(START)
    with pytest.raises(ValueError, match="not positive"):
        vehicle.step(dt)


def test_a_command_that_is_not_finite_never_reaches_the_car() -> None:
    car = Car()
    vehicle, _ = gated(car)
    vehicle.reset(START)
    vehicle.apply(Command(3.0, math.nan, 0.0, 0.0, 0.0))
    assert car.told == [Command(3.0, 0.0, -8.0, 0.0, 1.0)]


def test_limits_are_those_of_the_sheet_or_slower() -> None:
    assert limits_of(SHEET).max_speed == 20.0
    assert limits_of(SHEET, max_speed=5.0).max_speed == 5.0
    assert limits_of(SHEET, max_speed=50.0).max_speed == 20.0
    assert limits_of(SHEET, steer_rate=0.6).max_steer_rate == 0.6
    assert limits_of(SHEET).max_steer_rate == 0.4
