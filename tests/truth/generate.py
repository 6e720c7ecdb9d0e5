"""Measured logs of a car with hidden effects: `make_log({"steer_delay": {"T": 0.2}}, "rich", seed=1, noise="mid")`.

    python -m tests.truth.generate --effect steer_delay:T=0.2 --drive rich --noise mid --seed 1 --out log.csv

Columns, units, rate (50 Hz) and hold (a command logged at t holds from t to the next stamp; a measurement is that of t)
as in the blind cases. Noise is white, plus a slow drift in position.
"""

from __future__ import annotations

import argparse
import hashlib
from functools import lru_cache
from pathlib import Path
from typing import Literal

import numpy as np
from scipy.signal import lfilter

from tests.truth.car import D_FREE, D_LAG, D_RATE, D_RES, D_STICK, FINE, N_STATE, PERIOD, SUBSTEPS, H, V, advance
from tests.truth.effects import (
    C_CF,
    C_CR,
    C_DYNAMIC,
    KNOWN,
    PLANT,
    SPEED_MODE,
    Effects,
    FloatArray,
    TruthCar,
    checked,
    parameters,
)
from vehicle.surrogate.driver import Drive, Driver, Motion

Noise = Literal["none", "low", "mid", "high"]
MEASURED = ("x", "y", "yaw", "v", "yaw_rate", "ax", "ay")
UNITS = {
    "t": "s",
    "accel_cmd": "m/s^2",
    "speed_cmd": "m/s",
    "steer_cmd": "rad",
    "x": "m",
    "y": "m",
    "yaw": "rad",
    "v": "m/s",
    "yaw_rate": "rad/s",
    "ax": "m/s^2",
    "ay": "m/s^2",
}
SIGMA = {"x": 0.02, "y": 0.02, "yaw": 0.005, "v": 0.03, "yaw_rate": 0.005, "ax": 0.1, "ay": 0.1}
"""White noise at level "mid", in the units above; "low" is half of it, "high" twice."""
FACTOR = {"none": 0.0, "low": 0.5, "mid": 1.0, "high": 2.0}
DRIFT_SIGMA, DRIFT_TIME = 0.02, 30.0  # m at level "mid", s: of the position


def fine_truth(
    effects: Effects, drive: Drive = "rich", seed: int = 0, *, car: TruthCar | None = None, body: str = "auto"
) -> tuple[FloatArray, FloatArray]:
    """Commands (n, 3: accel, steer, speed) and the motion (n * SUBSTEPS, 8: FINE) without sensors.

    `body` "dynamic" gives the car slipping tyres (`TruthCar.stiffness_*`), whatever the effects need.
    """
    plant = {name: values for name, values in checked(effects).items() if name in PLANT}
    key = tuple((name, tuple(values.items())) for name, values in plant.items())
    return _simulated(key, drive, seed, car or TruthCar(), body)


@lru_cache(maxsize=4)  # the same drive is often asked for again: other noise, other sensor effects
def _simulated(
    plant: tuple[tuple[str, tuple[tuple[str, float], ...]], ...], drive: Drive, seed: int, car: TruthCar, body: str
) -> tuple[FloatArray, FloatArray]:
    effects = {name: dict(values) for name, values in plant}
    p = parameters(car, effects)
    if body == "dynamic":
        p[C_DYNAMIC] = 1.0
        if "understeer" not in effects:
            p[C_CF], p[C_CR] = car.stiffness_front, car.stiffness_rear
    driver = Driver(drive, car.wheelbase, seed)
    n = driver.samples
    commands = np.zeros((n, 3))
    fine = np.empty((n * SUBSTEPS, len(FINE)))
    s = np.zeros(N_STATE)
    for k in range(n):
        commands[k] = driver.wish(k * PERIOD, Motion(float(s[0]), float(s[1]), float(s[2]), float(s[V])))
        if k == 0:  # the steering rests where it is first asked to be
            for place in (D_LAG, D_RATE, D_STICK, D_RES, D_FREE):
                s[place] = commands[0, 1]
        advance(s, p, commands, k, fine[k * SUBSTEPS : (k + 1) * SUBSTEPS])
    commands.flags.writeable = fine.flags.writeable = False
    return commands, fine


def late(signal: FloatArray, delay: float) -> FloatArray:
    """The fine signal at the stamps of the log, `delay` [s] old; before the log its first value."""
    stamps = np.arange(0, len(signal), SUBSTEPS)
    return np.asarray(np.interp(stamps - delay / H, np.arange(len(signal)), signal))


def smooth(signal: FloatArray, tau: float) -> FloatArray:
    """The fine signal behind a first-order low pass of time constant `tau` [s], at rest before it. A value holds until
    the next one, as a command does."""
    if tau <= 0.0:
        return signal
    kept = float(np.exp(-H / tau))
    return np.asarray(lfilter([0.0, 1.0 - kept], [1.0, -kept], signal, zi=[signal[0]])[0])


