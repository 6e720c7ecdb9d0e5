"""Between `vehicle.messages` and the ROS 2 messages of the wire. Angles go as quaternions about z; time as stamps [ns].

GNSS goes as latitude and longitude of `Origin`; its heading as a sensor_msgs/Imu of which only the orientation counts.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from math import atan2, cos, inf, isnan, pi, sin, sqrt
from typing import Any, NamedTuple

import numpy as np

from vehicle.messages import (
    OBJECT_KINDS,
    SEEING,
    CameraBox,
    CameraFrame,
    Command,
    FloatArray,
    GnssFix,
    Imu,
    LidarScan,
    ObjectKind,
    Odometry,
    SignalState,
    Surroundings,
    VehicleState,
)
from vehicle.wire import ros2_types as ros
from vehicle.wire.geodetic import DEFAULT_ORIGIN, Origin, to_geodetic, to_map

SECOND = 1_000_000_000  # ns
FLOAT32 = 7  # PointField.FLOAT32
_HIDDEN = "hidden:"  # class of an object, with the sensor from which the scenario hides it
KNOWN = 2  # NavSatFix.COVARIANCE_TYPE_DIAGONAL_KNOWN
UNKNOWN = 0  # NavSatFix.COVARIANCE_TYPE_UNKNOWN
# Of two equal Gaussian axes 95 % lie within sqrt(-2 ln 0.05) = 2.45 standard deviations of one of them.
UNSTATED_SIGMA = 8.0 / 2.45  # m, per axis, without corrections (GPS SPS Performance Standard 2020: 95 % within 8 m)
# Heading without a stated accuracy: five times the 0.4 deg that u-blox states for two antennas 1 m apart (ZED-F9P data
# sheet, moving base); the factor is chosen, for shorter baselines and worse reception.
UNSTATED_YAW_SIGMA = 0.035  # rad, 2 deg
LEAST_SIGMA = 1e-6  # m, rad; a sensor without an error says so by this, as a variance of 0 says that it is not known
PAIRED = 0.05  # s between a fix and its heading; chosen: half of 10 Hz, in which a car at 0.5 rad/s turns 1.4 degrees
_XX, _YY = 0, 7  # of the 6 x 6 covariance of a pose, row by row


class Heading(NamedTuple):
    """Heading [rad] with its standard deviation, at `t` [s]; None: its source has no estimate then.

    `stated` is False where the standard deviation is assumed.
    """

    t: float
    yaw: float | None
    sigma: float
    stated: bool = True


class NoFix(NamedTuple):
    """A receiver says that it has no fix at `t` [s]: no place, and no fault."""

    t: float


class NotMeasured(NamedTuple):
    """An IMU says that it does not measure at `t` [s] what is asked of it; no fault."""

    t: float


def stamp(ns: int) -> Any:
    """builtin_interfaces/Time of `ns` [ns]."""
    return ros.Time(ns // SECOND, ns % SECOND)


def nanoseconds(header: Any) -> int:
    """Stamp of a header [ns]."""
    return int(header.stamp.sec) * SECOND + int(header.stamp.nanosec)


def seconds(header: Any) -> float:
    """Stamp of a header [s]."""
    return nanoseconds(header) / SECOND


def header(ns: int, frame: str) -> Any:
    """std_msgs/Header."""
    return ros.Header(stamp(ns), frame)


def quaternion(yaw: float) -> Any:
    """A turn about z by `yaw` [rad]."""
    return ros.Quaternion(0.0, 0.0, sin(0.5 * yaw), cos(0.5 * yaw))


def yaw_of(q: Any) -> float:
    """Yaw [rad, -pi to pi] of a quaternion of any attitude."""
    return atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))


def unwrapped(yaw: float, near: float) -> float:
    """`yaw` [rad] plus the whole turns that bring it next to `near`."""
    return yaw + 2.0 * pi * round((near - yaw) / (2.0 * pi))


def command_to_ros(command: Command, ns: int) -> Any:
    """AckermannDriveStamped: steering angle and wanted acceleration; it has no pedals, so ask with `brake_first`."""
    drive = ros.AckermannDrive(steering_angle=command.steer, acceleration=command.accel)
    return ros.AckermannDriveStamped(header(ns, "base_link"), drive)


def command_from_ros(message: Any) -> Command:
    """The command; pedals 0, as the message has none."""
    drive = message.drive
    return Command(seconds(message.header), drive.steering_angle, drive.acceleration, 0.0, 0.0)


def state_to_ros(state: VehicleState, ns: int) -> Any:
    """nav_msgs/Odometry of base_link, the rear axle's ground point, in the map; a variance of 0 is one not stated."""
    pose = ros.Pose(ros.Point(state.x, state.y, state.z), quaternion(state.yaw))
    twist = ros.Twist(ros.Vector3(state.v, state.vy, 0.0), ros.Vector3(0.0, 0.0, state.yaw_rate))
    spread = [0.0] * 36
    spread[_XX] = spread[_YY] = state.position_sigma**2
    there = ros.PoseWithCovariance(pose, spread)
    return ros.Odometry(header(ns, "map"), "base_link", there, ros.TwistWithCovariance(twist))


