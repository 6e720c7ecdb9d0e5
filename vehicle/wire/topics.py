"""Topics of a car on the wire, with type and direction. All are reliable, volatile, keep-all, XCDR1, as ROS 2's own
reliable profile but for the depth: in stepped time no sample may be lost. From best-effort writers it is best effort.

    harness -> car                                   car -> harness
    /clock            the time now                   /vehicle/odom       reference motion, 100 Hz, map frame
    /simulation/step  go on until then               /reference/imu      specific force with it, 100 Hz
    /vehicle/command  steer [rad], accel [m/s^2]     /vehicle/feedback   wheel speed, steering angle, 50 Hz
    /vehicle/reset    stand there                    /imu/data /gnss/fix /gnss/heading /lidar/points
    /simulation/objects, /simulation/signals         /camera/detections /camera/signals /tf
                                                     /vehicle/description (JSON), /simulation/done
    a real car besides: /vehicle/override, /vehicle/emergency_stop: its driver's hands
"""

from __future__ import annotations

from typing import Any, NamedTuple

from vehicle.wire import ros2_types as ros


class Topic(NamedTuple):
    """A ROS 2 topic: its name, on DDS under `rt/`, and its type."""

    name: str
    type: Any

    @property
    def dds_name(self) -> str:
        """The name of the topic in DDS: that of ROS 2 with `rt` before it."""
        return "rt" + self.name


CLOCK = Topic("/clock", ros.Clock)
STEP = Topic("/simulation/step", ros.UInt64MultiArray)
COMMAND = Topic("/vehicle/command", ros.AckermannDriveStamped)
RESET = Topic("/vehicle/reset", ros.Odometry)
OBJECTS = Topic("/simulation/objects", ros.Detection3DArray)
SIGNALS = Topic("/simulation/signals", ros.String)

ODOMETRY = Topic("/vehicle/odom", ros.Odometry)
REFERENCE_IMU = Topic("/reference/imu", ros.Imu)
FEEDBACK = Topic("/vehicle/feedback", ros.AckermannDriveStamped)
IMU = Topic("/imu/data", ros.Imu)
FIX = Topic("/gnss/fix", ros.NavSatFix)
HEADING = Topic("/gnss/heading", ros.Imu)
POINTS = Topic("/lidar/points", ros.PointCloud2)
CAMERA = Topic("/camera/detections", ros.Detection2DArray)
SEEN_SIGNALS = Topic("/camera/signals", ros.String)
TF = Topic("/tf", ros.TFMessage)
DESCRIPTION = Topic("/vehicle/description", ros.String)
DONE = Topic("/simulation/done", ros.UInt64MultiArray)
OVERRIDE = Topic("/vehicle/override", ros.Bool)
EMERGENCY_STOP = Topic("/vehicle/emergency_stop", ros.Bool)

TO_CAR: tuple[Topic, ...] = (CLOCK, COMMAND, RESET, OBJECTS, SIGNALS)
FROM_CAR: tuple[Topic, ...] = (
    ODOMETRY, REFERENCE_IMU, FEEDBACK, IMU, FIX, HEADING, POINTS, CAMERA, SEEN_SIGNALS, TF, DESCRIPTION,
)  # fmt: skip
SENSED: tuple[Topic, ...] = tuple(topic for topic in FROM_CAR if topic not in (SEEN_SIGNALS, TF, DESCRIPTION))
HANDS: tuple[Topic, ...] = (OVERRIDE, EMERGENCY_STOP)
