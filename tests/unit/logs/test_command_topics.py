"""A topic of commands is not what the car did, whatever its message type says of a twist or a pose."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.logs.command_topics import carries_commands
from pytest_dvp.logs.mapping_proposal import propose
from pytest_dvp.logs.stream import Stream

TWIST, POSE = "geometry_msgs/msg/TwistStamped", "geometry_msgs/msg/PoseStamped"
CONTROL = "autoware_control_msgs/msg/Control"


def stream(topic: str, kind: str, *fields: str, rate: float = 50.0) -> Stream:
    t = np.arange(0.0, 4.0, 1.0 / rate)
    return Stream(topic, kind, t, {field: np.sin(t + k) for k, field in enumerate(fields)})


@pytest.mark.parametrize(
    ("topic", "kind"),
    [
        ("/cmd_vel", TWIST), ("/goal_pose", POSE), ("/control/command/control_cmd", CONTROL), ("carControl", ""),
        ("/apollo/control", ""), ("/drive", "ackermann_msgs/msg/AckermannDriveStamped"), ("CMD_Steer", "mdf"),
    ],
)  # fmt: skip
def test_commands(topic: str, kind: str) -> None:
    assert carries_commands(topic, kind)


@pytest.mark.parametrize(
    ("topic", "kind"),
    [
        ("/odom", "nav_msgs/msg/Odometry"), ("/vehicle/status/control_mode", "autoware_vehicle_msgs/ControlModeReport"),
        ("/control/odometry", ""), ("ESP_Control", "mdf"), ("carState", ""), ("", ""), ("/target/odom", ""),
    ],
)  # fmt: skip
def test_measurements(topic: str, kind: str) -> None:
    assert not carries_commands(topic, kind)


def test_the_faster_command_is_not_the_speed_of_the_car() -> None:
    car = stream("/twist", TWIST, "twist.linear.x", "twist.linear.y", "twist.angular.z", rate=20.0)
    asked = stream("/cmd_vel", TWIST, "twist.linear.x", "twist.linear.y", "twist.angular.z", rate=100.0)
    found = {one.name: one.topic for one in propose([asked, car])[0].signals}
    assert found == {"v": "/twist", "vy": "/twist", "yaw_rate": "/twist", "speed_cmd": "/cmd_vel"}


def test_a_goal_is_not_where_the_car_is() -> None:
    goal = stream("/goal_pose", POSE, "pose.position.x", "pose.position.y", "pose.orientation.x")
    assert propose([goal])[0].signals == ()


def test_the_control_message_of_autoware_states_its_units() -> None:
    control = stream("/control/command/control_cmd", CONTROL, "lateral.steering_tire_angle", "longitudinal.velocity",
                     "longitudinal.acceleration")  # fmt: skip
    found = {one.name: (one.field, one.unit) for one in propose([control])[0].signals}
    assert found == {
        "steer_cmd": ("lateral.steering_tire_angle", "rad"), "speed_cmd": ("longitudinal.velocity", "m/s"),
        "accel_cmd": ("longitudinal.acceleration", "m/s^2"),
    }  # fmt: skip


def test_a_part_of_another_vector_is_no_position() -> None:
    """Such as the angular velocity of openpilot's livePose, or the twist of a message without a type that is known."""
    pose = stream("livePose", "", "angularVelocityDevice.x", "angularVelocityDevice.z", "linear.x", "acceleration.y")
    assert propose([pose])[1] == ()
    placed = stream("place", "", "position.x", "position.y", "pose.z")
    assert {one.name: one.field for one in propose([placed])[1]} == {
        "x": "position.x", "y": "position.y", "z": "pose.z",
    }  # fmt: skip
