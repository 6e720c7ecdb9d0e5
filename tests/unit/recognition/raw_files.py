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
    """A file and how to write it: signals of the log that must come out right; full_steer [rad]: of a command of 1;
    mirrored: all that has a side is turned round together, which nothing in the file contradicts."""

    name: str
    write: Callable[[Path, Columns], None]
    signals: tuple[str, ...]
    wheelbase: float | None = WHEELBASE
    full_steer: float = 0.45
    mirrored: bool = False


def csv(path: Path, columns: Mapping[str, FloatArray], mark: str = ",", point: str = ".", head: str = "") -> None:
    rows = np.column_stack(list(columns.values()))
    lines = [mark.join("" if np.isnan(value) else f"{value:.19g}".replace(".", point) for value in row) for row in rows]
    path.write_text(head + mark.join(columns) + "\n" + "\n".join(lines) + "\n", encoding="utf-8")


def _wrapped(angle: FloatArray, turn: float = 2.0 * np.pi) -> FloatArray:
    return (angle + 0.5 * turn) % turn - 0.5 * turn


def german(path: Path, d: Columns) -> None:
    csv(path, {"Zeit": d["t"], "Geschwindigkeit": d["v"] * KMH, "Gierrate": d["yaw_rate"] * DEG,
                "Querbeschleunigung": d["ay"], "Laengsbeschleunigung": d["ax"],
                "Lenkradwinkel": d["steer_cmd"] * DEG * 15.8}, ";", ",")  # fmt: skip


def can_bus(path: Path, d: Columns) -> None:
    csv(path, {"timestamp": d["t"] * 1e3 + 1.7e12, "VehSpd": d["v"] * KMH, "YawRate": d["yaw_rate"] * DEG,
                "LatAcc": d["ay"] / G, "LongAcc": d["ax"] / G, "StrWhlAng": d["steer_cmd"] * DEG * 14.6,
                "EngRpm": 900.0 + 80.0 * d["v"]})  # fmt: skip


def rostopic(path: Path, d: Columns) -> None:
    half = 0.5 * d["yaw"]
    stamp = np.round((d["t"] + 1.65e9) * 1e9)
    zero = np.zeros(len(half))
    csv(path, {"%time": stamp, "field.header.seq": np.arange(len(half)) * 1.0,
                "field.pose.pose.position.x": d["x"], "field.pose.pose.position.y": d["y"],
                "field.pose.pose.orientation.x": zero, "field.pose.pose.orientation.y": zero,
                "field.pose.pose.orientation.z": np.sin(half), "field.pose.pose.orientation.w": np.cos(half),
                "field.twist.twist.linear.x": d["v"], "field.twist.twist.angular.z": d["yaw_rate"],
                "field.drive.steering_angle": d["steer_cmd"]})  # fmt: skip


def foxglove(path: Path, d: Columns) -> None:
    csv(path, {"elapsed time": d["t"], "/odom/pose/pose/position/x": d["x"], "/odom/pose/pose/position/y": d["y"],
                "/odom/twist/twist/linear/x": d["v"], "/imu/angular_velocity/z": d["yaw_rate"],
                "/imu/linear_acceleration/x": d["ax"], "/imu/linear_acceleration/y": d["ay"],
                "/cmd/steering_angle": d["steer_cmd"]})  # fmt: skip


def gnss(path: Path, d: Columns) -> None:
    latitude = ORIGIN[0] + np.degrees(d["y"] / 6.365e6)
    longitude = ORIGIN[1] + np.degrees(d["x"] / (6.391e6 * np.cos(np.radians(ORIGIN[0]))))
    compass = (90.0 - d["yaw"] * DEG) % 360.0
    csv(path, {"Time": d["t"], "Latitude": latitude, "Longitude": longitude, "Heading": compass,
                "Speed": d["v"] * KNOT, "Gyro": -d["yaw_rate"] * DEG, "Steering": d["steer_cmd"] * DEG})  # fmt: skip


