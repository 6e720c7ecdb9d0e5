"""The recorded multi-body cars as measured logs: sensor noise added, and, if asked for, an effect on top.

Recorded by scripts/record_multibody.py; see tests/data/multibody/README.md.
"""

from __future__ import annotations

import gzip
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tests.truth.car import PERIOD
from tests.truth.effects import Effects, FloatArray, checked
from tests.truth.generate import MEASURED, Noise, add_noise
from vehicle.surrogate.driver import Drive

FOLDER = Path(__file__).resolve().parents[1] / "data" / "multibody"


@dataclass(frozen=True)
class RecordedCar:
    """What the parameter file of the recorded model says. SI units."""

    name: str
    wheelbase: float
    cg_to_front_axle: float
    mass: float
    yaw_inertia: float
    steer_rate: float  # rad/s, limit of its steering
    rotating_mass: float  # kg that four wheels of 1.7 kg m^2 and 0.344 m add to the mass

    @property
    def mass_ratio(self) -> float:
        """Effective mass over the mass for which its commanded accelerations hold."""
        return 1.0 + self.rotating_mass / self.mass


_WHEELS = 4.0 * 1.7 / 0.344**2  # kg
CARS: dict[str, RecordedCar] = {
    "ford_escort": RecordedCar("ford_escort", 2.39268, 0.88392, 1225.888, 1538.853, 0.4, _WHEELS),
    "bmw_320i": RecordedCar("bmw_320i", 2.578913, 1.156196, 1093.295, 1791.600, 0.4, _WHEELS),
    "vw_vanagon": RecordedCar("vw_vanagon", 2.471928, 1.150792, 1478.898, 2473.118, 0.4, _WHEELS),
}


def recorded(car: str, drive: Drive) -> dict[str, FloatArray]:
    """Columns of a recording without sensor noise, each float64 (n,)."""
    with gzip.open(FOLDER / f"{car}_{drive}.csv.gz", "rt") as text:
        names = [cell.split(" [")[0] for cell in text.readline().strip().split(",")]
        rows = np.loadtxt(text, delimiter=",")
    return {name: np.ascontiguousarray(rows[:, k]) for k, name in enumerate(names)}


def make_multibody_log(
    car: str, drive: Drive, seed: int = 0, noise: Noise = "mid", effects: Effects | None = None
) -> dict[str, FloatArray]:
    """A recording with sensor noise and the given effects on top.

    A sensor effect changes what is shown. An effect of the command path changes what was commanded instead: the car
    got what it got, so its driver must have asked earlier (delays) or for more (gains). Raises ValueError for effects
    that cannot be put on a recording this way.
    """
    columns = recorded(car, drive)
    for name, values in checked(effects or {}).items():
        _inject(columns, name, values)
    return add_noise(columns, noise, (seed << 32) + sorted(CARS).index(car) * 2 + (drive == "urban"))


def _inject(columns: dict[str, FloatArray], name: str, p: dict[str, float]) -> None:
    accel, steer = columns["accel_cmd"], columns["steer_cmd"]
    if name in ("drive_delay", "steer_delay"):
        column = "accel_cmd" if name == "drive_delay" else "steer_cmd"
        shift = p["T"] / PERIOD
        if abs(shift - round(shift)) > 1e-6:
            raise ValueError(f"a delay on a recording is a multiple of {PERIOD} s")
        old = columns[column]
        columns[column] = np.concatenate([old[round(shift) :], np.full(round(shift), old[-1])])
    elif name in ("drive_gain", "brake_gain"):
        sign = accel > 0.0 if name == "drive_gain" else accel < 0.0
        columns["accel_cmd"] = np.where(sign, accel / p["g"], accel)
    elif name == "steer_ratio":
        columns["steer_cmd"] = steer / p["g"]
    elif name == "steer_asymmetry":
        columns["steer_cmd"] = np.where(steer > 0.0, steer / p["g_left"], steer / p["g_right"])
    elif name == "steer_offset":
        columns["steer_cmd"] = steer - p["offset"]
    elif name == "wheel_radius":
        columns["v"] = columns["v"] * p["ratio"]
    elif name in ("gyro_bias", "accelerometer_bias", "heading_bias"):
        column = {"gyro_bias": "yaw_rate", "accelerometer_bias": "ax", "heading_bias": "yaw"}[name]
        columns[column] = columns[column] + p["b"]
    elif name in ("yaw_rate_latency", "gnss_latency"):
        for column in ("yaw_rate",) if name == "yaw_rate_latency" else ("x", "y", "yaw"):
            t = columns["t"]
            columns[column] = np.asarray(np.interp(t - p["T"], t, columns[column]))
    elif name == "gnss_lever_arm":
        c, s = np.cos(columns["yaw"]), np.sin(columns["yaw"])
        columns["x"] = columns["x"] + p["x"] * c - p["y"] * s
        columns["y"] = columns["y"] + p["x"] * s + p["y"] * c
    elif name in ("pitch", "roll"):
        column = "ax" if name == "pitch" else "ay"
        columns[column] = columns[column] * (1.0 + p["gain"])
    elif name == "imu_misalignment":
        c, s = np.cos(p["angle"]), np.sin(p["angle"])
        ax, ay = columns["ax"], columns["ay"]
        columns["ax"], columns["ay"] = c * ax + s * ay, c * ay - s * ax
    else:
        raise ValueError(f"{name} cannot be put on a recording")


__all__ = ["CARS", "MEASURED", "RecordedCar", "make_multibody_log", "recorded"]