def state_from_ros(message: Any) -> VehicleState:
    """Pose and velocity; ax, ay and steer, which the message lacks, are 0.

    Of the covariance the greater one of x and y counts; -1, NaN or infinity, by which drivers say that they do not
    know, is 0.
    """
    place, twist = message.pose.pose, message.twist.twist
    spread = [message.pose.covariance[at] for at in (_XX, _YY)]
    variance = max(spread) if all(0.0 <= each < inf for each in spread) else 0.0
    return VehicleState(
        t=seconds(message.header), x=place.position.x, y=place.position.y, z=place.position.z,
        yaw=yaw_of(place.orientation), v=twist.linear.x, vx=twist.linear.x, vy=twist.linear.y,
        yaw_rate=twist.angular.z, position_sigma=sqrt(variance),
    )  # fmt: skip


def transform(state: VehicleState, ns: int) -> Any:
    """tf2_msgs/TFMessage map -> base_link."""
    where = ros.Transform(ros.Vector3(state.x, state.y, state.z), quaternion(state.yaw))
    return ros.TFMessage([ros.TransformStamped(header(ns, "map"), "base_link", where)])


def feedback_to_ros(odometry: Odometry, ns: int, echo: float = 0.0) -> Any:
    """Wheel speed and steering angle as the car reports them; `echo` is the acceleration that it is acting on."""
    drive = ros.AckermannDrive(steering_angle=odometry.steer, speed=odometry.v, acceleration=echo)
    return ros.AckermannDriveStamped(header(ns, "base_link"), drive)


def feedback_from_ros(message: Any) -> Odometry:
    """Wheel odometry."""
    return Odometry(seconds(message.header), message.drive.speed, message.drive.steering_angle)


def imu_to_ros(imu: Imu, ns: int) -> Any:
    """Specific force and yaw rate; the orientation is not measured (covariance -1, as sensor_msgs says)."""
    return ros.Imu(
        header(ns, "imu"),
        orientation_covariance=[-1.0] + [0.0] * 8,
        angular_velocity=ros.Vector3(0.0, 0.0, imu.yaw_rate),
        linear_acceleration=ros.Vector3(imu.ax, imu.ay, 9.80665),
    )


def imu_from_ros(message: Any, *, turns: bool = True) -> Imu | NotMeasured:
    """Specific force along x and y, yaw rate.

    NotMeasured where the message says that it has no such estimate (covariance -1, as sensor_msgs says) of the force,
    or, if it is asked for (`turns`), of the yaw rate. No accuracy is taken from it: who uses an Imu brings his own.
    """
    force = message.linear_acceleration
    covariances = [message.linear_acceleration_covariance, *([message.angular_velocity_covariance] if turns else [])]
    if any(covariance[0] == -1.0 for covariance in covariances):
        return NotMeasured(seconds(message.header))
    return Imu(seconds(message.header), force.x, force.y, message.angular_velocity.z)


def fix_to_ros(fix: GnssFix, ns: int, origin: Origin = DEFAULT_ORIGIN) -> tuple[Any, Any | None]:
    """NavSatFix, and the heading of two antennas as an Imu message if there is one."""
    latitude, longitude, height = to_geodetic(fix.x, fix.y, 0.0, origin)
    variance = max(fix.sigma, LEAST_SIGMA) ** 2
    place = ros.NavSatFix(
        header(ns, "gnss"), ros.NavSatStatus(2, 1), latitude, longitude, height,
        [variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, 4.0 * variance], KNOWN,
    )  # fmt: skip
    if fix.yaw is None:
        return place, None
    spread = [0.0] * 8 + [max(fix.yaw_sigma, LEAST_SIGMA) ** 2]
    return place, ros.Imu(header(ns, "gnss"), quaternion(fix.yaw), spread)


