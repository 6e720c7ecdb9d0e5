"""python -m benchmarks.raw_logs --seed HEX [--files N]

One car's drives, with any name, unit, sign and rate for each column by dice; no unit is ever stated. Prints how many
columns were taken for what they are, were left to the user, were taken for something else, or were not found.
"""

from __future__ import annotations

import argparse
from collections import Counter
from functools import cache

import numpy as np

from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.stream import Stream
from pytest_dvp.logs.time_column import clock_of
from pytest_dvp.logs.units import find_unit
from pytest_dvp.recognition.columns import columns_of
from pytest_dvp.recognition.recognise import recognise
from pytest_dvp.recognition.recognised import Recognised
from tests.truth.generate import make_log

WHEELBASE = 2.6  # m
DEG, G, KMH, KNOT, MPH = 180.0 / np.pi, 9.80665, 3.6, 3600.0 / 1852.0, 1.0 / 0.44704
NAMES = {
    "x,y": ("x,y", "X,Y", "pos_x,pos_y", "PosX,PosY", "east,north", "utm_e,utm_n", "px,py", "state.x,state.y",
            "rear_axle_x,rear_axle_y", "position/x,position/y", "Easting,Northing", "local_x,local_y"),
    "yaw": ("yaw", "heading", "psi", "theta", "Yaw Angle", "hdg", "orientation", "phi", "veh_heading", "course"),
    "v": ("v", "speed", "Velocity", "vx", "VehicleSpeed", "v_long", "spd", "u", "wheel_speed", "groundSpeed",
          "vel_odom"),
    "yaw_rate": ("yaw_rate", "r", "wz", "gyro_z", "omega", "YawRate", "psi_dot", "imu_yawrate", "angular_vel_z",
                 "GYR_Z"),
    "ax": ("ax", "acc_x", "LongAcc", "a_long", "imu.ax", "linear_acceleration_x", "AccelX", "Ax_imu"),
    "ay": ("ay", "acc_y", "LatAcc", "a_lat", "imu.ay", "linear_acceleration_y", "AccelY", "Ay_imu"),
    "steer_cmd": ("delta", "steer", "steering_angle", "SWA", "df", "StrWhlAngle", "steer_fb", "road_wheel_angle", "d"),
}  # fmt: skip
"""Of public logs, loggers and papers."""

SCALES = {
    "x,y": (1.0, 1.0, 1.0, 100.0, 1000.0), "yaw": (1.0, DEG), "v": (1.0, 1.0, KMH, KMH, MPH, KNOT),
    "yaw_rate": (1.0, DEG), "ax": (1.0, 1.0 / G), "ay": (1.0, 1.0 / G), "steer_cmd": (1.0, DEG, DEG * 15.5, 14.2),
}  # fmt: skip
ABSENT = {"x,y": 0.3, "yaw": 0.35, "ax": 0.4, "ay": 0.4, "yaw_rate": 0.15}  # chance that a signal is not there
CLOSE = 0.12  # of a factor: units are further apart; a ratio of the steering is an estimate
SIDED = ("y", "yaw", "yaw_rate", "ay", "steer_cmd")


@cache
def truth(seed: int) -> dict[str, FloatArray]:
    """A drive in SI units at 50 Hz."""
    return make_log({}, "rich", seed, "mid")  # type: ignore[arg-type]


def draw(rng: np.random.Generator) -> tuple[dict[str, FloatArray], dict[str, tuple[str, float]]]:
    """Columns by name in some order, and of each signal its column and what it was multiplied by."""
    true = truth(int(rng.integers(1, 12)))
    begin = int(rng.integers(0, 3000))
    rows = slice(begin, begin + int(rng.integers(1500, 4500)), int(rng.choice([1, 1, 2, 5])))
    columns: dict[str, FloatArray] = {"stamp": true["t"][rows]}
    told: dict[str, tuple[str, float]] = {}
    there = [signal for signal in SCALES if rng.random() > ABSENT.get(signal, 0.0)]
    for signal in rng.permutation(there):
        scale, names = float(rng.choice(SCALES[signal])), str(rng.choice(NAMES[signal])).split(",")
        for part, name in zip(signal.split(","), names, strict=True):
            factor = scale
            if part in ("yaw_rate", "ax", "ay", "steer_cmd") and rng.random() < 0.2 and "x,y" in there:
                factor = -scale
            values = factor * true[part][rows]
            if part == "yaw" and rng.random() < 0.5:
                turn = 360.0 if scale > 1.0 else 2.0 * np.pi
                values = (values + 0.5 * turn) % turn - 0.5 * turn
            columns[name] = values
            told[part] = name, factor
    return columns, told


def judged(signal: str, name: str, factor: float, found: dict[str, Recognised], *, mirrored: bool) -> str:
    """What became of a column: "right", "left", "wrong" or "missing"; mirrored: nothing tells the sides."""
    one = found.get(name)
    if one is None:
        return "missing"
    if one.name.removesuffix("_norm").replace("steer_cmd", "steer") != signal.replace("steer_cmd", "steer"):
        return f"wrong: {signal} as {one.name}" if one.decided else "left"
    if not one.decided or one.name.endswith("_norm"):
        return "left"
    unit = find_unit(one.unit)
    got = factor * one.sign * one.scale / one.ratio * (unit.scale if unit is not None else 1.0)
    if mirrored and signal in SIDED:
        got = abs(got)
    return "right" if abs(got - 1.0) < CLOSE else f"wrong: {signal} {got:.3g} times"


def main() -> int:
    """Print the figures and what was wrong. Returns 0."""
    parser = argparse.ArgumentParser(description="Names and units drawn by dice: what does `dvp map` make of them?")
    parser.add_argument("--seed", required=True, metavar="HEX")
    parser.add_argument("--files", type=int, default=100)
    args = parser.parse_args()
    count: dict[str, Counter[str]] = {}
    whole = Counter[str]()
    for number in range(args.files):
        columns, told = draw(np.random.default_rng([int(args.seed, 16), number]))
        stream = Stream("", "", columns["stamp"], {n: v for n, v in columns.items() if n != "stamp"})
        streams, clock, _ = clock_of([stream])
        found = {one.column.field: one for one in recognise(columns_of(streams, clock), WHEELBASE).signals}
        answers = {s: judged(s, *one, found, mirrored="x" not in told) for s, one in told.items()}
        for signal, answer in answers.items():
            count.setdefault(signal, Counter())[answer.partition(":")[0]] += 1
        worst = next(
            (w for w in ("wrong", "missing", "left") if any(a.startswith(w) for a in answers.values())), "right"
        )
        whole[worst] += 1
        odd = {s: (told[s][0], a) for s, a in answers.items() if a != "right"}
        print(f"{number}: {worst} {odd or ''}")
    print("files:", dict(whole))
    for signal, counter in count.items():
        print(f"{signal}: {dict(counter)}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
