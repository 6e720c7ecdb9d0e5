"""The simulated test driver by its own rules: how fast, how far, how hard, and the shapes of the tests."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.manoeuvres.catalogue import MANOEUVRES
from pytest_dvp.gap.manoeuvres.circle_manoeuvres import HELD, SHARES, circles_both, circles_left, tight_circles
from pytest_dvp.gap.manoeuvres.driving_limits import Area, Envelope
from pytest_dvp.gap.manoeuvres.limit_violations import violations
from pytest_dvp.gap.manoeuvres.pedal_manoeuvres import (
    both_directions,
    brake_ramps,
    brake_steps,
    city,
    coast_down,
    full_throttle,
    held_steps,
    lift_offs,
    pedal_steps,
    small_pedal,
    standing_starts,
)
from pytest_dvp.gap.manoeuvres.simulated_drive import Drive, _set, columns, inputs_of
from pytest_dvp.gap.manoeuvres.simulated_driver import PERIOD, Driver, DriverDemand, Motion
from pytest_dvp.gap.manoeuvres.simulated_driver import Test as Trial
from pytest_dvp.gap.manoeuvres.steering_manoeuvres import (
    _doublet,
    _dwell,
    _sweep,
    _triangle,
    _wave,
    full_lock,
    growing_steps,
    sine_sweep,
    slalom,
    slow_ramp,
    small_steer,
    small_steps,
    step_steer,
)
from pytest_dvp.gap.manoeuvres.steering_robot import CommandPlayer
from vehicle.model.car import make_car
from vehicle.model.command_inputs import Inputs

ENVELOPE = Envelope(max_speed=10.0, max_acceleration=2.0, max_deceleration=4.0, max_lateral=4.0, length=100.0,
                    width=60.0, max_steer=0.45, steer_rate=1.0)  # fmt: skip


def driver(**given: Any) -> Driver:
    return Driver(ENVELOPE, 2.5, 3.0, **given)


def test_a_driver_keeps_some_of_each_limit_in_reserve() -> None:
    d = driver(size=0.49)
    assert d.top == pytest.approx(0.94 * 0.7 * 10.0)
    assert (d.push, d.brake) == pytest.approx((0.94 * 0.49 * 2.0, 0.94 * 0.49 * 4.0))
    assert d.lateral == pytest.approx(0.85 * 0.49 * 4.0)
    assert d.lock == pytest.approx(0.98 * 0.45)
    assert driver().top == pytest.approx(9.4)


def test_a_turn_is_as_wide_as_the_car_needs_and_as_the_ground_lets_it() -> None:
    usual = 1.3 * 2.5 / math.tan(0.85 * 0.98 * 0.45)
    assert driver().radius == pytest.approx(usual)
    assert Driver(ENVELOPE, 1.0, 1.0).radius == 6.0
    narrow = Driver(Envelope(width=30.0), 4.0, 4.0)
    assert narrow.radius == pytest.approx(0.24 * 30.0)
    assert driver().slow == pytest.approx(min(4.0, math.sqrt(0.7 * 0.85 * 4.0 * usual)))
    assert Driver(Envelope(max_speed=2.0), 2.5, 3.0).slow == pytest.approx(0.94 * 2.0)
    assert Driver(Envelope(max_lateral=1.0), 2.5, 3.0).slow == pytest.approx(math.sqrt(0.7 * 0.85 * usual))


def test_the_ground_lies_about_the_start() -> None:
    d = driver()
    turn = d.radius + 4.0
    assert d.straight == pytest.approx(100.0 - 2.0 * turn)
    assert d.area == pytest.approx((-turn, d.straight + turn, d.radius - 30.0, d.radius + 30.0))
    assert d._lanes == pytest.approx((0.0, d.straight))
    about = driver(round_about=True)
    assert about.area == pytest.approx((-50.0, 50.0, -4.0, 56.0))
    assert about._lanes == pytest.approx((-30.0, 30.0))
    assert Driver(Envelope(length=10.0), 2.5, 3.0).straight == 0.0


def test_a_steering_angle_is_wheelbase_over_radius_and_within_the_lock() -> None:
    d = driver()
    assert d.angle(8.0, 2.0) == pytest.approx(2.5 * 2.0 / 64.0)
    assert d.angle(0.1, 0.02) == pytest.approx(2.5 * 0.02 / 0.25)
    assert d.angle(1.0, 3.0) == d.lock


def test_the_way_of_a_test_is_that_of_reaching_it_the_test_and_slowing_down() -> None:
    d = driver()
    assert d._way(3.0, 2.0, 1.0) == pytest.approx((9.0 - 1.0) / (1.6 * d.push) + 6.0 + 1.0)
    assert d._way(8.0, 2.0, 9.0) == pytest.approx(16.0 + (64.0 - d.slow**2) / (1.2 * d.brake) + 1.0)
    assert d._way(0.0, 2.0, 0.0) == pytest.approx(1.0)


@pytest.mark.parametrize("share", [0.5, 1.0])
@pytest.mark.parametrize("seconds", [2.0, 5.0, 9.0])
def test_a_speed_fits_if_its_way_fits_on_the_straight(seconds: float, share: float) -> None:
    d = driver()
    v = d.fitting(seconds, share=share)
    assert v <= share * d.top
    assert v > d.slow - 0.1
    room = 0.96 * d.straight
    assert v <= d.slow or d._way(v, seconds, d.slow) <= room
    assert v == share * d.top or d._way(v + 0.1, seconds, d.slow) > room
    assert (share * d.top - v) / 0.1 == pytest.approx(round((share * d.top - v) / 0.1), abs=1e-6)


def test_at_the_slow_speed_a_test_fits_anyway() -> None:
    d = driver()
    assert d.slow - 0.1 < d.fitting(1000.0) <= d.slow


@pytest.mark.parametrize("back", [False, True])
def test_the_way_left_is_less_by_what_the_speed_and_the_heading_cost(back: bool) -> None:
    d = driver()
    d._back = back
    d.car = Motion(20.0, 0.0, (math.pi if back else 0.0) - 0.1, 5.0)
    gap = 20.0 if back else d.straight - 20.0
    assert d._heading_error() == pytest.approx(0.1)
    assert d._left() == pytest.approx(gap - 3.0 - d.radius * math.sin(0.1))
    d.car = Motion(20.0, 0.0, (math.pi if back else 0.0) + 0.1, 5.0)
    assert d._left() == pytest.approx(gap - 3.0)


def test_room_is_what_is_left_after_braking_before_the_border_or_the_turn() -> None:
    d = driver()
    d.car = Motion(10.0, 0.0, 0.0, 8.0)
    turn = d._left() - 1.0 - (64.0 - d.slow**2) / (1.2 * d.brake)
    assert d._room() == pytest.approx(turn)
    border = d.straight + d.radius + 4.0 - 4.0 - 10.0 - 2.4 - 64.0 / (2.0 * 0.9 * d.brake)
    assert border > turn
    about = driver(round_about=True)
    about.car = Motion(10.0, 20.0, 0.0, 8.0)
    assert about._room() == pytest.approx(50.0 - 4.0 - 10.0 - 2.4 - 64.0 / (2.0 * 0.9 * d.brake))
    assert about._room(0.6) == pytest.approx(36.0 - 2.4 - 64.0 / (1.2 * d.brake))
    d.car = Motion(10.0, 20.0, 0.5 * math.pi, 1.0)  # across the lane, the border is nearer than the turn
    assert d._room() == pytest.approx(d.radius + 30.0 - 4.0 - 20.0 - 0.3 - 1.0 / (1.8 * d.brake))


def test_the_foot_asks_in_proportion_to_what_lacks_and_never_hard() -> None:
    d = driver()
    d.car = Motion(0.0, 0.0, 0.0, 5.0)
    assert d._foot(5.5) == pytest.approx(0.8 * 0.5)
    assert d._foot(4.6) == pytest.approx(-0.8 * 0.4)
    assert d._foot(9.0) == d.push
    assert d._foot(0.0) == pytest.approx(-0.6 * d.brake)
    d.car = Motion(0.0, 0.0, 0.0, 0.14)
    assert d._foot(0.0) == -1.0
    d.car = Motion(0.0, 0.0, 0.0, 0.16)
    assert d._foot(0.0) == pytest.approx(-0.8 * 0.16)
    d.car = Motion(0.0, 0.0, 0.0, 0.0)
    assert d._foot(0.5) == pytest.approx(0.4)


@pytest.mark.parametrize("back", [False, True])
def test_the_lane_is_kept_by_aiming_at_a_point_ahead(back: bool) -> None:
    d = driver()
    d._back, d._lane = back, 2.0
    course = math.pi if back else 0.0
    for v, y, turned in ((1.0, 1.9, 0.02), (4.0, 2.1, 0.0), (6.0, 2.0, -0.01), (3.0, 2.0, 0.0)):
        d.car = Motion(5.0, y, course + turned, v)
        ahead = max(4.0, 1.5 * v)
        aside = (2.0 - y) * (-1.0 if back else 1.0)
        error = math.atan2(aside, ahead) - turned
        angle = math.atan(2.0 * 2.5 * math.sin(0.5 * math.pi * math.tanh(error)) / math.hypot(ahead, aside))
        assert d._keep() == pytest.approx(angle, abs=1e-12)
    d.car = Motion(5.0, 30.0, course, 8.0)
    assert abs(d._keep()) == pytest.approx(d.angle(8.0, 0.5 * d.lateral))
    assert (d._keep() < 0.0) != back


def ask(driving: Any, shown: Motion | None = None) -> DriverDemand:
    """What is asked for next."""
    return next(driving) if shown is None else driving.send(shown)


def test_demands_keep_within_the_limits_and_the_hand_turns_no_faster_than_it_may() -> None:
    d = driver()
    assert ask(d._tick(99.0, 0.0, None)).accel == pytest.approx(d.push, abs=1e-4)
    assert ask(d._tick(-99.0, 0.0, None)).accel == pytest.approx(-d.brake, abs=1e-4)
    d = driver()
    assert ask(d._tick(0.0, 0.3, None)).steer == pytest.approx(0.02)
    assert ask(d._tick(0.0, 0.3, None)).steer == pytest.approx(0.04)
    assert ask(d._tick(0.0, -9.0, None)).steer == pytest.approx(0.02)
    d._steer = 0.44
    assert ask(d._tick(0.0, 9.0, None)).steer == pytest.approx(d.lock, abs=1e-5)
    d._steer = -0.44
    assert ask(d._tick(0.0, -9.0, None)).steer == pytest.approx(-d.lock, abs=1e-5)


def test_a_pedal_asks_for_a_speed_as_well() -> None:
    d = driver()
    d.car = Motion(0.0, 0.0, 0.0, 5.0)
    d._speed = 5.0
    assert ask(d._tick(1.5, 0.0, None)).speed == pytest.approx(5.0 + 1.5 * PERIOD)
    assert ask(d._tick(0.0, 0.0, 9.0)).speed == pytest.approx(5.03 + d.push * PERIOD, abs=1e-3)
    d._speed = 5.0
    assert ask(d._tick(0.0, 0.0, 1.0)).speed == pytest.approx(5.0 - d.brake * PERIOD, abs=1e-3)
    d._speed = 5.0
    assert ask(d._tick(0.0, 0.0, 5.01)).speed == pytest.approx(5.01)
    for wish, car, shown in ((5.0, 2.5, 4.5), (5.0, 7.5, 5.5), (0.0, 0.0, 0.0)):
        d._speed, d.car = wish, Motion(0.0, 0.0, 0.0, car)
        assert ask(d._tick(-1.0 if wish == 0.0 else 0.0, 0.0, None)).speed == pytest.approx(shown)


def driven(driving: Any, d: Driver, car: Motion, most: int = 10_000) -> list[DriverDemand]:
    """What is asked for while the car does not move."""
    d.car = car
    asked = []
    try:
        asked.append(next(driving))
        while len(asked) < most:
            asked.append(driving.send(car))
    except StopIteration:
        pass
    return asked


def test_standing_takes_its_time_with_the_brake_on() -> None:
    d = driver()
    asked = driven(d.stand(1.0), d, Motion(0.0, 0.0, 0.0, 0.0))
    assert len(asked) == 50
    assert set(asked) == {DriverDemand(-1.0, 0.0, 0.0)}


@pytest.mark.parametrize(("v", "reached"), [(5.86, True), (5.84, False), (6.14, True), (6.16, False)])
def test_a_speed_is_reached_within_0_15_metres_a_second(v: float, reached: bool) -> None:
    d = driver()
    assert (driven(d.reach(6.0), d, Motion(5.0, 0.0, 0.0, v)) == []) is reached


def test_patience_ends_after_twelve_seconds_and_half_a_metre_before_the_end() -> None:
    d = driver()
    assert len(driven(d.reach(8.0), d, Motion(0.0, 0.0, 0.0, 1.0))) == 600
    d.car = Motion(0.0, 0.0, 0.0, 1.0)
    for left, asks in ((0.51, True), (0.49, False)):
        place = Motion(d._room() - left, 0.0, 0.0, 1.0)
        assert (len(driven(d.reach(8.0), d, place, 3)) > 0) is asks
        d.car = Motion(0.0, 0.0, 0.0, 1.0)


def test_a_test_asks_by_the_clock() -> None:
    d = driver()
    test = Trial(6.0, 1.0, steer=lambda tau: 0.01 * tau, pedal=lambda tau: tau)
    asked = driven(d.hold(test), d, Motion(5.0, 0.0, 0.0, 5.0))
    assert [a.accel for a in asked] == pytest.approx(PERIOD * np.arange(50))
    assert [a.steer for a in asked] == pytest.approx(0.01 * PERIOD * np.arange(50), abs=1e-5)
    d = driver()
    kept = driven(d.hold(Trial(6.0, 1.0)), d, Motion(5.0, 0.0, 0.0, 5.0))
    assert len(kept) == 50


def test_a_test_without_a_pedal_keeps_its_speed_and_without_steering_its_lane() -> None:
    d = driver()
    (first, *_) = driven(d.hold(Trial(6.0, 1.0)), d, Motion(5.0, 0.1, 0.0, 5.5))
    d.car = Motion(5.0, 0.1, 0.0, 5.5)
    assert first.accel == pytest.approx(d._foot(6.0), abs=1e-4)
    assert first.steer == pytest.approx(d._keep(), abs=1e-4)
    assert first.steer < 0.0


@pytest.mark.parametrize(("v", "ends"), [(0.51, False), (0.5, True)])
def test_a_test_is_over_at_its_end_speed_but_not_in_its_first_half_second(v: float, ends: bool) -> None:
    d = driver()
    asked = driven(d.hold(Trial(6.0, 2.0, pedal=lambda tau: -1.0, end=0.5)), d, Motion(5.0, 0.0, 0.0, v))
    assert len(asked) == (26 if ends else 100)


@pytest.mark.parametrize(
    ("v", "push", "asked"), [(9.41, 1.0, 0.0), (9.39, 1.0, 1.0), (9.5, -1.0, -1.0), (0.19, 0.0, -1.0), (0.19, 0.5, 0.5),
                             (0.21, 0.0, 0.0), (0.19, -3.0, -1.0)],
)  # fmt: skip
def test_no_pedal_exceeds_the_top_speed_and_a_standing_car_is_held(v: float, push: float, asked: float) -> None:
    d = Driver(Envelope(max_speed=10.0, length=2000.0), 2.5, 3.0)
    (first, *_) = driven(d.hold(Trial(5.0, 1.0, pedal=lambda tau: push)), d, Motion(0.0, 0.0, 0.0, v), 1)
    assert first.accel == pytest.approx(asked)


def test_a_test_ends_where_the_ground_does() -> None:
    d = driver()
    d.car = Motion(0.0, 0.0, 0.0, 1.0)
    room = d._room()
    assert driven(d.hold(Trial(1.0, 1.0)), d, Motion(room + 0.01, 0.0, 0.0, 1.0)) == []
    assert len(driven(d.hold(Trial(1.0, 1.0)), d, Motion(room - 0.01, 0.0, 0.0, 1.0))) == 50


def rolled(driving: Any, d: Driver, car: Motion, most: int = 20_000) -> list[tuple[DriverDemand, Motion]]:
    """A kinematic car that does what is asked for."""
    d.car = car
    path = []
    try:
        wish = next(driving)
        while len(path) < most:
            path.append((wish, car))
            v = max(car.v + wish.accel * PERIOD, 0.0)
            yaw = car.yaw + PERIOD * v * math.tan(wish.steer) / d.wheelbase
            car = Motion(car.x + PERIOD * v * math.cos(yaw), car.y + PERIOD * v * math.sin(yaw), yaw, v)
            wish = driving.send(car)
    except StopIteration:
        pass
    return path


def test_at_the_end_of_the_straight_it_turns_left_into_the_other_lane_and_back() -> None:
    d = driver()
    path = rolled(d.turn(), d, Motion(d.straight - 15.0, 0.0, 0.0, 6.0))
    assert d._back
    assert d._lane == pytest.approx(2.0 * d.radius)
    assert abs(math.remainder(math.pi - d.car.yaw, 2.0 * math.pi)) < 0.3
    assert d.car.y == pytest.approx(2.0 * d.radius, abs=1.5)
    assert max(m.x for _, m in path) < d.area.x_max - 3.0
    turning = [m.v for w, m in path if abs(w.steer) > 0.9 * math.atan(2.5 / d.radius)]
    assert max(turning) < d.slow + 1.0
    rolled(d.turn(), d, Motion(15.0, 2.0 * d.radius, math.pi, 6.0))
    assert not d._back
    assert d._lane == 0.0
    assert abs(math.remainder(d.car.yaw, 2.0 * math.pi)) < 0.3


def test_before_a_turn_the_speed_falls_as_fast_as_a_gentle_brake_allows() -> None:
    d = driver()
    for gap in (1.5, 4.0, 40.0):
        d.car = Motion(0.0, 0.0, 0.0, 3.0)
        place = Motion(d._left() - gap, 0.0, 0.0, 3.0)
        d.car = place
        assert d._left() == pytest.approx(gap)
        wanted = min(math.sqrt(d.slow**2 + 1.2 * d.brake * (gap - 1.0)), 0.6 * d.top)
        wanted = max(wanted, min(d.slow, wanted))
        first = ask(d.turn())
        assert first.accel == pytest.approx(max(min(0.8 * (wanted - 3.0), d.push), -0.6 * d.brake), abs=1e-4)


def test_a_turn_at_once_begins_where_the_car_is() -> None:
    d = driver()
    lanes = (d.area.x_min + 4.0, d.area.x_max - 4.0)
    path = rolled(d.other_side(), d, Motion(30.0, 0.0, 0.0, d.slow))
    assert d._lanes == pytest.approx(lanes)
    assert d._back
    assert max(m.x for _, m in path) == pytest.approx(30.0 + d.radius, abs=3.0)


def test_a_circle_has_its_turns_its_seconds_and_ends_at_the_border() -> None:
    d = driver(round_about=True)
    angle = math.atan(2.5 / 10.0)
    path = rolled(d.circle(3.0, angle, turns=1.0), d, Motion(0.0, 10.0, 0.0, 3.0))
    assert path[-1][1].yaw == pytest.approx(2.0 * math.pi, abs=0.02)
    assert len(path) * PERIOD * 3.0 == pytest.approx(2.0 * math.pi * 10.0, rel=0.02)
    d = driver(round_about=True)
    assert len(driven(d.circle(3.0, angle, seconds=7.0), d, Motion(0.0, 10.0, 0.0, 3.0))) == 350
    assert driven(d.circle(3.0, angle), d, Motion(47.0, 10.0, 0.0, 3.0)) == []
    assert driven(d.circle(3.0, angle), d, Motion(0.0, 53.0, 0.0, 3.0)) == []
    assert len(driven(d.circle(3.0, angle), d, Motion(45.0, 10.0, 0.0, 3.0), 5)) == 5


def test_a_circle_is_closed_slowly_and_where_it_began() -> None:
    d = driver(round_about=True)
    angle = math.atan(2.5 / d.radius)
    path = rolled(d.close_circle(angle), d, Motion(0.0, 20.0, 1.0, 7.0))
    end = path[-1][1]
    assert abs(math.remainder(d.car.yaw, 2.0 * math.pi)) < 0.1
    assert d.car.v < d.slow + 0.3
    assert end.yaw > 2.0 * math.pi - 0.3
    assert driven(d.close_circle(angle), d, Motion(0.0, 20.0, 2.0 * math.pi + 0.09, d.slow)) == []
    assert driven(d.close_circle(angle), d, Motion(0.0, 20.0, 0.11, d.slow), 1) != []
    assert driven(d.close_circle(angle), d, Motion(0.0, 20.0, 0.0, d.slow + 0.31), 1) != []


def test_halting_brakes_to_a_tenth_and_stands_a_second_and_a_half() -> None:
    d = driver()
    path = rolled(d.halt(), d, Motion(5.0, 0.0, 0.0, 5.0))
    braking = [w.accel for w, m in path if m.v >= 0.1]
    assert set(braking) == {round(-0.6 * d.brake, 4)}
    assert len(path) - len(braking) == 75
    assert {w.speed for w, _ in path[-5:]} == {0.0}
    d = driver()
    d.car = Motion(0.0, 0.0, 0.0, 5.0)
    near = Motion(d._room(0.6) - 0.9, 0.0, 0.0, 5.0)
    assert ask(_begun(d, near)).accel == pytest.approx(-d.brake, abs=1e-4)
    far = Motion(near.x - 0.2, 0.0, 0.0, 5.0)
    assert ask(_begun(d, far)).accel == pytest.approx(-0.6 * d.brake, abs=1e-4)
    d = driver()
    assert len(driven(d.halt(), d, Motion(0.0, 0.0, 0.0, 3.0))) == 1000 + 75  # 20 s of patience


def _begun(d: Driver, car: Motion) -> Any:
    d.car = car
    return d.halt()


class Listener(Driver):
    """Notes the tests and circles of a manoeuvre instead of driving them."""

    def __init__(self, envelope: Envelope = ENVELOPE, **given: Any) -> None:
        super().__init__(envelope, 2.5, 3.0, **given)
        self.wanted: list[Trial] = []
        self.notes: list[tuple[Any, ...]] = []

    def tests(self, wanted: Any) -> Any:
        self.wanted = list(wanted)
        return iter(())

    def note(self, *what: Any) -> Any:
        self.notes.append(what)
        return iter(())

    def stand(self, seconds: float) -> Any:
        return self.note("stand", seconds)

    def reach(self, speed: float) -> Any:
        return self.note("reach", speed)

    def other_side(self) -> Any:
        return self.note("other side")

    def close_circle(self, angle: float) -> Any:
        return self.note("close", angle)

    def halt(self) -> Any:
        return self.note("halt")

    def circle(self, speed: float, angle: float, *, turns: float = math.inf, seconds: float = 60.0) -> Any:
        return self.note("circle", speed, angle, turns, seconds)


def listened(manoeuvre: Any, **given: Any) -> Listener:
    d = Listener(**given)
    list(manoeuvre(d))
    return d


def test_speeds_and_durations_of_the_pedal_tests() -> None:
    d = listened(coast_down)
    fast, half = d.fitting(2.5), d.fitting(5.0, share=0.5)
    assert [(t.speed, t.seconds, t.end) for t in d.wanted] == [(fast, 2.5, None)] * 2 + [(half, 5.0, None)] * 2 + [
        (2.5, 6.0, 0.15)
    ]
    assert all(t.pedal is not None and t.pedal(1.0) == 0.0 for t in d.wanted)
    d = listened(full_throttle)
    assert [t.seconds for t in d.wanted] == [1.5, 12.0, 2.0] * 2
    assert {t.speed for t in d.wanted} == {0.0}
    assert [t.pedal(0.5) for t in d.wanted] == pytest.approx([-1.0, d.push, -1.0, -1.0, 0.5 * d.push, -1.0])  # type: ignore[misc]
    d = listened(standing_starts)
    assert [(t.speed, t.seconds) for t in d.wanted] == [(0.0, 3.0), (0.0, 2.5), (d.slow, 4.0)] * 3
    assert [t.pedal(0.5) for t in d.wanted[1::3]] == pytest.approx([0.25 * d.push, 0.5 * d.push, d.push])  # type: ignore[misc]
    assert all(t.pedal(0.5) == -1.0 for t in d.wanted[::3])  # type: ignore[misc]
    assert all(t.pedal(0.5) == pytest.approx(-0.5 * d.brake) and t.end == 0.1 for t in d.wanted[2::3])  # type: ignore[misc]
    d = listened(both_directions)
    assert [(t.speed, t.seconds, t.pedal) for t in d.wanted] == [
        (d.fitting(3.5, share=s), 3.5, None) for s in (0.35, 0.35, 1.0, 1.0)
    ]
    d = listened(lift_offs)
    assert [t.speed for t in d.wanted] == [d.fitting(3.5, share=s) for s in (0.3, 0.5, 0.7, 0.85)]
    assert [t.pedal(0.99) for t in d.wanted] == pytest.approx([0.5 * d.push] * 4)  # type: ignore[misc]
    assert [t.pedal(1.0) for t in d.wanted] == [0.0] * 4  # type: ignore[misc]
    assert {t.seconds for t in d.wanted} == {3.5}


def test_brake_steps_grow_to_the_hardest_and_are_released_once() -> None:
    d = listened(brake_steps)
    assert [(t.speed, t.seconds, t.end) for t in d.wanted] == [(d.fitting(2.5, share=0.9), 3.0, 0.5)] * 4
    for test, size in zip(d.wanted, (0.25, 0.5, 0.75, 1.0), strict=True):
        assert test.pedal is not None
        assert [test.pedal(tau) for tau in (0.0, 0.69, 0.7, 1.2, 1.21)] == pytest.approx(
            [-size * d.brake, -size * d.brake, 0.0, 0.0, -size * d.brake]
        )
    d = listened(brake_ramps)
    assert [(t.speed, t.seconds, t.end) for t in d.wanted] == [(d.fitting(3.0, share=0.9), 5.0, 0.15)] * 2
    for test, seconds in zip(d.wanted, (3.0, 1.0), strict=True):
        assert test.pedal is not None
        assert [test.pedal(tau) for tau in (0.0, 0.5, 5.0)] == pytest.approx([0.0, -d.brake * 0.5 / seconds, -d.brake])


def test_pedal_steps_are_equal_to_both_sides() -> None:
    for manoeuvre, speed, seconds, hold, sizes in (
        (pedal_steps, 0.45, 6.0, 1.0, (0.3, 0.6, 1.0)), (held_steps, 0.4, 8.0, 2.0, (0.5, 1.0)),
    ):  # fmt: skip
        d = listened(manoeuvre)
        assert [(t.speed, t.seconds) for t in d.wanted] == [(speed * d.top, seconds)] * len(sizes)
        for test, size in zip(d.wanted, sizes, strict=True):
            assert test.pedal is not None
            signs = [test.pedal((k + 0.5) * hold) / (size * d.push) for k in range(5)]
            assert signs == pytest.approx([1.0, 0.0, -1.0, 0.0, 1.0])
    d = listened(small_pedal)
    assert [t.pedal(0.5) for t in d.wanted] == pytest.approx([0.08, 0.16, 0.3, 0.5])  # type: ignore[misc]
    assert {(t.speed, t.seconds) for t in d.wanted} == {(min(5.0, d.fitting(6.0)), 6.0)}


def test_a_drive_about_town_is_gentle() -> None:
    d = listened(city)
    v = min(7.0, d.fitting(5.0))
    assert [(t.speed, t.seconds) for t in d.wanted] == [(v, 5.0), (v, 3.0), (0.5 * v, 4.0)]
    swerve = d.wanted[0].steer
    assert swerve is not None
    assert swerve(1.25) == pytest.approx(d.angle(v, 0.2 * d.lateral))
    assert swerve(2.5) == pytest.approx(0.0, abs=1e-12)


def test_shapes_of_the_steering() -> None:
    step = _doublet(0.1, 1.3)
    assert [step(t) for t in (0.0, 1.29, 1.3, 2.59, 2.6)] == [0.1, 0.1, -0.1, -0.1, 0.0]
    wave = _wave(0.1, 0.5)
    assert [wave(t) for t in (0.0, 0.5, 1.0, 2.0)] == pytest.approx([0.1, 0.0, -0.1, 0.1], abs=1e-12)
    sweep = _sweep(0.1, 0.4, 2.5, 6.0)
    phase = 0.4 * 3.0 + 0.5 * 2.1 / 6.0 * 9.0
    assert sweep(3.0) == pytest.approx(0.1 * math.cos(2.0 * math.pi * phase))
    assert sweep(0.0) == 0.1
    triangle = _triangle(0.1, 4.0)
    assert [triangle(t) for t in (0.0, 0.5, 1.0, 2.0, 2.5, 3.0)] == pytest.approx(
        [0.0, 0.05, 0.1, 0.0, -0.05, -0.1], abs=1e-12
    )
    dwell = _dwell(0.1)
    peak = 0.75 / 0.7
    assert dwell(0.25 / 0.7) == pytest.approx(0.1)
    assert [dwell(peak + t) for t in (-1e-9, 0.0, 0.25, 0.5)] == pytest.approx([-0.1] * 4)
    assert dwell(peak + 0.5 + 0.125 / 0.7) == pytest.approx(-0.1 * math.sin(math.pi / 4.0))
    assert dwell(1.0 / 0.7 + 0.5) == 0.0


def test_speeds_and_sizes_of_the_steering_tests() -> None:
    d = listened(step_steer)
    v = d.fitting(4.0)
    assert [t.speed for t in d.wanted] == [3.0, 0.55 * d.top, v, v]
    assert [t.steer(0.5) for t in d.wanted] == pytest.approx(  # type: ignore[misc]
        [d.angle(s, 0.6 * d.lateral) * side for s, side in ((3.0, 1), (0.55 * d.top, 1), (v, 1), (v, -1))]
    )
    assert {t.seconds for t in d.wanted} == {4.0}
    d = listened(growing_steps)
    assert [t.steer(0.5) for t in d.wanted] == pytest.approx(  # type: ignore[misc]
        [min(s, d.angle(3.0, 0.6 * d.lateral)) * side for s in (0.05, 0.1, 0.2, 0.35) for side in (1.0, -1.0)]
    )
    assert {(t.speed, t.seconds) for t in d.wanted} == {(3.0, 3.2)}
    d = listened(full_lock)
    assert {t.speed for t in d.wanted} == {min(2.0, math.sqrt(0.8 * d.lateral * 2.5 / d.lock))}
    for test, side in zip(d.wanted, (1.0, -1.0), strict=True):
        assert test.steer is not None
        shown = [test.steer(tau) / d.lock * side for tau in (0.0, 1.25, 2.5, 6.0, 7.0, 8.0, 9.0)]
        assert shown == pytest.approx([0.0, 0.5, 1.0, 1.0, 0.5, 0.0, 0.0])
    d = listened(slow_ramp)
    for test, (share, side) in zip(d.wanted, [(s, k) for s in (0.6, 1.0) for k in (1.0, -1.0)], strict=True):
        v = d.fitting(6.0, share=share)
        assert (test.speed, test.seconds) == (v, 6.0)
        assert test.steer is not None
        assert test.steer(1.4) == pytest.approx(side * d.angle(v, 0.95 * d.lateral))
    d = listened(sine_sweep)
    assert [t.speed for t in d.wanted] == [d.fitting(6.0, share=s) for s in (0.6, 0.6, 1.0, 1.0)]
    d = listened(slalom)
    assert [(t.speed, t.seconds) for t in d.wanted] == [(d.fitting(s), s) for s in (5.0, 5.0, 4.0, 4.0)]
    assert [t.steer(0.0) for t in d.wanted] == pytest.approx(
        [d.angle(d.fitting(s), 0.8 * d.lateral) for s in (5.0, 5.0, 4.0, 4.0)]
    )  # type: ignore[misc]
    assert [t.steer(h / 4.0) for t, h in zip(d.wanted, (2.0, 2.0, 1.0, 1.0), strict=True)] == pytest.approx(
        [0.0] * 4, abs=1e-12
    )  # type: ignore[misc]
    d = listened(small_steer)
    assert [t.steer(1.25 / 4.0) for t in d.wanted] == pytest.approx([0.006, 0.012, 0.025, 0.05])  # type: ignore[misc]
    d = listened(small_steps)
    for test, size in zip(d.wanted, (0.004, 0.01, 0.02, 0.04), strict=True):
        assert test.steer is not None
        stairs = [test.steer(0.8 * k + 0.4) / size for k in range(9)]
        assert stairs == pytest.approx([1.0, 2.0, 1.0, 0.0, -1.0, -2.0, -1.0, 0.0, 0.0])


def test_circles_grow_in_speed_by_shares_of_the_lateral_acceleration() -> None:
    d = listened(circles_left, round_about=True)
    radius = 0.5 * 60.0 - 1.6 * 4.0
    circles = [note for note in d.notes if note[0] == "circle"]
    assert d.notes[0] == ("stand", 1.0)
    assert d.notes[-1] == ("halt",)
    assert circles == [
        (
            "circle",
            min(math.sqrt(share * d.lateral * radius), d.top),
            pytest.approx(math.atan(2.5 / radius)),
            math.inf,
            HELD,
        )
        for share in SHARES
    ]
    assert SHARES == (0.08, 0.3, 0.6, 0.9)


def test_circles_to_both_sides_leave_room_for_the_turn() -> None:
    d = listened(circles_both, round_about=True)
    radius = max(min(0.5 * (60.0 - 2.0 * d.radius - 12.0), 50.0 - 8.0), d.radius)
    names = [note[0] for note in d.notes]
    assert names == ["stand", *["circle"] * 4, "close", "other side", *["circle"] * 4, "halt"]
    assert d.notes[5][1] == pytest.approx(math.atan(2.5 / radius))
    angles = [note[2] for note in d.notes if note[0] == "circle"]
    assert angles == pytest.approx([math.atan(2.5 / radius)] * 4 + [-math.atan(2.5 / radius)] * 4)


def test_tight_circles_make_a_figure_of_eight_at_walking_speed() -> None:
    d = listened(tight_circles)
    radius = 1.1 * 2.5 / math.tan(0.9 * d.lock)
    v = min(2.0, math.sqrt(0.7 * d.lateral * radius))
    assert d.notes[:3] == [("stand", 1.0), ("reach", d.slow), ("other side",)]
    assert [note[1:4] for note in d.notes[3:5]] == [
        (v, pytest.approx(s * math.atan(2.5 / radius)), 1.0) for s in (1.0, -1.0)
    ]
    assert len({m.name for m in MANOEUVRES}) == len(MANOEUVRES)


CAR = make_car({"wheelbase": 2.45, "cg_to_front_axle": 1.15, "mass": 1150.0})


def drive_of(v: float, n: int = 100, **given: float) -> tuple[Any, ...]:
    t = 0.02 * np.arange(n)
    motion = np.zeros((n, 5))
    motion[:, 3] = v
    for name, value in given.items():
        motion[:, {"x": 0, "y": 1, "yaw": 2, "rate": 4}[name]] = value
    return t, motion, np.zeros(n)


BIG = Area(-50.0, 50.0, -30.0, 30.0)


def test_what_keeps_within_the_limits_violates_nothing() -> None:
    t, motion, steer = drive_of(10.0, rate=0.4)
    steer[:] = -0.45
    assert violations(t, motion, steer, ENVELOPE, BIG, CAR) == ()


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_each_limit_is_told_just_beyond_it(sign: float) -> None:
    t, motion, steer = drive_of(sign * 10.01)
    assert violations(t, motion, steer, ENVELOPE, BIG, CAR) == ("speed 10, at most 10 m/s",)
    t, motion, steer = drive_of(5.0, rate=sign * 0.81)
    assert violations(t, motion, steer, ENVELOPE, BIG, CAR) == ("lateral acceleration 4.05, at most 4 m/s^2",)
    t, motion, steer = drive_of(5.0)
    steer[7] = sign * 0.46
    assert violations(t, motion, steer, ENVELOPE, BIG, CAR) == ("steering 0.46, at most 0.45 rad",)
    for slope, told in ((1.99, ()), (2.02, ("acceleration 2.02, at most 2 m/s^2",)), (-3.99, ()),
                        (-4.02, ("deceleration 4.02, at most 4 m/s^2",))):  # fmt: skip
        motion[:, 3] = 5.0 + slope * (t - 1.0)
        assert violations(t, motion, np.zeros(100), ENVELOPE, BIG, CAR) == told


def test_an_acceleration_is_that_over_a_tenth_of_a_second() -> None:
    t, motion, steer = drive_of(5.0)
    motion[50, 3] = 5.19  # for a row: 9.5 m/s^2 from row to row, 1.9 over five
    assert violations(t, motion, steer, ENVELOPE, BIG, CAR) == ()
    motion[50, 3] = 5.21
    assert len(violations(t, motion, steer, ENVELOPE, BIG, CAR)) == 1


def test_no_corner_of_the_car_leaves_the_ground() -> None:
    ahead, behind, side = CAR.center_x + 0.5 * CAR.length, CAR.center_x - 0.5 * CAR.length, 0.5 * CAR.width
    for yaw, limits in (
        (0.0, (-50.0 - behind, 50.0 - ahead, -30.0 + side, 30.0 - side)),
        (0.5 * math.pi, (-50.0 + side, 50.0 - side, -30.0 - behind, 30.0 - ahead)),
    ):
        for k, value in enumerate(limits):
            out = -1.0 if k % 2 == 0 else 1.0
            where = {"x": 0.0, "y": 0.0, ("x" if k < 2 else "y"): value}
            for off, words in ((-0.01, ()), (0.02, ("the area of 100 x 60 m, by 0.02 m",))):
                place = dict(where)
                place["x" if k < 2 else "y"] += off * out
                assert violations(*drive_of(1.0, yaw=yaw, **place), ENVELOPE, BIG, CAR) == words


def test_an_acceleration_becomes_shares_of_full_pedals() -> None:
    inputs = Inputs(
        longitudinal=("throttle_cmd", "brake_pressure"), full_throttle=2.5, full_brake=8.0, full_pressure=60.0
    )
    accel = np.array([1.0, -2.0, 9.0, -20.0])
    found = inputs_of(inputs, accel, np.array([1.0, 2.0, 3.0, 4.0]))
    assert list(found) == ["throttle_cmd", "brake_pressure"]
    assert found["throttle_cmd"] == pytest.approx([0.4, 0.0, 1.0, 0.0])
    assert found["brake_pressure"] == pytest.approx([0.0, 15.0, 0.0, 60.0])
    current = inputs_of(
        Inputs(longitudinal=("motor_current",), full_throttle=2.0, full_brake=4.0, full_current=30.0), accel, accel
    )
    assert current["motor_current"] == pytest.approx([15.0, -15.0, 30.0, -30.0])
    assert inputs_of(Inputs(longitudinal=("speed_cmd",)), accel, np.arange(4.0))["speed_cmd"].tolist() == [
        0.0,
        1.0,
        2.0,
        3.0,
    ]


@pytest.mark.parametrize(
    ("name", "value", "row"),
    [("accel_cmd", 0.5, [0, 0.5, 0, 0, 0, 0]), ("throttle_cmd", 0.5, [0, 0, 0.5, 0, 0, 0]),
     ("brake_cmd", 0.5, [0, 0, 0, 0.5, 0, 0]), ("speed_cmd", 0.5, [0, 0, 0, 0, 0.5, 0]),
     ("v", 0.5, [0, 0, 0, 0, 0, 0.5]),
     ("brake_pressure", 30.0, [0, 0, 0, 0.5, 0, 0]), ("motor_current", 12.0, [0, 0, 0.4, 0, 0, 0]),
     ("motor_current", -12.0, [0, 0, 0, 0.4, 0, 0])],
)  # fmt: skip
def test_an_input_has_its_place_in_the_row_of_the_kernel(name: str, value: float, row: list[float]) -> None:
    inputs = Inputs(full_pressure=60.0, full_current=30.0)
    found = np.zeros((1, 6))
    _set(found, inputs, name, value)
    assert found[0] == pytest.approx(row)


def test_commands_of_a_drive_are_in_the_scale_of_their_columns() -> None:
    inputs = Inputs(steer="wheel", longitudinal=("accel_cmd",), steer_scale=0.5, steer_zero=0.1)
    wishes = np.array([[1.0, 0.3, 5.0], [-2.0, -0.1, 4.0]])
    drive = Drive(MANOEUVRES[0], 1.0, BIG, np.array([0.0, 0.02]), wishes, np.zeros((2, 5)))
    found = columns(drive, inputs)
    assert list(found) == ["t", "wheel", "accel_cmd"]
    assert found["wheel"] == pytest.approx([0.4, -0.4])
    assert found["accel_cmd"].tolist() == [1.0, -2.0]
    assert drive.seconds == 0.02


def test_a_robot_plays_the_command_of_now_and_shares_of_the_pedals(tmp_path: Path) -> None:
    path = tmp_path / "wanted.csv"
    path.write_text(
        "wanted_accel [m/s^2],t [s],wanted_steer [rad]\n1,0,0.1\n-3,0.5,0.2\n9,1,0.3\n-20,1.5,0.4\n-1,2,0.5\n"
    )
    robot = CommandPlayer(path, SimpleNamespace(max_acceleration=2.0, max_deceleration=6.0))  # type: ignore[arg-type]
    asked = [robot.tick(SimpleNamespace(t=t)) for t in (-1.0, 0.0, 0.49, 0.5, 1.2, 1.5, 2.0, 99.0)]  # type: ignore[arg-type]
    assert [c.t for c in asked] == [-1.0, 0.0, 0.49, 0.5, 1.2, 1.5, 2.0, 99.0]
    assert [c.steer for c in asked] == [0.1, 0.1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.5]
    assert [c.accel for c in asked] == [1.0, 1.0, 1.0, -3.0, 9.0, -20.0, -1.0, -1.0]
    assert [c.throttle for c in asked] == [0.5, 0.5, 0.5, 0.0, 1.0, 0.0, 0.0, 0.0]
    assert [c.brake for c in asked] == pytest.approx([0.0, 0.0, 0.0, 0.5, 0.0, 1.0, 1.0 / 6.0, 1.0 / 6.0])
