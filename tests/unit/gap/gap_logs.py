"""Logs of a car whose truth is known: a kinematic bicycle written here, on its own, with noise of known size."""

from __future__ import annotations

import math

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from vehicle.model.model_file import parse_model
from vehicle.model.vehicle_model import VehicleModel

WHEELBASE = 2.5
NOISE = {"x": 0.02, "y": 0.02, "yaw": 0.005, "v": 0.03, "yaw_rate": 0.005, "ax": 0.1, "ay": 0.1}


def baseline() -> VehicleModel:
    """The car without any effect."""
    return parse_model(
        f"[model]\nname = 'car'\n[parameters]\nwheelbase = {WHEELBASE}\ncg_to_front_axle = 1.2\nmass = 1200.0\n"
    )


def drive(
    duration: float = 60.0, *, rate: float = 50.0, noise: float = 1.0, seed: int = 1, drive_gain: float = 1.0,
    brake_gain: float = 1.0, steer_delay: float = 0.0, steer_ratio: float = 1.0, steer_offset: float = 0.0,
    yaw_bias: float = 0.0, hills: float = 0.0, wave: float = 90.0, plane: float = 0.0,
) -> Log:  # fmt: skip
    """A drive with launches, cruise, braking to standstill and turns, with hidden effects; `noise` scales NOISE.

    `hills` is the spread [m/s^2] of gravity along the road, which rises and falls over a `wave` [m], `plane` what
    it is at heading 0 on one slope everywhere; the accelerometer feels neither.

    Each second of motion is made of 20 ms steps of a bicycle with ideal actuators but for the effects asked for.
    """
    dt = 1.0 / rate
    t = np.arange(round(duration * rate)) * dt
    phase = t % 20.0
    # launches of more than one strength: one alone cannot tell a gain from a limit
    launch = np.where(t % 40.0 < 20.0, 1.6, np.where(phase < 2.5, 1.2, 2.0))
    accel = np.where(phase < 5.0, launch, np.where((phase > 12.0) & (phase < 17.0), -2.0, 0.0))
    steer = np.where((phase > 6.0) & (phase < 11.0), 0.08 * np.sin(2.0 * math.pi * 0.4 * (phase - 6.0)), 0.0)
    late = round(steer_delay / dt)
    acting = np.concatenate([np.full(late, steer[0]), steer[: len(steer) - late]])
    rows = np.zeros((len(t), 7))
    x = y = yaw = v = way = 0.0
    for i in range(len(t)):
        a = accel[i] * (drive_gain if accel[i] > 0.0 else brake_gain)
        k = math.tan(steer_ratio * acting[i] + steer_offset) / WHEELBASE
        down = 2.0**0.5 * hills * math.sin(2.0 * math.pi * way / wave) + plane * math.cos(yaw)
        held = v == 0.0 and a <= 0.0  # brakes hold a car that stands
        after = 0.0 if held else max(v + (a + down) * dt, 0.0)
        rows[i] = x, y, yaw, v, v * k, (after - v) / dt - down, v * v * k
        mean = 0.5 * (v + after)
        heading, way = yaw + 0.5 * dt * mean * k, way + dt * mean
        x, y, yaw, v = x + dt * mean * math.cos(heading), y + dt * mean * math.sin(heading), yaw + dt * mean * k, after
    rng = np.random.default_rng(seed)
    rows += noise * rng.normal(size=rows.shape) * np.array(list(NOISE.values()))
    rows[:, 2] += yaw_bias
    columns: dict[str, FloatArray] = {"t": t, "accel_cmd": accel, "steer_cmd": steer}
    columns |= {name: np.ascontiguousarray(rows[:, k]) for k, name in enumerate(NOISE)}
    return Log(columns)
