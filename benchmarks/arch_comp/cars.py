"""The chasing cars: throttle and brake of the first car in, the positions of all five out.

Each car but the first follows the one before it in one of three modes. The gap decides, as in `cars.mdl`, published in
ERATOMMSD/falstar (falstar/resource/simulink); the problem is after Hu, Lygeros and Sastry, Towards a theory of
stochastic hybrid systems, HSCC 2000. All drive towards negative positions, and a follower that keeps its distance
drives backwards: so it is in that model.
"""

from __future__ import annotations

import math

import numpy as np

from machine_code import compiled
from pytest_dvp.logs.log_contents import FloatArray

STEP = 0.01  # [s] between two rows; switches are found within a step
CARS = 5
KEEPING, CHASING, BRAKING = 0, 1, 2
CAUGHT, LOST, CLOSE, FAR = 10.0, 15.0, 5.0, 20.0  # gaps at which chasing, keeping (twice) and braking end
SPACING = 10.0  # the cars begin this far apart, at rest, and keep


@compiled
def led(y: float, v: float, throttle: float, brake: float, t: float) -> tuple[float, float]:
    """Position and speed of the first car after `t`, of a step or less: v' = -throttle - brake v, y' = v."""
    # (1 - exp(-brake t)) / brake and its integral, as series: brake may be 0, and brake t is 0.01 at most
    gone = t - brake * t**2 / 2.0 + brake**2 * t**3 / 6.0 - brake**3 * t**4 / 24.0 + brake**4 * t**5 / 120.0
    pushed = t**2 / 2.0 - brake * t**3 / 6.0 + brake**2 * t**4 / 24.0 - brake**3 * t**5 / 120.0
    return y + v * gone - throttle * pushed, v * math.exp(-brake * t) - throttle * gone


@compiled
def followed(y: float, v: float, mode: int, t: float) -> tuple[float, float]:
    """Position and speed of a follower after `t` in its mode."""
    if mode == CHASING:
        return y - v * t - t * t / 2.0, v + t
    if mode == KEEPING:
        return y + v * t, v
    return y + v * math.expm1(-t), v * math.exp(-t)


@compiled
def next_mode(mode: int, gap: float) -> int:
    """The mode that a gap leads to."""
    if mode == CHASING:
        return KEEPING if gap <= CAUGHT else CHASING
    if mode == BRAKING:
        return CHASING if gap >= FAR else BRAKING
    return CHASING if gap >= LOST else (BRAKING if gap <= CLOSE else KEEPING)


@compiled
def threshold(mode: int, after: int) -> float:
    """The gap at which one mode becomes another."""
    if mode == CHASING:
        return CAUGHT
    if mode == BRAKING:
        return FAR
    return LOST if after == CHASING else CLOSE


@compiled
def drive(throttles: FloatArray, brakes: FloatArray) -> FloatArray:
    """Positions of the five cars in rows; the inputs are those of each step."""
    count = len(throttles)
    trace = np.empty((CARS, count))
    y, v = SPACING * np.arange(CARS), np.zeros(CARS)
    mode = np.zeros(CARS, dtype=np.int64)
    to_y, to_v = np.empty(CARS), np.empty(CARS)
    for k in range(count):
        trace[:, k] = y
        left = STEP
        while left > 0.0:
            reach, who = 1.0, 0
            for attempt in range(2):  # the whole rest of the step, or as far as the first switch in it
                t = left * reach
                to_y[0], to_v[0] = led(y[0], v[0], throttles[k], brakes[k], t)
                for car in range(1, CARS):
                    to_y[car], to_v[car] = followed(y[car], v[car], mode[car], t)
                if attempt:
                    break
                for car in range(1, CARS):
                    gap, before = to_y[car] - to_y[car - 1], y[car] - y[car - 1]
                    after = next_mode(mode[car], gap)
                    if after != mode[car]:
                        share = (threshold(mode[car], after) - before) / (gap - before) if gap != before else 0.0
                        share = min(max(share, 0.0), 1.0)
                        if who == 0 or share < reach:
                            reach, who = share, car
                if who == 0:
                    break
            if who:
                gap = to_y[who] - to_y[who - 1]
                after = next_mode(mode[who], gap)
                if after == mode[who]:  # it ends a rounding before the threshold
                    after = CHASING if mode[who] == BRAKING else (KEEPING if mode[who] == CHASING else mode[who])
                    if mode[who] == KEEPING:
                        after = CHASING if gap > CAUGHT else BRAKING
                mode[who] = after
            y[:], v[:] = to_y, to_v
            left -= left * reach
    return trace
