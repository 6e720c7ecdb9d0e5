"""Record the multi-body cars of CommonRoad as test logs: a truth that nobody here wrote.

    python -m scripts.record_multibody [--out tests/data/multibody] [--car 2]

Source: M. Althoff, G. Wuersching, "CommonRoad: Vehicle Models", TU Muenchen, 2020; PyPI `commonroad-vehicle-models`
3.0.2, BSD licence; 29 states after R. W. Allen et al., "Vehicle Dynamics Stability and Rollover", DOT HS 807 956, 1992.
The package is installed into a temporary environment of its own, never into ours. The logs hold its output only, none
of its code. They are free of sensor noise: `tests.truth.multibody` adds that.

What the recorder adds to the model: a steering servo that turns as fast as the model allows (its input is the steering
rate), a stop at standstill (the model would go on into reverse), and rolling wheels below 0.1 m/s, where the model
is kinematic and its tyres carry nothing.
"""

from __future__ import annotations

import argparse
import gzip
import io
import math
import subprocess
import sys
import tempfile
import venv
from pathlib import Path
from typing import Any

PACKAGE = "commonroad-vehicle-models==3.0.2"
ROOT = Path(__file__).resolve().parents[1]
CARS = {1: "ford_escort", 2: "bmw_320i", 3: "vw_vanagon"}
HEADER = "t [s],accel_cmd [m/s^2],steer_cmd [rad],x [m],y [m],yaw [rad],v [m/s],yaw_rate [rad/s],ax [m/s^2],ay [m/s^2]"
GRAVITY = 9.81  # m/s^2, as in the recorded model
SLOW = 0.1  # m/s, below this speed the model is kinematic
FINEST, COARSEST = 3e-5, 1e-3  # s
# s per m/s: wheels on slipping tyres settle at some 5500 1/s x (1 m/s)/v; RK4 is stable up to 2.8 of it
STEP_PER_SPEED = 3e-4


def record(car: int, drive: str, seed: int) -> str:
    """One log as CSV text. Runs inside the temporary environment only."""
    from vehiclemodels.init_mb import init_mb  # type: ignore[import-not-found]
    from vehiclemodels.vehicle_dynamics_mb import vehicle_dynamics_mb  # type: ignore[import-not-found]
    from vehiclemodels.vehicle_parameters import setup_vehicle_parameters  # type: ignore[import-not-found]

    from vehicle.surrogate.driver import PERIOD, Driver, Motion

    p: Any = setup_vehicle_parameters(vehicle_id=car)
    driver = Driver(drive, p.a + p.b, seed, max_steer=0.5)  # type: ignore[arg-type]
    x: list[float] = [float(s) for s in init_mb([p.b, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], p)]

    def rhs(state: list[float], rate: float, accel: float) -> list[float]:
        f: list[float] = vehicle_dynamics_mb(list(state), [rate, accel], p)
        if abs(state[3]) < SLOW:
            for k in range(23, 27):
                f[k] = accel / p.R_w
        return f

    def rk4(state: list[float], rate: float, accel: float, h: float) -> list[float]:
        k1 = rhs(state, rate, accel)
        k2 = rhs([s + 0.5 * h * d for s, d in zip(state, k1, strict=True)], rate, accel)
        k3 = rhs([s + 0.5 * h * d for s, d in zip(state, k2, strict=True)], rate, accel)
        k4 = rhs([s + h * d for s, d in zip(state, k3, strict=True)], rate, accel)
        return [s + h / 6.0 * (a + 2.0 * b + 2.0 * c + d) for s, a, b, c, d in zip(state, k1, k2, k3, k4, strict=True)]

    out = io.StringIO()
    out.write(HEADER + "\n")
    for k in range(driver.samples):
        t = k * PERIOD
        yaw = x[4]
        rear_x, rear_y = x[0] - p.b * math.cos(yaw), x[1] - p.b * math.sin(yaw)
        wish = driver.wish(t, Motion(rear_x, rear_y, yaw, x[3]))
        standing = x[3] <= 0.0 and wish.accel <= 0.0
        if standing:
            ax = ay = rate_of_yaw = 0.0
        else:
            f = rhs(x, _servo(x[2], wish.steer, COARSEST, p), wish.accel)
            rate_of_yaw = x[5]
            # at the rear axle, in the frame of the body: it rolls out of the turn (x[6] < 0 in a left one), dives when
            # braked (x[8] < 0), and then also feels gravity
            ax = f[3] - x[5] * x[10] + p.b * x[5] * x[5]
            ay = f[10] + x[5] * x[3] - p.b * f[5]
            ax += GRAVITY * math.sin(x[8])
            ay -= GRAVITY * math.sin(x[6])
        row = (t, wish.accel, wish.steer, rear_x, rear_y, yaw, x[3], rate_of_yaw, ax, ay)
        out.write(",".join(_short(value) for value in row) + "\n")
        left = PERIOD
        while left > 1e-12:
            h = min(left, max(FINEST, min(COARSEST, STEP_PER_SPEED * x[3])))
            left -= h
            rate = _servo(x[2], wish.steer, h, p)
            if x[3] <= 0.0 and wish.accel <= 0.0:
                x[2] += h * rate
                continue
            x = rk4(x, rate, wish.accel, h)
            if x[3] <= 0.0 and wish.accel <= 0.0:
                pose = [*x[:3], 0.0, x[4]]
                x = [float(s) for s in init_mb([*pose[:4], pose[4], 0.0, 0.0], p)]
    return out.getvalue()


def _servo(angle: float, wanted: float, h: float, p: Any) -> float:
    """Steering rate that gets to `wanted` [rad] within `h` [s] if the car allows."""
    rate = (wanted - angle) / h
    return min(max(rate, float(p.steering.v_min)), float(p.steering.v_max))


def _short(value: float) -> str:
    """Ten micrometres, ten microradians: far below the noise that is added later."""
    text = f"{value:.5f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def write(path: Path, text: str) -> None:
    """Compressed without name and time: same log, same bytes."""
    with path.open("wb") as raw, gzip.GzipFile("", "wb", 9, raw, mtime=0) as packed:
        packed.write(text.encode())


def main() -> int:
    """Make the environment, start this file in it, once a car."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--out", type=Path, default=ROOT / "tests" / "data" / "multibody")
    parser.add_argument("--car", type=int, choices=sorted(CARS), action="append")
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    args = parser.parse_args()
    cars = args.car or sorted(CARS)
    out: Path = args.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    if not args.inside:
        with tempfile.TemporaryDirectory() as folder:
            venv.create(folder, with_pip=True)
            python = Path(folder) / ("Scripts" if sys.platform == "win32" else "bin") / "python"
            subprocess.run([python, "-m", "pip", "install", "-q", PACKAGE], check=True)
            options = ["--inside", "--out", str(out), "--seed", str(args.seed)]
            for car in cars:
                here = [str(python), "-m", "scripts.record_multibody", *options, "--car", str(car)]
                subprocess.run(here, check=True, cwd=ROOT)
        return 0
    for car in cars:
        for drive in ("rich", "urban"):
            write(out / f"{CARS[car]}_{drive}.csv.gz", record(car, drive, args.seed))
            print(f"{CARS[car]} {drive}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
