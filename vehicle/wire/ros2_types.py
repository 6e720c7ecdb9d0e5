"""ROS 2 messages as DDS types, under the names that ROS 2 gives them: `pkg/msg/Type` is `pkg::msg::dds_::Type_`.

Field order and types are those of common_interfaces, ackermann_msgs 2.0, vision_msgs 4.1 (Humble and later); their CDR
bytes equal those of an independent serialiser (rosbags), which a test holds. Needs the extra `ros2` (cyclonedds).
"""

# No `from __future__ import annotations`: cyclonedds reads the annotations as objects when a class is made.
from dataclasses import dataclass, field

from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float32, float64, int8, int32, sequence, uint8, uint16, uint32, uint64


def ros(name: str) -> str:
    """DDS type name of the ROS 2 message `pkg/Type`."""
    package, kind = name.split("/")
    return f"{package}::msg::dds_::{kind}_"


def _zeros(count: int):  # type: ignore[no-untyped-def]
    return field(default_factory=lambda: [0.0] * count)


@dataclass
class Time(IdlStruct, typename=ros("builtin_interfaces/Time")):
    sec: int32 = 0
    nanosec: uint32 = 0


@dataclass
class Header(IdlStruct, typename=ros("std_msgs/Header")):
    stamp: Time = field(default_factory=Time)
    frame_id: str = ""


@dataclass
class Point(IdlStruct, typename=ros("geometry_msgs/Point")):
    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0


@dataclass
class Vector3(IdlStruct, typename=ros("geometry_msgs/Vector3")):
    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0


@dataclass
class Quaternion(IdlStruct, typename=ros("geometry_msgs/Quaternion")):
    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0
    w: float64 = 1.0


@dataclass
class Pose(IdlStruct, typename=ros("geometry_msgs/Pose")):
    position: Point = field(default_factory=Point)
    orientation: Quaternion = field(default_factory=Quaternion)


@dataclass
class PoseWithCovariance(IdlStruct, typename=ros("geometry_msgs/PoseWithCovariance")):
    pose: Pose = field(default_factory=Pose)
    covariance: array[float64, 36] = _zeros(36)


@dataclass
class Twist(IdlStruct, typename=ros("geometry_msgs/Twist")):
    linear: Vector3 = field(default_factory=Vector3)
    angular: Vector3 = field(default_factory=Vector3)


@dataclass
class TwistWithCovariance(IdlStruct, typename=ros("geometry_msgs/TwistWithCovariance")):
    twist: Twist = field(default_factory=Twist)
    covariance: array[float64, 36] = _zeros(36)


@dataclass
class Transform(IdlStruct, typename=ros("geometry_msgs/Transform")):
    translation: Vector3 = field(default_factory=Vector3)
    rotation: Quaternion = field(default_factory=Quaternion)


@dataclass
class TransformStamped(IdlStruct, typename=ros("geometry_msgs/TransformStamped")):
    header: Header = field(default_factory=Header)
    child_frame_id: str = ""
    transform: Transform = field(default_factory=Transform)


@dataclass
class TFMessage(IdlStruct, typename=ros("tf2_msgs/TFMessage")):
    transforms: sequence[TransformStamped] = field(default_factory=list)


@dataclass
class Clock(IdlStruct, typename=ros("rosgraph_msgs/Clock")):
    clock: Time = field(default_factory=Time)


@dataclass
class String(IdlStruct, typename=ros("std_msgs/String")):
    data: str = ""


@dataclass
class Bool(IdlStruct, typename=ros("std_msgs/Bool")):
    data: bool = False


@dataclass
class MultiArrayDimension(IdlStruct, typename=ros("std_msgs/MultiArrayDimension")):
    label: str = ""
    size: uint32 = 0
    stride: uint32 = 0


@dataclass
class MultiArrayLayout(IdlStruct, typename=ros("std_msgs/MultiArrayLayout")):
    dim: sequence[MultiArrayDimension] = field(default_factory=list)
    data_offset: uint32 = 0


@dataclass
class UInt64MultiArray(IdlStruct, typename=ros("std_msgs/UInt64MultiArray")):
    layout: MultiArrayLayout = field(default_factory=MultiArrayLayout)
    data: sequence[uint64] = field(default_factory=list)


@dataclass
class AckermannDrive(IdlStruct, typename=ros("ackermann_msgs/AckermannDrive")):
    steering_angle: float32 = 0.0
    steering_angle_velocity: float32 = 0.0
    speed: float32 = 0.0
    acceleration: float32 = 0.0
    jerk: float32 = 0.0


