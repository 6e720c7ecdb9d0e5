"""The simulated test driver by its own rules: how fast, how far, how hard."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.manoeuvres.driving_limits import Envelope
from pytest_dvp.gap.manoeuvres.simulated_driver import PERIOD, Driver, DriverDemand, Motion
from pytest_dvp.gap.manoeuvres.simulated_driver import Test as Trial
from tests.unit.gap.drivers import ENVELOPE, driver


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
    assert d.car == Motion(0.0, 0.0, 0.0, 0.0)  # at rest, along x
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
    asked = driven(d.halt(), d, Motion(0.0, 0.0, 0.0, 3.0), 3000)
    assert {w.accel for w in asked} == {round(-0.6 * d.brake, 4)}  # for a minute, and for as long as the car rolls


def test_halting_asks_for_no_speed_even_of_a_car_that_rolls_on() -> None:
    """From 1.5 m/s on the speed asked for falls by what the brake takes off, and to nought."""
    d = driver()
    d._speed = 1.5
    speeds = [asked.speed for asked in driven(d.halt(), d, Motion(0.0, 0.0, 0.0, 1.5), most=100)]
    assert speeds == pytest.approx([max(1.5 - d.brake * PERIOD * k, 0.0) for k in range(1, 101)], abs=5.1e-4)


def _begun(d: Driver, car: Motion) -> Any:
    d.car = car
    return d.halt()