def fix_from_ros(place: Any, heading: Any | None = None, origin: Origin = DEFAULT_ORIGIN) -> GnssFix | NoFix:
    """The fix in the map frame; `heading` is the one that belongs to it (`nearest`).

    NoFix if the receiver has none (status below 0); where the accuracy is not stated (`states_accuracy`), sigma is
    UNSTATED_SIGMA. Without an altitude the antenna is taken to be as high as the origin: 100 m of it are 16 mm in x and
    y a kilometre away.
    """
    if place.status.status < 0:  # sensor_msgs/NavSatStatus: STATUS_NO_FIX = -1, "unable to fix position"
        return NoFix(seconds(place.header))
    # sensor_msgs/NavSatFix: altitude is a "quiet NaN if no altitude is available"
    height = (origin.height or 0.0) if isnan(place.altitude) else place.altitude
    x, y, _ = to_map(place.latitude, place.longitude, height, origin)
    variance = 0.5 * (place.position_covariance[0] + place.position_covariance[4])
    sigma = sqrt(variance) if states_accuracy(place) else UNSTATED_SIGMA
    if heading is None:
        return GnssFix(seconds(place.header), x, y, sigma)
    turned = heading_from_ros(heading)
    return GnssFix(seconds(place.header), x, y, sigma, turned.yaw, turned.sigma)


def states_accuracy(place: Any) -> bool:
    """Whether a NavSatFix states how accurate it is: its type says so, and both horizontal variances are above 0."""
    spread = [place.position_covariance[at] for at in (0, 4)]
    return place.position_covariance_type != UNKNOWN and all(0.0 < variance < inf for variance in spread)


def heading_from_ros(message: Any) -> Heading:
    """The heading of two antennas; None if the message says that it is not known (covariance -1, as sensor_msgs says),
    or where its quaternion is no turn, all 0. A variance that is not above 0 is one not known ("a covariance matrix of
    all zeros will be interpreted as covariance unknown", sensor_msgs/Imu): sigma is then UNSTATED_YAW_SIGMA."""
    q = message.orientation
    if message.orientation_covariance[0] == -1.0 or not any((q.x, q.y, q.z, q.w)):
        return Heading(seconds(message.header), None, 0.0)
    variance = message.orientation_covariance[8]
    stated = 0.0 < variance < inf
    sigma = sqrt(variance) if stated else UNSTATED_YAW_SIGMA
    return Heading(seconds(message.header), yaw_of(message.orientation), sigma, stated)


def nearest(times: Sequence[float], t: float) -> float | None:
    """That of the `times` [s], in their order, which is nearest to `t`, if it is within PAIRED."""
    at = bisect_left(times, t)
    best = min(times[max(0, at - 1) : at + 1], key=lambda each: abs(each - t), default=None)
    return best if best is not None and abs(best - t) <= PAIRED + 1e-9 else None


def points_to_ros(points: FloatArray, ns: int) -> Any:
    """PointCloud2 of x, y, z in float32, which is what drivers of scanners send (0.01 mm at 100 m).

    Points (n, 3) in [m]; `ns` is the stamp [ns].
    """
    fields = [ros.PointField(name, 4 * k, FLOAT32, 1) for k, name in enumerate("xyz")]
    data = np.ascontiguousarray(points, dtype="<f4").tobytes()
    return ros.PointCloud2(header(ns, "lidar"), 1, len(points), fields, False, 12, 12 * len(points), data, True)


def points_from_ros(message: Any) -> LidarScan:
    """The scan, without the invalid points (NaN) of a cloud that says that it has some (`is_dense` false).

    Raises ValueError on a cloud whose x, y, z are not float32 of the machine's usual byte order.
    """
    at = {field.name: field.offset for field in message.fields if field.datatype == FLOAT32}
    if message.is_bigendian or not {"x", "y", "z"} <= set(at):
        found = ", ".join(f"{field.name} (datatype {field.datatype})" for field in message.fields)
        raise ValueError(f"point cloud with {found}: expected little-endian float32 x, y, z")
    count = message.width * message.height
    raw, line = np.frombuffer(bytes(message.data), dtype=np.uint8), message.width * message.point_step
    if message.row_step > line and message.height > 1:  # rows that are filled up, as those of an image
        raw = raw.reshape(message.height, message.row_step)[:, :line]
    raw = raw.reshape(count, message.point_step)
    columns = [raw[:, at[name] : at[name] + 4].copy().view("<f4")[:, 0] for name in "xyz"]
    points = np.column_stack(columns).astype(np.float64).reshape(-1, 3)
    if not message.is_dense:  # sensor_msgs/PointCloud2: "True if there are no invalid points"
        points = points[np.isfinite(points).all(axis=1)]
    return LidarScan(seconds(message.header), points)


