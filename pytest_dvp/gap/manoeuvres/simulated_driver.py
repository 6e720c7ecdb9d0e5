"""A test driver in a bounded area: straights there and back with tests on them, circles, stops.

The tests are open loop, as a steering robot or a foot does them; between them the driver keeps the lane and the speed.
A manoeuvre is a generator: it yields what it asks for and is sent the motion that came of it, 50 times a second. So the
same manoeuvre drives a model, a simulated truth and, through a robot, a car.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Sequence
from typing import NamedTuple, TypeAlias

from pytest_dvp.gap.manoeuvres.driving_limits import Area, Envelope

PERIOD = 0.02  # s, a command holds
REACH = 1.5  # s ahead, where the driver looks
NEAR = 4.0  # m, at least
CARE = 0.94  # of each limit that is used
GENTLE = 0.5  # of the lateral acceleration, between tests
FOOT = 0.8  # 1/s, acceleration asked for per speed that lacks
STAND = -1.0  # m/s^2, the brake that holds a standing car
PATIENCE = 12.0  # s to reach a speed
EDGE = 1.0  # m that are kept free at the border


class Motion(NamedTuple):
    """What the driver sees: rear axle [m], yaw [rad], speed [m/s]."""

    x: float
    y: float
    yaw: float
    v: float


class DriverDemand(NamedTuple):
    """What the driver asks for: acceleration [m/s^2], road-wheel angle [rad], the same as a speed [m/s]."""

    accel: float
    steer: float
    speed: float


Driving: TypeAlias = Generator[DriverDemand, Motion, None]
Shape: TypeAlias = Callable[[float], float]
"""Of the time [s] since a test began."""


class Test(NamedTuple):
    """One test: reach `speed` [m/s] on the straight, then for `seconds` steer [rad] and pedal [m/s^2] by the clock.

    Without `steer` the lane is kept, without `pedal` the speed. `end`: the speed [m/s] at which it is over.
    """

    speed: float
    seconds: float
    steer: Shape | None = None
    pedal: Shape | None = None
    end: float | None = None


class Driver:
    """Drives one manoeuvre within an envelope.

    wheelbase [m]; length, front [m]: of the car, and how far it stands out ahead of its rear axle; `size` (0..1] makes
    everything smaller. `round_about` starts at the middle of the lower side, for circles; else in the lower left.
    """

    def __init__(self, envelope: Envelope, wheelbase: float, front: float, *, size: float = 1.0,
                 round_about: bool = False) -> None:  # fmt: skip
        self.wheelbase = wheelbase
        self.top = CARE * math.sqrt(size) * envelope.max_speed
        self.push, self.brake = CARE * size * envelope.max_acceleration, CARE * size * envelope.max_deceleration
        self.lateral = 0.85 * size * envelope.max_lateral
        self.lock = 0.98 * envelope.max_steer
        self.radius = min(max(6.0, 1.3 * wheelbase / math.tan(0.85 * self.lock)), 0.24 * envelope.width)
        self.slow = min(4.0, math.sqrt(0.7 * self.lateral * self.radius), self.top)
        self._hand = envelope.steer_rate * PERIOD
        self._front = front + EDGE
        turn = self.radius + self._front
        self.straight = max(envelope.length - 2.0 * turn, 0.0)
        if round_about:
            low = -self._front
            self.area = Area(-0.5 * envelope.length, 0.5 * envelope.length, low, low + envelope.width)
            self._lanes = (-0.3 * envelope.length, 0.3 * envelope.length)
        else:
            low = self.radius - 0.5 * envelope.width
            self.area = Area(-turn, self.straight + turn, low, low + envelope.width)
            self._lanes = (0.0, self.straight)
        self.car = Motion(0.0, 0.0, 0.0, 0.0)
        self._round = round_about
        self._lane, self._back = 0.0, False
        self._steer, self._speed = 0.0, 0.0

    def angle(self, speed: float, lateral: float) -> float:
        """Road-wheel angle [rad] for a lateral acceleration [m/s^2] at a speed [m/s], within the lock."""
        return min(self.wheelbase * lateral / max(speed, 0.5) ** 2, self.lock)

    def fitting(self, seconds: float, *, share: float = 1.0) -> float:
        """The highest speed [m/s] at which a test of `seconds` finds room on one straight, `share` of the top speed."""
        speed = share * self.top
        while speed > self.slow and self._way(speed, seconds, self.slow) > 0.96 * self.straight:
            speed -= 0.1
        return speed

    def tests(self, wanted: Sequence[Test]) -> Driving:
        """Start, drive the tests one after another, as many as there is room for on each straight, and stop."""
        yield from self.stand(1.0)
        fresh = True
        for test in wanted:
            need = self._way(test.speed, test.seconds, self.car.v)
            if not fresh and need > self._left():
                yield from self.turn()
            yield from self.reach(test.speed)
            yield from self.hold(test)
            fresh = False
        yield from self.halt()

    def stand(self, seconds: float) -> Driving:
        """Brake on."""
        for _ in range(round(seconds / PERIOD)):
            yield from self._tick(STAND, 0.0, 0.0)

    def reach(self, speed: float) -> Driving:
        """Reach a speed in the lane, as far as there is room and patience."""
        for _ in range(round(PATIENCE / PERIOD)):
            if abs(self.car.v - speed) < 0.15 or self._room() < 0.5:
                return
            yield from self._tick(self._foot(speed), self._keep(), speed)

    def hold(self, test: Test) -> Driving:
        """The test itself; it ends early where the ground does."""
        for k in range(round(test.seconds / PERIOD)):
            tau = k * PERIOD
            if self._room() < 0.0 or (test.end is not None and self.car.v <= test.end and tau > 0.5):
                return
            steer = self._keep() if test.steer is None else test.steer(tau)
            if test.pedal is None:
                yield from self._tick(self._foot(test.speed), steer, test.speed)
            else:
                push = test.pedal(tau)
                if self.car.v > self.top and push > 0.0:
                    push = 0.0
                if self.car.v < 0.2 and push <= 0.0:
                    push = STAND
                yield from self._tick(push, steer, None)

    def turn(self) -> Driving:
        """Slow down at the end of the straight and turn left into the other lane."""
        for _ in range(round(60.0 / PERIOD)):
            gap = self._left()
            if gap < 0.0:
                break
            allowed = math.sqrt(self.slow**2 + 1.2 * self.brake * max(gap - 1.0, 0.0))
            wanted = min(allowed, max(0.6 * self.top, self.slow))
            yield from self._tick(self._foot(wanted), self._keep(), wanted)
        self._back = not self._back
        self._lane = 2.0 * self.radius if self._back else 0.0
        for _ in range(round(20.0 / PERIOD)):
            if abs(self._heading_error()) < 0.3:
                return
            angle = math.atan(self.wheelbase / self.radius)
            yield from self._tick(self._foot(self.slow), angle, self.slow)

    def other_side(self) -> Driving:
        """The same, at once."""
        self._lanes = (self.car.x, self.car.x)
        yield from self.turn()
        self._lanes = (self.area.x_min + self._front, self.area.x_max - self._front)

    def circle(self, speed: float, angle: float, *, turns: float = math.inf, seconds: float = 60.0) -> Driving:
        """A circle at constant speed [m/s] and road-wheel angle [rad]."""
        begin = self.car.yaw
        for _ in range(round(seconds / PERIOD)):
            outside = self.area.inset(self._front, self._front).room(self.car.x, self.car.y, self.car.yaw) < 0.0
            if abs(self.car.yaw - begin) >= 2.0 * math.pi * turns or outside:
                return
            yield from self._tick(self._foot(speed), angle, speed)

    def close_circle(self, angle: float) -> Driving:
        """Slowly round to where the car looks as at the start."""
        for _ in range(round(60.0 / PERIOD)):
            if self.car.v < self.slow + 0.3 and abs(math.remainder(self.car.yaw, 2.0 * math.pi)) < 0.1:
                return
            yield from self._tick(self._foot(self.slow), angle, self.slow)

    def halt(self) -> Driving:
        """Brake to a standstill and stand for a second and a half."""
        while self.car.v >= 0.1:  # as long as it takes: one that never stops has not finished
            hard = self.brake if self._room(0.6) < 1.0 else 0.6 * self.brake
            yield from self._tick(-hard, self._keep(), 0.0)
        yield from self.stand(1.5)

    def _tick(self, accel: float, steer: float, speed: float | None) -> Driving:
        accel = min(max(accel, -self.brake), self.push)
        steer = min(max(steer, -self.lock), self.lock)
        self._steer = min(max(steer, self._steer - self._hand), self._steer + self._hand)
        if speed is None:
            self._speed = max(self._speed + accel * PERIOD, 0.0)
        else:
            self._speed += min(max(speed - self._speed, -self.brake * PERIOD), self.push * PERIOD)
        self._speed = max(min(max(self._speed, self.car.v - 2.0), self.car.v + 2.0), 0.0)
        self.car = yield DriverDemand(round(accel, 4), round(self._steer, 5), round(self._speed, 3))

    def _foot(self, speed: float) -> float:
        if speed <= 0.0 and self.car.v < 0.15:
            return STAND
        return min(max(FOOT * (speed - self.car.v), -0.6 * self.brake), self.push)

    def _keep(self) -> float:
        """Steering [rad] that keeps the lane: towards a point ahead (pure pursuit), never hard."""
        course = math.pi if self._back else 0.0
        ahead = max(NEAR, REACH * self.car.v)
        aside = (self._lane - self.car.y) * (-1.0 if self._back else 1.0)
        bearing = math.atan2(aside, ahead)
        error = math.remainder(course + bearing - self.car.yaw, 2.0 * math.pi)
        angle = math.atan2(2.0 * self.wheelbase * math.sin(0.5 * math.pi * math.tanh(error)), math.hypot(ahead, aside))
        most = self.angle(self.car.v, GENTLE * self.lateral)
        return min(max(angle, -most), most)

    def _heading_error(self) -> float:
        return math.remainder((math.pi if self._back else 0.0) - self.car.yaw, 2.0 * math.pi)

    def _left(self) -> float:
        """Way [m] to where the turn at the end of the straight has to begin."""
        gap = self.car.x - self._lanes[0] if self._back else self._lanes[1] - self.car.x
        # steering takes its time, and a heading to the wrong side makes the turn wider
        return gap - 0.6 * self.car.v - self.radius * max(math.sin(self._heading_error()), 0.0)

    def _way(self, speed: float, seconds: float, now: float) -> float:
        """Way [m] of reaching a speed, a test, and slowing down to the speed of a turn."""
        up = max(speed**2 - now**2, 0.0) / (1.6 * self.push)
        return up + speed * seconds + max(speed**2 - self.slow**2, 0.0) / (1.2 * self.brake) + 1.0

    def _room(self, share: float = 0.9) -> float:
        """Way [m] that is left after braking: to the border, and to the turn at the end of the straight."""
        v, free = self.car.v, self.area.inset(self._front, self._front)
        room = free.room(self.car.x, self.car.y, self.car.yaw) - 0.3 * v - v**2 / (2.0 * share * self.brake)
        if self._round:
            return room
        return min(room, self._left() - 1.0 - max(v**2 - self.slow**2, 0.0) / (1.2 * self.brake))