def nmea(path: Path, d: Columns) -> None:
    latitude = ORIGIN[0] + np.degrees(d["y"] / 6.365e6)
    longitude = ORIGIN[1] + np.degrees(d["x"] / (6.391e6 * np.cos(np.radians(ORIGIN[0]))))

    def minutes(angle: FloatArray) -> FloatArray:
        return np.trunc(angle) * 100.0 + (angle - np.trunc(angle)) * 60.0

    csv(path, {"time": d["t"], "lat": minutes(latitude), "lon": minutes(longitude),
                "course": (90.0 - d["yaw"] * DEG) % 360.0, "spd": d["v"] * KNOT, "wz": d["yaw_rate"],
                "delta": d["steer_cmd"]})  # fmt: skip


def no_position(path: Path, d: Columns) -> None:
    csv(path, {"t": d["t"], "v": d["v"] * KMH, "r": d["yaw_rate"], "ay": d["ay"], "ax": d["ax"],
                "delta": d["steer_cmd"]})  # fmt: skip


def channels(path: Path, d: Columns) -> None:
    csv(path, {"ch0": d["t"], "ch1": d["v"], "ch2": d["yaw_rate"] * DEG, "ch3": d["ay"], "ch4": d["steer_cmd"],
                "x": d["x"], "y": d["y"], "ch5": d["yaw"]})  # fmt: skip


def motion_capture(path: Path, d: Columns) -> None:
    csv(path, {"": np.arange(len(d["t"])) * 1.0, "time_us": d["t"] * 1e6 + 5e8, "px": d["x"] * 1e3, "py": d["y"] * 1e3,
                "theta": _wrapped(d["yaw"]) * DEG, "wheel_encoder_speed": d["v"], "steering": d["steer_cmd"] / 0.45,
                "throttle": np.clip(d["accel_cmd"] / 3.0, 0, 1) * 100.0})  # fmt: skip


def seaman(path: Path, d: Columns) -> None:
    """x to the north and y to the east, heading and all in the car positive to the right."""
    csv(path, {"t": d["t"], "north": d["y"], "east": d["x"], "psi": 0.5 * np.pi - d["yaw"], "u": d["v"],
                "r": -d["yaw_rate"], "ay": -d["ay"], "delta_f": -d["steer_cmd"]})  # fmt: skip


def american(path: Path, d: Columns) -> None:
    csv(path, {"Elapsed Time (s)": d["t"], "GPS Speed (mph)": d["v"] * MPH, "Yaw Rate (deg/s)": d["yaw_rate"] * DEG,
                "Lateral Accel (g)": d["ay"] / G, "Longitudinal Accel (g)": d["ax"] / G,
                "Steering Wheel Angle (deg)": d["steer_cmd"] * DEG * 16.2},
         head='"Logger: XY-7"\n"Driver: unknown"\n')  # fmt: skip


