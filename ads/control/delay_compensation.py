"""Delay compensation: where the car will be when a command given now begins to act."""

from __future__ import annotations

import math

import numpy as np

from machine_code import compiled
from vehicle.messages import FloatArray

HISTORY = 64  # commands
CHARACTERISTIC_SPEED = 25.0  # m/s; an understeering car turns half as much per steer angle at it


@compiled
def predicted_pose(
    x: float,
    y: float,
    yaw: float,
    v: float,
    yaw_rate: float,
    acceleration: float,
    times: FloatArray,
    steers: FloatArray,
    newest: int,
    now: float,
    delay: float,
    wheelbase: float,
) -> tuple[float, float, float, float]:
    """x, y [m], yaw [rad], v [m/s] after `delay` [s], with the steer commands that are still on their way.

    `times` (n,) [s] and `steers` (n,) [rad] are a ring of past commands, `newest` the index of the last one. The yaw
    rate starts from the measured one and changes as the kinematic model with understeer says.
    """
    n = len(times)
    steps = math.ceil(delay / 0.025)
    if steps <= 0:
        return x, y, yaw, v
    dt = delay / steps
    gain = 1.0 / (1.0 + (v / CHARACTERISTIC_SPEED) ** 2)
    acting = 0.0
    for step in range(steps + 1):
        t = now - delay + step * dt
        i = newest
        for _ in range(n - 1):
            if times[i] <= t + 1e-9:
                break
            i = (i - 1) % n
        turn = math.tan(steers[i])
        if step == 0:
            acting = turn
            continue
        w = yaw_rate + gain * v * (turn - acting) / wheelbase
        half = yaw + 0.5 * w * dt
        x += v * dt * math.cos(half)
        y += v * dt * math.sin(half)
        yaw += w * dt
        v = max(v + acceleration * dt, 0.0)
    return x, y, yaw, v


class DelayCompensation:
    """Remembers steer commands and predicts the pose over the steering delay [s]."""

    def __init__(self, delay: float, wheelbase: float) -> None:
        self.delay = delay
        self._wheelbase = wheelbase
        self._times = np.full(HISTORY, -1e9)
        self._steers = np.zeros(HISTORY)
        self._newest = 0

    def remember(self, t: float, steer: float) -> None:
        """Note that `steer` [rad] was commanded at `t` [s]."""
        self._newest = (self._newest + 1) % HISTORY
        self._times[self._newest] = t
        self._steers[self._newest] = steer

    def predict(
        self, t: float, x: float, y: float, yaw: float, v: float, yaw_rate: float, acceleration: float
    ) -> tuple[float, float, float, float]:
        """x, y, yaw, v at `t` + delay."""
        result: tuple[float, float, float, float] = predicted_pose(
            x, y, yaw, v, yaw_rate, acceleration, self._times, self._steers, self._newest, t, self.delay,
            self._wheelbase,
        )  # fmt: skip
        return result
