"""The missing input of each hidden law over time, for peers of `discover`: the point is told, noise is filtered.

python -m benchmarks.discover.residuals --seed HEX --laws N --out runs/discover/residuals.npz
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from scipy.signal import savgol_filter

from benchmarks.discover.__main__ import made
from benchmarks.discover.hidden_laws import NAMES
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

WINDOW = 25  # samples, 0.5 s, of a local cubic
STEP = 0.02  # s
POINTS = {"churning": "along", "root_drag": "along", "drag_in_turns": "along", "idle_drag": "along",
          "speed_gain": "along", "hot_motor": "along", "brake_threshold": "along", "boost": "along",
          "gyro_by_acceleration": "yaw_rate", "cross_axis_gyro": "yaw_rate", "speed_by_cornering": "v"}  # fmt: skip
"""Where a law acts; the rest act on the steering."""


def features(log: Log) -> dict[str, FloatArray]:
    """Quantities (n,) in SI units, as measured and filtered; memories with the usual time of 20 s."""
    c = log.columns
    v, r, ax, ay = (savgol_filter(c[name], WINDOW, 3) for name in ("v", "yaw_rate", "ax", "ay"))
    drive, brake = np.maximum(c["accel_cmd"], 0.0), np.maximum(-c["accel_cmd"], 0.0)
    found = {"v": v, "d": c["steer_cmd"], "a+": drive, "a-": brake, "ax": ax, "ay": ay, "|ay|": np.abs(ay), "r": r,
             "|d|": np.abs(c["steer_cmd"])}  # fmt: skip
    for name, inner in (("lag(v a+)", v * drive), ("lag(a+)", drive), ("lag(v |ay|)", v * np.abs(ay))):
        found[name] = _lag(inner, 20.0)
    return found


def _lag(values: FloatArray, tau: float) -> FloatArray:
    found = np.zeros(len(values))
    for k in range(1, len(values)):
        found[k] = found[k - 1] + (values[k] - found[k - 1]) * STEP / tau
    return found


def missing(log: Log, point: str, wheelbase: float) -> FloatArray:
    """What the model lacks at a point (n,): rad of steering, m/s^2 along the car, rad/s or m/s of a sensor."""
    c = log.columns
    v, r = savgol_filter(c["v"], WINDOW, 3), savgol_filter(c["yaw_rate"], WINDOW, 3)
    if point == "along":
        return np.asarray(savgol_filter(c["v"], WINDOW, 3, deriv=1, delta=STEP) - c["accel_cmd"])
    if point == "yaw_rate":
        return np.asarray(c["yaw_rate"] - v * np.tan(c["steer_cmd"]) / wheelbase)
    if point == "v":
        way = [savgol_filter(c[name], WINDOW, 3, deriv=1, delta=STEP) for name in "xy"]
        return np.asarray(c["v"] - np.hypot(*way))
    return np.asarray(np.arctan2(wheelbase * r, np.maximum(v, 1.0)) - c["steer_cmd"])


def main() -> int:
    """Write features and missing inputs of fitted and held-out drives. Returns 0."""
    parser = argparse.ArgumentParser(description="The missing inputs of hidden laws, for peers of `dvp discover`")
    parser.add_argument("--seed", required=True, metavar="HEX")
    parser.add_argument("--laws", type=int, default=18)
    parser.add_argument("--out", type=Path, required=True, metavar="F")
    args = parser.parse_args()
    kept: dict[str, FloatArray] = {}
    for number in range(args.laws):
        model, logs, judge, told = made(int(args.seed, 16), number, null=False)
        name = NAMES[number % len(NAMES)]
        for side, log in (("fit", *logs.values()), ("held", *judge.values())):
            moving = np.abs(log.columns["v"]) > 2.0
            key = f"{name}/{number}|{told['true']['form']}|{side}"
            kept[f"{key}|u"] = missing(log, POINTS.get(name, "steer"), model.car.wheelbase)[moving]
            for feature, values in features(log).items():
                kept[f"{key}|{feature}"] = values[moving]
    args.out.parent.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(args.out, **kept)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
