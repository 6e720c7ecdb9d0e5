"""What is changed in a car or its sensors: where it physically acts, its range, and its name in the catalogue."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np

from benchmarks.foreign_cars.car import ForeignCar
from benchmarks.foreign_cars.tyres import FloatArray

Values = Mapping[str, Mapping[str, float]]
"""effect -> key -> value, as in the catalogue."""

RANGES: dict[str, dict[str, tuple[float, float]]] = {
    "steer_delay": {"T": (0.06, 0.4)},
    "steer_lag": {"tau": (0.08, 0.5)},
    "steer_ratio": {"g": (0.75, 0.95)},
    "steer_offset": {"offset": (0.008, 0.035)},
    "drive_delay": {"T": (0.1, 0.5)},
    "drive_lag": {"tau": (0.15, 0.7)},
    "brake_lag": {"tau": (0.15, 0.6)},
    "drive_gain": {"g": (0.75, 0.93)},
    "brake_gain": {"g": (0.7, 0.93)},
    "mass": {"ratio": (1.08, 1.35)},
    "aero_drag": {"k": (0.0006, 0.004)},
    "rolling_resistance": {"c": (0.08, 0.35)},
    "drive_torque_limit": {"limit": (1.0, 2.2)},
    "brake_fade": {"k": (2e-4, 1e-3), "tau": (60.0, 200.0)},
    "steer_assist": {"g": (-0.4, -0.12), "v0": (4.0, 12.0)},
    "steer_sticking": {"width": (0.02, 0.08)},
    "road_profile": {"height": (1.0, 3.0), "x": (-60.0, 60.0), "y": (-60.0, 60.0), "length": (15.0, 45.0)},
    "gyro_bias": {"b": (0.006, 0.03)},
    "yaw_rate_latency": {"T": (0.05, 0.3)},
    "accelerometer_bias": {"b": (0.1, 0.5)},
    "imu_misalignment": {"angle": (0.04, 0.15)},
    "heading_bias": {"b": (0.01, 0.05)},
    "gnss_latency": {"T": (0.06, 0.4)},
    "wheel_radius": {"ratio": (0.93, 0.985)},
}
"""Severity is drawn evenly over these; they lie inside the typical ranges of the catalogue."""


def drawn(name: str, rng: np.random.Generator) -> dict[str, float]:
    """Values of an effect, to four figures."""
    return {key: float(f"{rng.uniform(low, high):.4g}") for key, (low, high) in RANGES[name].items()}


def changed(car: ForeignCar, hidden: Values) -> ForeignCar:
    """The car with what is a matter of its bodies."""
    if "mass" in hidden:
        car = dataclasses.replace(car, payload=(hidden["mass"]["ratio"] - 1.0) * car.mass)
    if "aero_drag" in hidden:  # on top of what it has: k = rho c_w A/(2 m)
        more = hidden["aero_drag"]["k"] * car.mass / 0.6
        car = dataclasses.replace(car, drag_area=car.drag_area + more)
    if "rolling_resistance" in hidden:
        car = dataclasses.replace(car, rolling=car.rolling + hidden["rolling_resistance"]["c"] / 9.80665)
    return car


class Controls:
    """What becomes of the commands on their way to motor, brakes and steering."""

    def __init__(self, hidden: Values) -> None:
        self._hidden = hidden
        self._disc = 0.0
        self._stuck: float | None = None
        self._angle = 0.0

    def value(self, name: str, key: str, otherwise: float) -> float:
        """A hidden value, or what stands for nothing."""
        return self._hidden.get(name, {}).get(key, otherwise)

    def asked(self, accel: float, steer: float, speed: float) -> tuple[float, float]:
        """Acceleration and angle that are asked of the actuators, once a command (50 Hz)."""
        accel *= self.value("drive_gain", "g", 1.0) if accel > 0.0 else self.value("brake_gain", "g", 1.0)
        accel = min(accel, self.value("drive_torque_limit", "limit", np.inf))
        if accel < 0.0:
            accel /= 1.0 + self.value("brake_fade", "k", 0.0) * self._disc
        g, v0 = self.value("steer_assist", "g", 0.0), self.value("steer_assist", "v0", 8.0)
        steer = steer * self.value("steer_ratio", "g", 1.0) * (1.0 + g * speed / (speed + v0))
        steer += self.value("steer_offset", "offset", 0.0)
        return accel, self._breaks_free(steer, speed)

    def _breaks_free(self, steer: float, speed: float) -> float:
        width = self.value("steer_sticking", "width", 0.0)
        if width > 0.0:
            if speed < 0.05 and self._stuck is None:
                self._stuck = self._angle
            if self._stuck is not None:
                if abs(steer - self._stuck) < width:
                    return self._stuck
                if speed >= 0.05:
                    self._stuck = None
        self._angle = steer
        return steer

    def heat(self, braking: float, speed: float, step: float) -> None:
        """The discs take up what the brakes take away, and cool."""
        self._disc += step * (braking * speed - self._disc / self.value("brake_fade", "tau", 100.0))


def sensed(truth: Mapping[str, FloatArray], hidden: Values) -> dict[str, FloatArray]:
    """The columns of a log with faults of the sensors, without noise."""
    t = truth["t"]

    def late(name: str, delay: float) -> FloatArray:
        return np.asarray(np.interp(t - delay, t, truth[name]))

    def value(name: str, key: str, otherwise: float = 0.0) -> float:
        return hidden.get(name, {}).get(key, otherwise)

    old = value("gnss_latency", "T")
    angle = value("imu_misalignment", "angle")
    ax, ay = truth["ax"], truth["ay"]
    return {
        "x": late("x", old),
        "y": late("y", old),
        "yaw": late("yaw", old) + value("heading_bias", "b"),
        "v": truth["v"] * value("wheel_radius", "ratio", 1.0),
        "yaw_rate": late("yaw_rate", value("yaw_rate_latency", "T")) + value("gyro_bias", "b"),
        "ax": np.cos(angle) * ax + np.sin(angle) * ay + value("accelerometer_bias", "b"),
        "ay": np.cos(angle) * ay - np.sin(angle) * ax,
    }
