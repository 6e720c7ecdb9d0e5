"""A simple driver: programmes of manoeuvres, driven closed loop so that any car stays within sensible bounds.

Standard library only, so that other simulators (in other environments) can be driven by it, too.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass
from typing import Literal, NamedTuple

PERIOD = 0.02  # s, one command is held that long

Drive = Literal["rich", "urban"]


class Motion(NamedTuple):
    """What the driver sees of the car: rear axle position [m], yaw [rad], speed [m/s]."""

    x: float
    y: float
    yaw: float
    v: float


class Wish(NamedTuple):
    """What the driver asks for: acceleration [m/s^2], road-wheel angle [rad], speed [m/s]."""

    accel: float
    steer: float
    speed: float


@dataclass(frozen=True)
class Leg:
    """One piece of a programme.

    Along: reach and hold `speed` [m/s] with at most `accel` [m/s^2] up and `brake` down; or, with `push` set, give that
    acceleration whatever comes of it (pulses of both signs with `push_period` [s]). Across: `turn` [m/s^2] is the
    amplitude of v^2 d/L at the speed `at` [m/s], shaped by `shape`; `hold` keeps the heading. A leg ends after
    `duration` [s].
    """

    duration: float
    speed: float = 0.0
    accel: float = 1.5
    brake: float = 2.0
    push: float | None = None
    push_period: float = 0.0
    turn: float = 0.0
    at: float = 8.0
    shape: Literal["keep", "step", "sine", "square", "chirp", "doublet"] = "keep"
    period: float = 2.0


STAND = -1.5  # m/s^2, the brake that holds a car at standstill
HAND = 1.0  # rad/s at the road wheel, hands turn no faster

RICH: tuple[Leg, ...] = (
    Leg(1.0),
    Leg(6.0, speed=8.0, accel=1.6),
    Leg(2.0, push=0.0, turn=1.6, shape="step"),
    Leg(2.0, push=0.0, turn=-1.6, shape="step"),
    Leg(2.5, push=0.0),
    Leg(2.5, speed=3.0, brake=1.6),
    Leg(3.0, speed=3.0, turn=0.5, at=3.0, shape="sine", period=1.5),
    Leg(6.5, speed=11.0, accel=1.4),
    Leg(6.4, speed=11.0, turn=2.0, at=11.0, shape="square", period=4.0),
    Leg(1.5, push=0.0),
    Leg(5.4, speed=10.5, turn=1.2, at=11.0, shape="sine", period=1.2),
    Leg(2.6, speed=3.0, brake=3.5),
    Leg(2.0, speed=4.6),
    Leg(5.5, speed=4.6, turn=2.5, at=4.6, shape="step"),
    Leg(2.0, speed=4.6),
    Leg(5.5, speed=4.6, turn=-2.5, at=4.6, shape="step"),
    Leg(1.5, speed=6.0),
    Leg(5.0, push=1.0, push_period=1.6),
    Leg(4.5, speed=12.5, accel=2.2),
    Leg(3.5, push=0.0),
    Leg(8.0, push=0.0, turn=2.8, at=12.0, shape="chirp", period=3.0),
    Leg(2.0, push=-1.0),
    Leg(2.5, push=0.0),
    Leg(4.8, push=-1.0, push_period=2.4),
    Leg(3.5, speed=0.0, brake=2.7),
    Leg(1.5),
    Leg(4.5, speed=8.0, accel=2.4),
    Leg(5.0, speed=8.0, turn=2.4, at=8.0, shape="doublet", period=2.5),
    Leg(1.5, speed=8.0),
    Leg(3.0, speed=8.0, turn=3.6, at=8.0, shape="step"),
    Leg(3.5, push=0.0),
    Leg(20.0, speed=0.0, brake=1.7),
)
"""Identification manoeuvres, 120 s, up to 12.5 m/s."""

URBAN_LENGTH = 45.0  # s
RICH_LENGTH = 120.0  # s


def shape_at(leg: Leg, tau: float) -> float:
    """Shape of the steering of a leg, -1..1, at `tau` [s] after its begin; it ends a little before the leg does."""
    left = leg.duration - tau
    if leg.shape == "keep" or left < 0.3:
        return 0.0
    turns = tau / leg.period
    if leg.shape == "step":
        return min(1.0, tau / 0.2)
    if leg.shape == "sine":
        return math.sin(2.0 * math.pi * turns)
    if leg.shape == "square":
        return 1.0 if turns % 1.0 < 0.5 else -1.0
    if leg.shape == "doublet":
        phase = turns % 1.0
        return 1.0 if phase < 0.25 else (-1.0 if phase < 0.5 else 0.0)
    rate = 1.0 / leg.period  # chirp: from 1/period to 2 Hz over the leg
    sweep = (2.0 - rate) / leg.duration
    return math.sin(2.0 * math.pi * (rate * tau + 0.5 * sweep * tau * tau))


class Driver:
    """Turns motion into commands, 50 times a second.

    `drive` "rich" (120 s of identification manoeuvres) or "urban" (45 s below 30 km/h: overtaking, a stop for a
    pedestrian); `wheelbase` [m] as the driver believes it; `seed` varies sizes and times by some percent. `max_accel`
    and `max_steer` bound what is asked for [m/s^2], [rad].
    """

    def __init__(self, drive: Drive, wheelbase: float, seed: int, max_accel: float = 3.5, max_steer: float = 0.33):
        if drive not in ("rich", "urban"):
            raise ValueError(f"no drive called {drive!r}; known: rich, urban")
        self.drive = drive
        self.wheelbase = wheelbase
        self.max_accel = max_accel
        self.max_steer = max_steer
        self.length = RICH_LENGTH if drive == "rich" else URBAN_LENGTH
        rng = random.Random(f"{drive}-{seed}")
        self._scale = [rng.uniform(0.93, 1.07) for _ in range(64)]
        self._jitter = random.Random(f"{drive}-{seed}-foot")
        self._legs: list[tuple[float, Leg]] = []
        if drive == "rich":
            begin = 0.0
            for k, leg in enumerate(RICH):
                self._legs.append((begin, leg))
                begin += leg.duration * (1.0 + 0.5 * (self._scale[k] - 1.0))
        self._now = 0
        self._course: float | None = None
        self._side = 1.0 if rng.random() < 0.5 else -1.0
        self._top = 7.3 * self._scale[0]
        self._stop_at = 122.0 * self._scale[1]
        self._stood = 0.0
        self._foot = 0.0
        self._speed = 0.0
        self._steer: float | None = None
        self._target: float | None = 0.0

    @property
    def samples(self) -> int:
        """Number of commands of the whole programme."""
        return round(self.length / PERIOD)

    def wish(self, t: float, car: Motion) -> Wish:
        """What the driver asks for at `t` [s]; call it once a period with growing t."""
        # a foot is never quite still
        self._foot += 0.1 * (-self._foot + self._jitter.gauss(0.0, 0.06))
        accel, steer, (up, down) = self._rich(t, car) if self.drive == "rich" else self._urban(t, car)
        accel = min(max(accel, -self.max_accel), self.max_accel)
        steer = min(max(steer, -self.max_steer), self.max_steer)
        if self._steer is not None:
            steer = min(max(steer, self._steer - HAND * PERIOD), self._steer + HAND * PERIOD)
        self._steer = steer
        # the same wish as a speed, for cars that take one: it leads the car by no more than 2 m/s
        target = self._target if self._target is not None else self._speed + accel * PERIOD
        self._speed += min(max(target - self._speed, -down * PERIOD), up * PERIOD)
        self._speed = max(min(max(self._speed, car.v - 2.0), car.v + 2.0), 0.0)
        return Wish(round(accel, 4), round(steer, 5), round(self._speed, 3))

    def _towards(self, speed: float, car: Motion, accel: float, brake: float) -> float:
        if speed <= 0.0:
            if car.v < 0.15:
                return STAND
            return -brake
        return min(max(1.2 * (speed - car.v), -brake), accel) + self._foot

    def _straight(self, car: Motion) -> float:
        if self._course is None:
            self._course = car.yaw
        error = self._course - car.yaw
        pull = 0.5 * error * self.wheelbase / max(car.v, 2.0)
        return min(max(pull, -0.03), 0.03)

    def _rich(self, t: float, car: Motion) -> tuple[float, float, tuple[float, float]]:
        while self._now + 1 < len(self._legs) and t >= self._legs[self._now + 1][0]:
            self._now += 1
            self._course = None
        begin, leg = self._legs[self._now]
        tau = t - begin
        size = self._scale[63 - self._now]
        if leg.push is None:
            self._target = leg.speed * (size if leg.speed < 12.0 else 1.0)
            accel = self._towards(self._target, car, leg.accel * size, leg.brake * size)
        else:
            push = leg.push * size
            if leg.push_period > 0.0 and (tau / leg.push_period) % 1.0 >= 0.5:
                push = 0.0 if leg.push < 0.0 else -0.4 * push
            if (car.v > 13.0 and push > 0.0) or (car.v < 1.5 and push < 0.0):
                push = 0.0
            accel, self._target = push, None
            if car.v < 0.3 and push <= 0.0:
                accel = STAND
        if leg.turn != 0.0:
            steer = leg.turn * size * self.wheelbase / leg.at**2 * shape_at(leg, tau)
        else:
            steer = self._straight(car) if car.v > 1.0 else 0.0
        return accel, steer, (leg.accel, leg.brake)

    def _urban(self, t: float, car: Motion) -> tuple[float, float, tuple[float, float]]:
        # the lane to be in: overtaking is a swerve by 3 m between 22 m and 85 m
        out = 3.0 * self._side * self._scale[2]
        ahead = car.x + max(4.0, 0.9 * car.v)
        lane = out * (_smooth((ahead - 22.0) / 22.0) - _smooth((ahead - 66.0) / 22.0))
        bearing = math.atan2(lane - car.y, ahead - car.x)
        error = math.remainder(bearing - car.yaw, 2.0 * math.pi)
        reach = math.hypot(ahead - car.x, lane - car.y)
        steer = math.atan2(2.0 * self.wheelbase * math.sin(error), reach)
        gap = self._stop_at - car.x
        speed = self._top
        if t < 1.0:
            speed = 0.0
        elif self._stood < 3.5 and gap < 0.5 * car.v * car.v / 2.0 + 1.5:
            speed = 0.0
            if car.v < 0.15:
                self._stood += PERIOD
        elif t > 38.0 * (0.5 + 0.5 * self._scale[3]):
            speed = 0.0
        self._target = speed
        accel = self._towards(speed, car, 1.4 * self._scale[4], 1.9 * self._scale[5])
        if speed == 0.0 and car.v >= 0.15 and t < 30.0:
            accel = -min(max(0.5 * car.v * car.v / max(gap, 0.5), 0.8), 3.0)
        return accel, steer, (1.4, 2.0)


def _smooth(s: float) -> float:
    """0 before 0, 1 after 1, a half cosine between."""
    return 0.5 - 0.5 * math.cos(math.pi * min(max(s, 0.0), 1.0))
