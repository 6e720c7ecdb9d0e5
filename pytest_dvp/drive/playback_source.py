"""A log as a recording that can be played to the stack (`--dvp-vehicle replay:LOG`).

Bags with the topics of `vehicle/wire/topics.py` give their sensors' own messages. Any other log (a run of ours, CSV)
gives motion: position, speed, steering angle and inertial sensors are made from its columns, without noise; LiDAR and
camera, which it has not, are rendered from the scenario's road users.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import msgspec
import numpy as np

from pytest_dvp.drive.recorded_motion import check_motion
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_part import parse_argument
from vehicle.adapters.replay import Arrived, Recording
from vehicle.messages import (
    CameraFrame,
    FloatArray,
    GnssFix,
    Imu,
    LidarScan,
    Odometry,
    VehicleDescription,
)

STEP = 0.01  # s
MOTION, GNSS, LOOK = 2, 10, 10  # steps between messages of wheels and IMU; of GNSS; of LiDAR and camera
SIGMA, YAW_SIGMA = 0.02, 0.005  # m, rad: what a recorded pose is taken to be good for
STANDING = 0.5  # m/s


def open_recording(argument: str, car: VehicleDescription) -> tuple[Recording, bool]:
    """The recording of a log, `LOG` or `LOG@FROM:TO`, and whether it has LiDAR or camera.

    car: what is assumed of the car where the log says nothing. Raises LogError.
    """
    part = parse_argument(argument)
    if part.path.suffix in (".bag", ".db3") or (part.path / "metadata.yaml").is_file():
        from pytest_dvp.drive.bag_recording import has_topics, recording_of_bag

        if part.whole and has_topics(part.path):
            return recording_of_bag(part.path, car)
    from pytest_dvp.logs.read_log import read_log

    log = read_log(argument)
    ego = {name: value for name, value in (log.meta.get("ego") or {}).items() if name in car.__struct_fields__}
    return _of_columns(argument, log, msgspec.structs.replace(car, **ego)), False


def _of_columns(name: str, log: Log, car: VehicleDescription) -> Recording:
    given = {key: values - values[0] if key == "t" else values for key, values in log.columns.items()}
    check_motion(name, log.t, log.columns)
    t = given["t"]
    grid = np.arange(math.floor(t[-1] / STEP + 1e-6) + 1) * STEP

    def on_grid(key: str, otherwise: FloatArray) -> FloatArray:
        values = given.get(key)
        known = np.isfinite(values) if values is not None else np.zeros(0, dtype=bool)
        if values is None or known.sum() < 2:
            return otherwise
        return np.interp(grid, t[known], values[known])

    nothing = np.zeros(len(grid))
    x, y, v = (on_grid(key, nothing) for key in ("x", "y", "v"))
    turned = np.isfinite(given["yaw"])
    yaw = np.interp(grid, t[turned], np.unwrap(given["yaw"][turned]))
    rate = on_grid("yaw_rate", np.gradient(yaw, STEP) if len(grid) > 1 else nothing)
    moving = np.where(np.abs(v) > STANDING, v, np.inf)
    steer = on_grid("steer", np.arctan(car.wheelbase * rate / moving))
    ax = on_grid("ax", np.gradient(v, STEP) if len(grid) > 1 else nothing)
    ay = on_grid("ay", v * rate)
    z, vy = on_grid("z", nothing), on_grid("vy", nothing)
    rows = np.column_stack([grid, x, y, z, yaw, v, on_grid("vx", v), vy, rate, ax, ay, steer])
    car = msgspec.structs.replace(car, gnss_x=0.0, gnss_y=0.0, imu_x=0.0, imu_y=0.0, imu_yaw=0.0)  # as `_made` says
    return Recording(name, car, rows, _commands(given), _made(rows))


def _commands(given: dict[str, FloatArray]) -> FloatArray:
    if "steer_cmd" not in given or "accel_cmd" not in given:
        return np.zeros((0, 3))
    table = np.column_stack([given["t"], given["steer_cmd"], given["accel_cmd"]])
    return table[np.isfinite(table).all(axis=1)]


def _made(rows: FloatArray) -> Iterator[Arrived]:
    """Messages of ideal sensors at the reference point, and empty scans and images for the mirror to fill."""
    for k, row in enumerate(rows.tolist()):
        t, x, y, _, yaw, v, _, _, rate, ax, ay, steer = row
        if k % MOTION == 0:
            yield Arrived(t, Odometry(t, v, steer))
            yield Arrived(t, Imu(t, ax, ay, rate))
        if k % GNSS == 0:
            yield Arrived(t, GnssFix(t, x, y, SIGMA, math.remainder(yaw, 2.0 * math.pi), YAW_SIGMA))
        if k % LOOK == 0:
            yield Arrived(t, LidarScan(t, np.zeros((0, 3))))
            yield Arrived(t, CameraFrame(t, ()))