def camera_to_ros(frame: CameraFrame, ns: int) -> Any:
    """Detection2DArray; boxes by centre and size [px]."""
    found = []
    for box in frame.boxes:
        result = ros.ObjectHypothesisWithPose(ros.ObjectHypothesis(box.kind, box.score))
        centre = ros.Pose2D(ros.Point2D(0.5 * (box.u_min + box.u_max), 0.5 * (box.v_min + box.v_max)))
        outline = ros.BoundingBox2D(centre, box.u_max - box.u_min, box.v_max - box.v_min)
        found.append(ros.Detection2D(header(ns, "camera"), [result], outline))
    return ros.Detection2DArray(header(ns, "camera"), found)


def camera_from_ros(message: Any) -> CameraFrame:
    """Boxes of the classes that are known; others count as "misc"."""
    boxes = []
    for found in message.detections:
        best = max((r.hypothesis for r in found.results), key=lambda h: h.score, default=None)
        if best is None:
            continue
        u, v = found.bbox.center.position.x, found.bbox.center.position.y
        du, dv = 0.5 * found.bbox.size_x, 0.5 * found.bbox.size_y
        kind = _kind(best.class_id)
        boxes.append(CameraBox(u - du, v - dv, u + du, v + dv, kind, best.score))
    return CameraFrame(seconds(message.header), tuple(boxes))


def objects_to_ros(around: Surroundings, ns: int) -> Any:
    """Detection3DArray of everything around, in the map; velocities have no place in it.

    A further hypothesis `hidden:SENSOR` of an object says that the scenario hides it from that sensor.
    """
    found = []
    for row, kind, name in zip(around.boxes.tolist(), around.kinds.tolist(), around.names, strict=True):
        x, y, z, yaw, length, width, height, _, _ = row
        classes = [OBJECT_KINDS[kind], *(_HIDDEN + each for each in SEEING if name in around.hidden.get(each, ()))]
        results = [ros.ObjectHypothesisWithPose(ros.ObjectHypothesis(each, 1.0)) for each in classes]
        box = ros.BoundingBox3D(ros.Pose(ros.Point(x, y, z), quaternion(yaw)), ros.Vector3(length, width, height))
        found.append(ros.Detection3D(header(ns, "map"), results, box, name))
    return ros.Detection3DArray(header(ns, "map"), found)


def objects_from_ros(message: Any) -> Surroundings:
    """Boxes with velocity 0."""
    rows, kinds, names = [], [], []
    hidden: dict[str, set[str]] = {}
    for found in message.detections:
        centre, size = found.bbox.center, found.bbox.size
        place = centre.position
        rows.append((place.x, place.y, place.z, yaw_of(centre.orientation), size.x, size.y, size.z, 0.0, 0.0))
        kinds.append(OBJECT_KINDS.index(_kind(found.results[0].hypothesis.class_id)))
        names.append(found.id)
        for result in found.results[1:]:
            kind, _, sensor = result.hypothesis.class_id.partition(":")
            if kind + ":" == _HIDDEN:
                hidden.setdefault(sensor, set()).add(found.id)
    boxes = np.array(rows, dtype=np.float64).reshape(-1, 9)
    unseen = {sensor: frozenset(each) for sensor, each in hidden.items()}
    return Surroundings(boxes, np.array(kinds, dtype=np.int64), tuple(names), hidden=unseen)


def signals_to_ros(signals: tuple[SignalState, ...]) -> Any:
    """std_msgs/String, a line `id<TAB>state` a signal."""
    return ros.String("\n".join(f"{signal.id}\t{signal.state}" for signal in signals))


def signals_from_ros(message: Any) -> tuple[SignalState, ...]:
    """States of signals."""
    pairs = (line.split("\t", 1) for line in message.data.splitlines() if "\t" in line)
    return tuple(SignalState(name, state) for name, state in pairs)


def _kind(name: str) -> ObjectKind:
    return next((known for known in OBJECT_KINDS if known == name), "misc")
