"""Bags with the topics of a car on the wire, as recordings: its sensors' own messages, as they came.

When a message came is told by the bag's clock, which need not be the car's: the fastest message counts as undelayed.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from pytest_dvp.drive.recorded_motion import check_motion
from pytest_dvp.logs.account import Account, open_account
from pytest_dvp.logs.bag import messages, open_bag
from pytest_dvp.logs.formats.ros_bag import Decoder, bag_of
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.log_error import LogError
from vehicle.adapters.replay import Arrived, Recording, Sensed
from vehicle.messages import Imu, VehicleDescription

STEP = 0.01  # s
NEEDED = "/vehicle/odom"
SECOND = 1e-9  # s/ns
_KEPT = 600  # bytes that a kept message of motion takes in memory (CPython 3.11: a struct with 12 numbers)


def has_topics(path: Path) -> bool:
    """Whether a bag has the motion of a car on the wire."""
    with _open(path) as (reader, _):
        return NEEDED in {connection.topic for connection in reader.connections}


def recording_of_bag(path: Path, car: VehicleDescription) -> tuple[Recording, bool]:
    """The recording of a bag, and whether it has LiDAR or camera. `car` is what is assumed unless the bag tells.

    Raises LogError.
    """
    try:
        from vehicle.wire import convert, topics
    except ImportError:
        text = f"{path}: its messages need cyclonedds: pip install -e '.[ros2]' from the checkout"
        raise LogError(text, "log.extra_missing") from None
    sensors: dict[str, Callable[[Any], Any]] = {
        topics.IMU.name: convert.imu_from_ros,
        topics.FEEDBACK.name: convert.feedback_from_ros,
        topics.POINTS.name: convert.points_from_ros,
        topics.CAMERA.name: convert.camera_from_ros,
    }
    motions, commands, wheels = [], [], []
    forces: dict[float, Imu] = {}
    headings: dict[float, Any] = {}
    fastest = np.inf
    names = set()
    with _open(path) as (reader, account):
        for topic, came, message in _messages(reader, account):
            account.hold(_KEPT)
            names.add(topic)
            if topic == topics.DESCRIPTION.name:
                car = msgspec.json.decode(message.data, type=VehicleDescription)
            if not hasattr(message, "header"):
                continue
            fastest = min(fastest, came - convert.seconds(message.header))
            if topic == NEEDED:
                motions.append(convert.state_from_ros(message))
            elif topic == topics.REFERENCE_IMU.name:
                felt = convert.imu_from_ros(message, turns=False)
                if isinstance(felt, Imu):
                    forces[felt.t] = felt
            elif topic == topics.COMMAND.name:
                asked = convert.command_from_ros(message)
                commands.append((asked.t, asked.steer, asked.accel))
            elif topic == topics.FEEDBACK.name:
                wheels.append(convert.feedback_from_ros(message))
            elif topic == topics.HEADING.name:
                headings[convert.seconds(message.header)] = message
    if len(motions) < 2:
        raise LogError(f"{path}: {NEEDED} has {len(motions)} messages", "log.no_motion")
    begin = motions[0].t
    table = np.array([(m.t, m.x, m.y, m.z, m.yaw, m.v, m.vx, m.vy, m.yaw_rate, 0.0, 0.0, 0.0) for m in motions])
    for row, motion in zip(table, motions, strict=True):
        force = forces.get(motion.t)
        row[9:11] = (force.ax, force.ay) if force is not None else np.nan
    given = {"x": table[:, 1], "y": table[:, 2], "yaw": table[:, 4], "v": table[:, 5]}
    check_motion(str(path), table[:, 0] - begin, given)
    table[:, 4] = np.unwrap(table[:, 4])
    if wheels:
        table[:, 11] = np.interp(table[:, 0], [w.t for w in wheels], [w.steer for w in wheels])
    asked_for = np.array(commands).reshape(-1, 3) - (begin, 0.0, 0.0)

    turned = sorted(headings)

    def play() -> Iterator[Arrived]:
        with _open(path) as (again, charged):
            for topic, came, message in _messages(again, charged):
                sensed: Sensed | None = None
                if topic == topics.FIX.name:
                    beside = convert.nearest(turned, convert.seconds(message.header))
                    fix = convert.fix_from_ros(message, None if beside is None else headings[beside])
                    sensed = None if isinstance(fix, convert.NoFix) else fix
                elif topic in sensors:
                    said = sensors[topic](message)
                    sensed = None if isinstance(said, convert.NotMeasured) else said
                if sensed is not None and sensed.t >= begin:
                    yield Arrived(came - fastest - begin, msgspec.structs.replace(sensed, t=sensed.t - begin))

    rows = _every_step(table - np.eye(1, 12)[0] * begin)
    looks = bool(names & {topics.POINTS.name, topics.CAMERA.name})
    return Recording(str(path), car, rows, asked_for, play()), looks


def _every_step(table: FloatArray) -> FloatArray:
    grid = np.arange(int(table[-1, 0] / STEP + 1e-6) + 1) * STEP
    columns = [grid]
    for column in table.T[1:]:
        known = np.isfinite(column)
        columns.append(np.interp(grid, table[known, 0], column[known]) if known.any() else np.zeros(len(grid)))
    return np.column_stack(columns)


@contextlib.contextmanager
def _open(path: Path) -> Iterator[tuple[Any, Account]]:
    try:
        from rosbags.typesys import get_types_from_msg

        from vehicle.wire.definitions import DEFINITIONS
    except ImportError:
        text = f"{path}: bags need the package rosbags: pip install -e '.[bags]' from the checkout"
        raise LogError(text, "log.extra_missing") from None
    store = Decoder(path, ()).store
    for name, definition in DEFINITIONS.items():
        if name not in store.types:
            store.register(get_types_from_msg(definition, name))
    try:
        folder = bag_of(path)
        account = open_account(folder)
        with open_bag(folder, store, account) as reader:
            yield reader, account
    except LogError:
        raise
    except Exception as error:  # rosbags has errors of its own for each format; all mean: not readable
        raise LogError(f"{path}: the bag cannot be read: {error or type(error).__name__}".split("\n")[0]) from None


def _messages(reader: Any, account: Account) -> Iterator[tuple[str, float, Any]]:
    """Topic, when it came [s], message; those of unknown types are left out."""
    for connection, came, raw in messages(reader, account):
        if connection.msgtype in reader.typestore.types:
            yield connection.topic, came * SECOND, reader.deserialize(raw, connection.msgtype)