@dataclass
class AckermannDriveStamped(IdlStruct, typename=ros("ackermann_msgs/AckermannDriveStamped")):
    header: Header = field(default_factory=Header)
    drive: AckermannDrive = field(default_factory=AckermannDrive)


@dataclass
class Odometry(IdlStruct, typename=ros("nav_msgs/Odometry")):
    header: Header = field(default_factory=Header)
    child_frame_id: str = ""
    pose: PoseWithCovariance = field(default_factory=PoseWithCovariance)
    twist: TwistWithCovariance = field(default_factory=TwistWithCovariance)


@dataclass
class NavSatStatus(IdlStruct, typename=ros("sensor_msgs/NavSatStatus")):
    status: int8 = 0
    service: uint16 = 0


@dataclass
class NavSatFix(IdlStruct, typename=ros("sensor_msgs/NavSatFix")):
    header: Header = field(default_factory=Header)
    status: NavSatStatus = field(default_factory=NavSatStatus)
    latitude: float64 = 0.0
    longitude: float64 = 0.0
    altitude: float64 = 0.0
    position_covariance: array[float64, 9] = _zeros(9)
    position_covariance_type: uint8 = 0


@dataclass
class Imu(IdlStruct, typename=ros("sensor_msgs/Imu")):
    header: Header = field(default_factory=Header)
    orientation: Quaternion = field(default_factory=Quaternion)
    orientation_covariance: array[float64, 9] = _zeros(9)
    angular_velocity: Vector3 = field(default_factory=Vector3)
    angular_velocity_covariance: array[float64, 9] = _zeros(9)
    linear_acceleration: Vector3 = field(default_factory=Vector3)
    linear_acceleration_covariance: array[float64, 9] = _zeros(9)


@dataclass
class PointField(IdlStruct, typename=ros("sensor_msgs/PointField")):
    name: str = ""
    offset: uint32 = 0
    datatype: uint8 = 0
    count: uint32 = 0


@dataclass
class PointCloud2(IdlStruct, typename=ros("sensor_msgs/PointCloud2")):
    header: Header = field(default_factory=Header)
    height: uint32 = 0
    width: uint32 = 0
    fields: sequence[PointField] = field(default_factory=list)
    is_bigendian: bool = False
    point_step: uint32 = 0
    row_step: uint32 = 0
    data: sequence[uint8] = field(default_factory=list)
    is_dense: bool = False


@dataclass
class ObjectHypothesis(IdlStruct, typename=ros("vision_msgs/ObjectHypothesis")):
    class_id: str = ""
    score: float64 = 0.0


@dataclass
class ObjectHypothesisWithPose(IdlStruct, typename=ros("vision_msgs/ObjectHypothesisWithPose")):
    hypothesis: ObjectHypothesis = field(default_factory=ObjectHypothesis)
    pose: PoseWithCovariance = field(default_factory=PoseWithCovariance)


@dataclass
class BoundingBox3D(IdlStruct, typename=ros("vision_msgs/BoundingBox3D")):
    center: Pose = field(default_factory=Pose)
    size: Vector3 = field(default_factory=Vector3)


@dataclass
class Detection3D(IdlStruct, typename=ros("vision_msgs/Detection3D")):
    header: Header = field(default_factory=Header)
    results: sequence[ObjectHypothesisWithPose] = field(default_factory=list)
    bbox: BoundingBox3D = field(default_factory=BoundingBox3D)
    id: str = ""


@dataclass
class Detection3DArray(IdlStruct, typename=ros("vision_msgs/Detection3DArray")):
    header: Header = field(default_factory=Header)
    detections: sequence[Detection3D] = field(default_factory=list)


@dataclass
class Point2D(IdlStruct, typename=ros("vision_msgs/Point2D")):
    x: float64 = 0.0
    y: float64 = 0.0


@dataclass
class Pose2D(IdlStruct, typename=ros("vision_msgs/Pose2D")):
    position: Point2D = field(default_factory=Point2D)
    theta: float64 = 0.0


@dataclass
class BoundingBox2D(IdlStruct, typename=ros("vision_msgs/BoundingBox2D")):
    center: Pose2D = field(default_factory=Pose2D)
    size_x: float64 = 0.0
    size_y: float64 = 0.0


@dataclass
class Detection2D(IdlStruct, typename=ros("vision_msgs/Detection2D")):
    header: Header = field(default_factory=Header)
    results: sequence[ObjectHypothesisWithPose] = field(default_factory=list)
    bbox: BoundingBox2D = field(default_factory=BoundingBox2D)
    id: str = ""


@dataclass
class Detection2DArray(IdlStruct, typename=ros("vision_msgs/Detection2DArray")):
    header: Header = field(default_factory=Header)
    detections: sequence[Detection2D] = field(default_factory=list)