def sensed(fine: FloatArray, effects: Effects) -> dict[str, FloatArray]:
    """What perfect sensors with the given sensor effects show at 50 Hz."""
    e = checked(effects)

    def of(name: str, key: str) -> float:
        return e[name][key] if name in e else KNOWN[name][key][0]

    columns = {name: fine[:, k] for k, name in enumerate(FINE)}
    c, s = np.cos(columns["yaw"]), np.sin(columns["yaw"])
    arm_x, arm_y = of("gnss_lever_arm", "x"), of("gnss_lever_arm", "y")
    old = of("gnss_latency", "T")
    tau = of("accelerometer_filter", "tau")
    ax, ay = (late(smooth(columns[name], tau), 0.0) for name in ("ax", "ay"))
    angle = of("imu_misalignment", "angle")
    ax, ay = (1.0 + of("pitch", "gain")) * ax, (1.0 + of("roll", "gain")) * ay
    ax, ay = np.cos(angle) * ax + np.sin(angle) * ay, np.cos(angle) * ay - np.sin(angle) * ax
    return {
        "x": late(columns["x"] + arm_x * c - arm_y * s, old),
        "y": late(columns["y"] + arm_x * s + arm_y * c, old),
        "yaw": late(columns["yaw"], old) + of("heading_bias", "b"),
        "v": late(columns["v"], 0.0) * of("wheel_radius", "ratio"),
        "yaw_rate": late(columns["yaw_rate"], of("yaw_rate_latency", "T")) + of("gyro_bias", "b"),
        "ax": ax + of("accelerometer_bias", "b"),
        "ay": ay + of("lateral_accelerometer_bias", "b"),
    }


def drift(n: int, sigma: float, rng: np.random.Generator, period: float = PERIOD) -> FloatArray:
    """Slow wandering: first-order Gauss-Markov with DRIFT_TIME, that starts at zero."""
    keep = np.exp(-period / DRIFT_TIME)
    kicks = rng.normal(0.0, sigma * np.sqrt(1.0 - keep * keep), n)
    kicks[0] = 0.0
    return np.asarray(lfilter([1.0], [1.0, -keep], kicks))


def add_noise(columns: dict[str, FloatArray], noise: Noise, seed: int) -> dict[str, FloatArray]:
    """The measured columns with white noise, position with drift, too; commands and stamps as they are."""
    factor = FACTOR[noise]
    rng = np.random.default_rng([seed, 77])
    out = dict(columns)
    for name in MEASURED:
        n = len(columns[name])
        white = rng.normal(0.0, SIGMA[name] * factor, n)
        if name in ("x", "y"):
            white += drift(n, DRIFT_SIGMA * factor, rng)
        out[name] = columns[name] + white
    return out


def make_log(
    effects: Effects,
    drive: Drive = "rich",
    seed: int = 0,
    noise: Noise = "mid",
    *,
    car: TruthCar | None = None,
    body: str = "auto",
) -> dict[str, FloatArray]:
    """Columns of one log, each float64 (n,), in the order of a file; same arguments, same bytes.

    With an effect of SPEED_MODE the car takes a speed: column speed_cmd in place of accel_cmd.
    """
    commands, fine = fine_truth(effects, drive, seed, car=car, body=body)
    by_speed = bool(SPEED_MODE & set(effects))
    columns = {"t": np.round(np.arange(len(commands)) * PERIOD, 6)}
    columns["speed_cmd" if by_speed else "accel_cmd"] = commands[:, 2 if by_speed else 0].copy()
    columns["steer_cmd"] = commands[:, 1].copy()
    salt = int.from_bytes(hashlib.sha256(drive.encode()).digest()[:4], "little")
    return add_noise(columns | sensed(fine, effects), noise, (seed << 32) + salt)


def write_csv(path: Path, columns: dict[str, FloatArray]) -> None:
    """The log as a file that the import reads."""
    header = ",".join(f"{name} [{UNITS[name]}]" for name in columns)
    np.savetxt(path, np.column_stack(list(columns.values())), fmt="%.6g", delimiter=",", header=header, comments="")


def parse_effects(texts: list[str]) -> dict[str, dict[str, float]]:
    """`name:key=value,key=value` as on the command line."""
    found: dict[str, dict[str, float]] = {}
    for text in texts:
        name, _, rest = text.partition(":")
        pairs = [pair.partition("=") for pair in rest.split(",") if pair]
        found[name] = {key: float(value) for key, _, value in pairs}
    return checked(found)


def main() -> int:
    """Write one log."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--effect", action="append", default=[], metavar="NAME:KEY=VALUE,...")
    parser.add_argument("--drive", choices=("rich", "urban"), default="rich")
    parser.add_argument("--noise", choices=tuple(FACTOR), default="mid")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, required=True)
    args = parser.parse_args()
    write_csv(args.out, make_log(parse_effects(args.effect), args.drive, args.seed, args.noise))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
