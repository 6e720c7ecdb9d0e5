"""Sensors of the surrogate: latency, lever arm, bias, misalignment, noise and drift."""

from __future__ import annotations

import math

import numpy as np

from vehicle.messages import FloatArray
from vehicle.surrogate.hidden import Hidden

MEMORY = 1.0  # s of motion that is kept: 0.9 s of latency, and 0.05 s to look back
SIGMA = {"x": 0.02, "y": 0.02, "yaw": 0.005, "v": 0.03, "yaw_rate": 0.005, "ax": 0.1, "ay": 0.1}
"""White noise at level "mid" [m, rad, m/s, rad/s, m/s^2]; "low" is half of it, "high" twice."""
FACTOR = {"none": 0.0, "low": 0.5, "mid": 1.0, "high": 2.0}
DRIFT_SIGMA, DRIFT_TIME = 0.02, 30.0  # m at "mid", s
_X, _Y, _YAW, _VX, _R, _AX, _AY = 0, 1, 2, 3, 5, 6, 7


class Sensors:
    """What GNSS, odometry and IMU show; `seed` of their noise, `step` [s] between two rows of history."""

    def __init__(self, hidden: Hidden, seed: int, step: float):
        self._rng = np.random.default_rng([seed, 4711])
        self._step = step
        self._factor = FACTOR[hidden.noise]
        self._drift = [0.0, 0.0]
        value = hidden.value
        self._arm = value("gnss_lever_arm", "x"), value("gnss_lever_arm", "y")
        self._late = value("gnss_latency", "T"), value("yaw_rate_latency", "T")
        self._wheel = value("wheel_radius", "ratio")
        self._bias = value("heading_bias", "b"), value("gyro_bias", "b"), value("accelerometer_bias", "b")
        self._gain = 1.0 + value("pitch", "gain"), 1.0 + value("roll", "gain")
        angle = value("imu_misalignment", "angle")
        self._turn = math.cos(angle), math.sin(angle)

    def _ago(self, history: FloatArray, delay: float) -> list[float]:
        steps = delay / self._step
        whole = int(steps + 1e-9)
        part = max(steps - whole, 0.0)
        newer = history[-1 - whole]
        older = history[max(-2 - whole, -len(history))]
        mixed: list[float] = (newer + part * (older - newer)).tolist()
        return mixed

    def show(self, history: FloatArray, period: float = 0.02) -> dict[str, float]:
        """Measurements at the newest row of `history` (n, 12), columns of ROW, `period` [s] after the last call."""
        now = history[-1].tolist()
        seen = self._ago(history, self._late[0])
        turning = self._ago(history, self._late[1])
        c, s = math.cos(seen[_YAW]), math.sin(seen[_YAW])
        ax, ay = now[_AX] * self._gain[0], now[_AY] * self._gain[1]
        shown = {
            "x": seen[_X] + c * self._arm[0] - s * self._arm[1],
            "y": seen[_Y] + s * self._arm[0] + c * self._arm[1],
            "yaw": seen[_YAW] + self._bias[0],
            "v": now[_VX] * self._wheel,
            "yaw_rate": turning[_R] + self._bias[1],
            "ax": self._turn[0] * ax + self._turn[1] * ay + self._bias[2],
            "ay": self._turn[0] * ay - self._turn[1] * ax,
        }
        if self._factor > 0.0:
            white = self._rng.standard_normal(len(shown) + 2).tolist()
            keep = math.exp(-period / DRIFT_TIME)
            kick = DRIFT_SIGMA * self._factor * math.sqrt(1.0 - keep * keep)
            self._drift = [keep * d + kick * w for d, w in zip(self._drift, white[7:], strict=True)]
            for k, name in enumerate(shown):
                shown[name] += SIGMA[name] * self._factor * white[k]
            shown["x"] += self._drift[0]
            shown["y"] += self._drift[1]
        return shown