def sparse(path: Path, d: Columns) -> None:
    """Each sensor at its own rate, empty where it did not speak; the inertial unit is mounted turned round."""

    def every(values: FloatArray, n: int, shift: int = 0) -> FloatArray:
        found = np.full(len(values), np.nan)
        found[shift::n] = values[shift::n]
        return found

    csv(path, {"stamp": d["t"] + 12.5, "gps_x": every(d["x"], 10), "gps_y": every(d["y"], 10),
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


def openpilot(path: Path, d: Columns) -> None:
    latitude = ORIGIN[0] + np.degrees(d["y"] / 6.365e6)
    longitude = ORIGIN[1] + np.degrees(d["x"] / (6.391e6 * np.cos(np.radians(ORIGIN[0]))))
    csv(path, {"mono_time": np.round(d["t"] * 1e9 + 3e12), "carState.vEgo": d["v"], "carState.aEgo": d["ax"],
                "carState.steeringAngleDeg": d["steer_cmd"] * DEG * 13.7, "carState.yawRate": d["yaw_rate"],
                "gps.latitude": latitude, "gps.longitude": longitude,
                "carState.gasPressed": 1.0 * (d["accel_cmd"] > 0.1),
                "carControl.accel_cmd": d["accel_cmd"]})  # fmt: skip


def inertial_navigation(path: Path, d: Columns) -> None:
    """Names in one row, units in the next one."""
    latitude = ORIGIN[0] + np.degrees(d["y"] / 6.365e6)
    longitude = ORIGIN[1] + np.degrees(d["x"] / (6.391e6 * np.cos(np.radians(ORIGIN[0]))))
    rows = np.column_stack([d["t"] + 3.5e5, latitude, longitude, (90.0 - d["yaw"] * DEG) % 360.0, d["v"] * KMH,
                            -d["yaw_rate"] * DEG, d["ax"] / G, -d["ay"] / G, d["steer_cmd"] * DEG])  # fmt: skip
    head = "GpsTime;PosLat;PosLon;AngleHeading;VelForward;AngRateZ;AccelForward;AccelLateral;SteerAngle\n"
    head += "s;deg;deg;deg;km/h;deg/s;g;g;deg\n"
    lines = [";".join(f"{value:.12g}" for value in row) for row in rows]
    path.write_text(head + "\n".join(lines) + "\n")


def two_velocities(path: Path, d: Columns) -> None:
    """No speed, but its parts to the east and the north, in knots; positions in feet."""
    csv(path, {"TOW_ms": d["t"] * 1e3 + 4e8, "E_ft": d["x"] / 0.3048, "N_ft": d["y"] / 0.3048,
                "VelE": d["v"] * np.cos(d["yaw"]) * KNOT, "VelN": d["v"] * np.sin(d["yaw"]) * KNOT,
                "GyroZ": d["yaw_rate"] * DEG, "swa": d["steer_cmd"] * 18.0})  # fmt: skip


def only_positions(path: Path, d: Columns) -> None:
    """Motion capture and commands: no column measures a speed."""
    csv(path, {"elapsed": d["t"], "optitrack_x": d["x"], "optitrack_y": d["y"], "optitrack_yaw": _wrapped(d["yaw"]),
                "cmd_steer": -d["steer_cmd"] / 0.5, "cmd_throttle": np.clip(d["accel_cmd"] / 3.0, 0, 1)})  # fmt: skip


def wheels(path: Path, d: Columns) -> None:
    half = 0.75 * d["yaw_rate"]
    csv(path, {"time": d["t"], "x_utm": d["x"] + 5.9e5, "y_utm": d["y"] + 5.76e6, "WhlSpd_FL": (d["v"] - half) * KMH,
                "WhlSpd_FR": (d["v"] + half) * KMH, "WhlSpd_RL": (d["v"] - half) * KMH,
                "WhlSpd_RR": (d["v"] + half) * KMH, "ESP_yaw": d["yaw_rate"] * DEG, "ESP_lat_acc": d["ay"],
                "EPS_angle": d["steer_cmd"] * DEG * 15.0})  # fmt: skip


def blanks(path: Path, d: Columns) -> None:
    """What numpy.savetxt writes, with a header that it comments out."""
    rows = np.column_stack([d["t"], d["x"], d["y"], d["yaw"], d["v"], d["steer_cmd"]])
    np.savetxt(path, rows, header="t x y yaw v delta")


def headless(path: Path, d: Columns) -> None:
    """Numbers and nothing else."""
    rows = np.column_stack([d["t"], d["v"], d["yaw_rate"], d["ay"], d["ax"], d["steer_cmd"]])
    np.savetxt(path, rows, delimiter=",", fmt="%.9g")


def nameless(path: Path, d: Columns) -> None:
    """Numbers and nothing else, positions and heading among them, in km/h and degrees."""
    rows = np.column_stack([d["t"], d["y"], d["x"], d["v"] * KMH, _wrapped(d["yaw"]), d["yaw_rate"] * DEG, d["ay"],
                            d["ax"], d["steer_cmd"] * DEG])  # fmt: skip
    np.savetxt(path, rows, delimiter=";", fmt="%.9g")


def bars(path: Path, d: Columns) -> None:
    rows = np.column_stack([np.arange(len(d["t"])), d["t"], d["x"] * 100.0, d["y"] * 100.0, d["yaw"] * DEG,
                            d["v"], d["yaw_rate"], d["steer_cmd"] * DEG])  # fmt: skip
    lines = [" | ".join(f"{value:.9g}" for value in row) for row in rows]
    path.write_text("No | sec | pos x | pos y | heading | speed | gyro z | wheel angle\n" + "\n".join(lines) + "\n")


def dates(path: Path, d: Columns) -> None:
    """ISO 8601 stamps, quoted, and a word in each row."""
    rows = zip(d["t"], d["v"] * KMH, d["yaw_rate"] * DEG, d["ay"] / G, d["steer_cmd"] * DEG, strict=True)
    lines = ['"timestamp","state","speed","yaw rate","lat accel","front wheel angle"']
    for t, *values in rows:
        stamp = f'"2024-05-01T12:{int(t // 60):02d}:{t % 60:09.6f}Z","AUTO"'
        lines.append(",".join([stamp, *(f"{value:.6f}" for value in values)]))
    path.write_text("\n".join(lines) + "\n")


def race_car(path: Path, d: Columns) -> None:
    """A lap timer: percent of pedals, g, degrees, and channels that mislead."""
    csv(path, {"Time": d["t"], "Distance": np.cumsum(d["v"]) * 0.02, "Ground Speed": d["v"] * KMH,
                "CAN Speed": 1.08 * d["v"] * KMH, "G Force Lat": -d["ay"] / G, "G Force Long": d["ax"] / G,
                "Gyro Yaw": -d["yaw_rate"] * DEG, "Gyro Roll": 0.3 * d["ay"], "Steer Pos": -d["steer_cmd"] * DEG * 12.0,
                "Throttle Pos": np.clip(d["accel_cmd"] / 3.0, 0, 1) * 100.0,
                "Engine Temp": 88.0 + 0.01 * d["t"]})  # fmt: skip


def left_handed(path: Path, d: Columns) -> None:
    """A game engine: x forward on the map, y to the right, yaw clockwise in degrees."""
    csv(path, {"sim_time": d["t"], "Location.X": d["x"], "Location.Y": -d["y"],
                "Rotation.Yaw": -_wrapped(d["yaw"]) * DEG,
                "Speed": d["v"] * KMH, "AngularVelocity.Z": -d["yaw_rate"] * DEG, "Steer": -d["steer_cmd"] / 0.61,
                "Throttle": np.clip(d["accel_cmd"] / 3.0, 0, 1)})  # fmt: skip


def controller(path: Path, d: Columns) -> None:
    """Wanted and measured values side by side, and a reference path that looks like a position."""
    late = np.interp(d["t"] - 0.3, d["t"], d["v"])
    csv(path, {"t_sec": d["t"], "ref_x": d["x"] + 1.0, "ref_y": d["y"] - 0.5, "ref_yaw": d["yaw"],
                "est_x": d["x"], "est_y": d["y"], "est_psi": d["yaw"], "v_des": d["v"], "v_meas": late,
                "omega": d["yaw_rate"], "delta_des": d["steer_cmd"],
                "delta_meas": np.interp(d["t"] - 0.12, d["t"], d["steer_cmd"])})  # fmt: skip


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
    RawFile("openpilot.csv", openpilot, ("x", "y", "v", "yaw_rate", "ax", "steer", "accel_cmd")),
    RawFile("inertial_navigation.csv", inertial_navigation, (*MOTION, "ax", "ay", "steer")),
    RawFile("two_velocities.csv", two_velocities, ("x", "y", "v", "yaw_rate", "steer")),
    RawFile(
        "only_positions.csv", only_positions, ("x", "y", "yaw", "v", "throttle_cmd", "steer_cmd_norm"), full_steer=0.5
    ),
    RawFile("wheels.csv", wheels, ("x", "y", "v", "yaw_rate", "ay", "steer")),
    RawFile("blanks.txt", blanks, ("x", "y", "yaw", "v", "steer")),
    RawFile("nameless.csv", nameless, ("x", "y", "yaw", "v", "yaw_rate", "ay", "ax", "steer")),
    RawFile("bars.txt", bars, (*MOTION, "steer")),
    RawFile("dates.csv", dates, ("v", "yaw_rate", "ay", "steer")),
    RawFile("race_car.csv", race_car, ("v", "yaw_rate", "ay", "ax", "throttle_cmd", "steer"), mirrored=True),
    RawFile(
        "left_handed.csv", left_handed, (*MOTION, "throttle_cmd", "steer_cmd_norm"), full_steer=0.61, mirrored=True
    ),
    RawFile("controller.csv", controller, (*MOTION, "steer_cmd", "steer", "speed_cmd")),
)
