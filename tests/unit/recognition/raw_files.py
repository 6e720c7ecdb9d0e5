"""One drive of a car with known truth, written as recorders and their owners write it: units, frames, names, clocks."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path

import numpy as np

from pytest_dvp.logs.log_contents import FloatArray
from tests.truth.generate import make_log

WHEELBASE = 2.6  # m, of the car of `tests.truth`
DEG, G, KMH, KNOT, MPH = 180.0 / np.pi, 9.80665, 3.6, 3600.0 / 1852.0, 1.0 / 0.44704
ORIGIN = (52.0, 4.37)  # degrees
Columns = Mapping[str, FloatArray]


@cache
def truth(seed: int = 7, seconds: float = 70.0) -> dict[str, FloatArray]:
    """The drive in SI units, at 50 Hz."""
    log = make_log({}, "rich", seed, "low")  # type: ignore[arg-type]
    rows = (log["t"] >= 20.0) & (log["t"] < 20.0 + seconds)
    found = {name: np.ascontiguousarray(values[rows]) for name, values in log.items()}
    found["t"] = found["t"] - found["t"][0]
    return found


@dataclasses.dataclass(frozen=True)
class RawFile:
    """A file and how to write it: signal -> name in the log that must come out right; wheelbase given or not."""

    name: str
    write: Callable[[Path, Columns], None]
    signals: tuple[str, ...]
    wheelbase: float | None = WHEELBASE


def _csv(path: Path, columns: Mapping[str, FloatArray], mark: str = ",", point: str = ".", head: str = "") -> None:
    rows = np.column_stack(list(columns.values()))
    lines = [mark.join("" if np.isnan(value) else f"{value:.19g}".replace(".", point) for value in row) for row in rows]
    path.write_text(head + mark.join(columns) + "\n" + "\n".join(lines) + "\n", encoding="utf-8")


def _wrapped(angle: FloatArray, turn: float = 2.0 * np.pi) -> FloatArray:
    return (angle + 0.5 * turn) % turn - 0.5 * turn


def german(path: Path, d: Columns) -> None:
    _csv(path, {"Zeit": d["t"], "Geschwindigkeit": d["v"] * KMH, "Gierrate": d["yaw_rate"] * DEG,
                "Querbeschleunigung": d["ay"], "Laengsbeschleunigung": d["ax"],
                "Lenkradwinkel": d["steer_cmd"] * DEG * 15.8}, ";", ",")  # fmt: skip


def can_bus(path: Path, d: Columns) -> None:
    _csv(path, {"timestamp": d["t"] * 1e3 + 1.7e12, "VehSpd": d["v"] * KMH, "YawRate": d["yaw_rate"] * DEG,
                "LatAcc": d["ay"] / G, "LongAcc": d["ax"] / G, "StrWhlAng": d["steer_cmd"] * DEG * 14.6,
                "EngRpm": 900.0 + 80.0 * d["v"]})  # fmt: skip


def rostopic(path: Path, d: Columns) -> None:
    half = 0.5 * d["yaw"]
    stamp = np.round((d["t"] + 1.65e9) * 1e9)
    zero = np.zeros(len(half))
    _csv(path, {"%time": stamp, "field.header.seq": np.arange(len(half)) * 1.0,
                "field.pose.pose.position.x": d["x"], "field.pose.pose.position.y": d["y"],
                "field.pose.pose.orientation.x": zero, "field.pose.pose.orientation.y": zero,
                "field.pose.pose.orientation.z": np.sin(half), "field.pose.pose.orientation.w": np.cos(half),
                "field.twist.twist.linear.x": d["v"], "field.twist.twist.angular.z": d["yaw_rate"],
                "field.drive.steering_angle": d["steer_cmd"]})  # fmt: skip


def foxglove(path: Path, d: Columns) -> None:
    _csv(path, {"elapsed time": d["t"], "/odom/pose/pose/position/x": d["x"], "/odom/pose/pose/position/y": d["y"],
                "/odom/twist/twist/linear/x": d["v"], "/imu/angular_velocity/z": d["yaw_rate"],
                "/imu/linear_acceleration/x": d["ax"], "/imu/linear_acceleration/y": d["ay"],
                "/cmd/steering_angle": d["steer_cmd"]})  # fmt: skip


def gnss(path: Path, d: Columns) -> None:
    latitude = ORIGIN[0] + np.degrees(d["y"] / 6.365e6)
    longitude = ORIGIN[1] + np.degrees(d["x"] / (6.391e6 * np.cos(np.radians(ORIGIN[0]))))
    compass = (90.0 - d["yaw"] * DEG) % 360.0
    _csv(path, {"Time": d["t"], "Latitude": latitude, "Longitude": longitude, "Heading": compass,
                "Speed": d["v"] * KNOT, "Gyro": -d["yaw_rate"] * DEG, "Steering": d["steer_cmd"] * DEG})  # fmt: skip


def nmea(path: Path, d: Columns) -> None:
    latitude = ORIGIN[0] + np.degrees(d["y"] / 6.365e6)
    longitude = ORIGIN[1] + np.degrees(d["x"] / (6.391e6 * np.cos(np.radians(ORIGIN[0]))))

    def minutes(angle: FloatArray) -> FloatArray:
        return np.trunc(angle) * 100.0 + (angle - np.trunc(angle)) * 60.0

    _csv(path, {"time": d["t"], "lat": minutes(latitude), "lon": minutes(longitude),
                "course": (90.0 - d["yaw"] * DEG) % 360.0, "spd": d["v"] * KNOT, "wz": d["yaw_rate"],
                "delta": d["steer_cmd"]})  # fmt: skip


def no_position(path: Path, d: Columns) -> None:
    _csv(path, {"t": d["t"], "v": d["v"] * KMH, "r": d["yaw_rate"], "ay": d["ay"], "ax": d["ax"],
                "delta": d["steer_cmd"]})  # fmt: skip


def channels(path: Path, d: Columns) -> None:
    _csv(path, {"ch0": d["t"], "ch1": d["v"], "ch2": d["yaw_rate"] * DEG, "ch3": d["ay"], "ch4": d["steer_cmd"],
                "x": d["x"], "y": d["y"], "ch5": d["yaw"]})  # fmt: skip


def motion_capture(path: Path, d: Columns) -> None:
    _csv(path, {"": np.arange(len(d["t"])) * 1.0, "time_us": d["t"] * 1e6 + 5e8, "px": d["x"] * 1e3, "py": d["y"] * 1e3,
                "theta": _wrapped(d["yaw"]) * DEG, "wheel_encoder_speed": d["v"], "steering": d["steer_cmd"] / 0.45,
                "throttle": np.clip(d["accel_cmd"] / 3.0, 0, 1) * 100.0})  # fmt: skip


def seaman(path: Path, d: Columns) -> None:
    """x to the north and y to the east, heading and all in the car positive to the right."""
    _csv(path, {"t": d["t"], "north": d["y"], "east": d["x"], "psi": 0.5 * np.pi - d["yaw"], "u": d["v"],
                "r": -d["yaw_rate"], "ay": -d["ay"], "delta_f": -d["steer_cmd"]})  # fmt: skip


def american(path: Path, d: Columns) -> None:
    _csv(path, {"Elapsed Time (s)": d["t"], "GPS Speed (mph)": d["v"] * MPH, "Yaw Rate (deg/s)": d["yaw_rate"] * DEG,
                "Lateral Accel (g)": d["ay"] / G, "Longitudinal Accel (g)": d["ax"] / G,
                "Steering Wheel Angle (deg)": d["steer_cmd"] * DEG * 16.2},
         head='"Logger: XY-7"\n"Driver: unknown"\n')  # fmt: skip


def sparse(path: Path, d: Columns) -> None:
    """Each sensor at its own rate, empty where it did not speak; the inertial unit is mounted turned round."""

    def every(values: FloatArray, n: int, shift: int = 0) -> FloatArray:
        found = np.full(len(values), np.nan)
        found[shift::n] = values[shift::n]
        return found

    _csv(path, {"stamp": d["t"] + 12.5, "gps_x": every(d["x"], 10), "gps_y": every(d["y"], 10),
                "heading": every(d["yaw"], 10), "speed": every(d["v"], 5, 2), "imu_gz": every(-d["yaw_rate"], 2),
                "imu_ax": every(-d["ax"], 2), "imu_ay": every(-d["ay"], 2),
                "steer_cmd": every(d["steer_cmd"], 4, 1)})  # fmt: skip


def comment_header(path: Path, d: Columns) -> None:
    names = ["time", "pos_e", "pos_n", "yaw", "vel", "yawrate", "swa"]
    rows = np.column_stack([d["t"], d["x"], d["y"], d["yaw"], d["v"] * KMH, d["yaw_rate"], d["steer_cmd"] * 17.0])
    np.savetxt(path, rows, delimiter="\t", header="\t".join(names), comments="# ", fmt="%.9g")


def matlab(path: Path, d: Columns) -> None:
    from scipy.io import savemat

    log = {"time": d["t"], "X": d["x"], "Y": d["y"], "psi": d["yaw"] * DEG, "V": d["v"], "wz": d["yaw_rate"] * DEG,
           "a_y": d["ay"], "df": d["steer_cmd"] * DEG}  # fmt: skip
    savemat(path, {"meas": log})


MOTION = ("x", "y", "yaw", "v", "yaw_rate")
FILES = (
    RawFile("german.csv", german, ("v", "yaw_rate", "ay", "ax", "steer")),
    RawFile("can_bus.csv", can_bus, ("v", "yaw_rate", "ay", "ax", "steer")),
    RawFile("rostopic.csv", rostopic, (*MOTION, "steer")),
    RawFile("foxglove.csv", foxglove, ("x", "y", "v", "yaw_rate", "ax", "ay", "steer_cmd")),
    RawFile("gnss.csv", gnss, (*MOTION, "steer")),
    RawFile("nmea.csv", nmea, (*MOTION, "steer")),
    RawFile("no_position.csv", no_position, ("v", "yaw_rate", "ay", "ax", "steer")),
    RawFile("channels.csv", channels, (*MOTION, "ay", "steer")),
    RawFile("motion_capture.csv", motion_capture, ("x", "y", "yaw", "v", "throttle_cmd", "steer_cmd_norm")),
    RawFile("seaman.csv", seaman, (*MOTION, "ay", "steer")),
    RawFile("american.csv", american, ("v", "yaw_rate", "ay", "ax", "steer")),
    RawFile("sparse.csv", sparse, (*MOTION, "ax", "ay", "steer_cmd")),
    RawFile("comment_header.tsv", comment_header, (*MOTION, "steer")),
    RawFile("matlab.mat", matlab, (*MOTION, "ay", "steer")),
)
