"""What goes over the wire is what ROS 2 sends: the bytes of an independent serialiser (rosbags), for every message."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import msgspec
import numpy as np
import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

pytest.importorskip("cyclonedds")

from vehicle.messages import (
    CameraBox,
    CameraFrame,
    Command,
    GnssFix,
    Imu,
    Odometry,
    SignalState,
    Surroundings,
    VehicleState,
)
from vehicle.wire import convert, topics
from vehicle.wire.definitions import DEFINITIONS
from vehicle.wire.ros2_types import Bool, Clock, String, UInt64MultiArray

NS = 12_340_000_000
STATE = VehicleState(t=12.34, x=1.5, y=-2.25, yaw=3.0, v=4.0, vx=4.0, vy=0.1, yaw_rate=0.2)
BOXES = np.array([[20.0, 3.0, 0.75, 0.5, 4.2, 1.8, 1.5, 0.0, 0.0], [8.0, -2.0, 0.9, -3.1, 0.5, 0.6, 1.8, 0.0, 0.0]])
AROUND = Surroundings(BOXES, np.array([0, 1], dtype=np.int64), ("Target", "Fußgänger"))
FRAME = CameraFrame(12.34, (CameraBox(10.0, 20.0, 110.0, 220.0, "pedestrian", 0.9),))
POINTS = np.array([[10.0, 0.5, -0.25], [12.5, -1.0, 0.125]])  # exact in float32
FIX = GnssFix(12.34, 30.0, -40.0, 0.02, 0.7, 0.005)

MESSAGES = {
    topics.CLOCK: Clock(convert.stamp(NS)),
    topics.STEP: UInt64MultiArray(data=[7, NS, 1, 2, 3]),
    topics.COMMAND: convert.command_to_ros(Command(12.34, 0.125, -1.5, 0.0, 0.2), NS),
    topics.RESET: convert.state_to_ros(STATE, NS),
    topics.OBJECTS: convert.objects_to_ros(AROUND, NS),
    topics.SIGNALS: convert.signals_to_ros((SignalState("s1", "red"), SignalState("s2", "green"))),
    topics.FEEDBACK: convert.feedback_to_ros(Odometry(12.34, 4.5, -0.25), NS),
    topics.IMU: convert.imu_to_ros(Imu(12.34, 0.5, -0.25, 0.125), NS),
    topics.FIX: convert.fix_to_ros(FIX, NS)[0],
    topics.HEADING: convert.fix_to_ros(FIX, NS)[1],
    topics.POINTS: convert.points_to_ros(POINTS, NS),
    topics.CAMERA: convert.camera_to_ros(FRAME, NS),
    topics.TF: convert.transform(STATE, NS),
    topics.OVERRIDE: Bool(True),
    topics.DESCRIPTION: String('{"length": 3.03}'),
}


@pytest.fixture(scope="module")
def store() -> Typestore:
    store = get_typestore(Stores.ROS2_HUMBLE)
    for name, text in DEFINITIONS.items():
        store.register(get_types_from_msg(text, name))
    return store


def rosbags_name(message: Any) -> str:
    package, _, _, kind = _name(message).split("::")
    return f"{package}/msg/{kind.removesuffix('_')}"


def _name(message: Any) -> str:
    return str(message.__idl_typename__)


def as_rosbags(message: Any, store: Typestore) -> Any:
    """The same message as objects of rosbags, field by field by name."""
    kind = store.types[rosbags_name(message)]
    values = {}
    for field in dataclasses.fields(kind):
        if "ClassVar" in str(field.type):  # constants of the message
            continue
        value = getattr(message, field.name)
        wanted = str(field.type)
        if dataclasses.is_dataclass(value):
            value = as_rosbags(value, store)
        elif "ndarray" in wanted:
            kinds = {"float64": np.float64, "uint64": np.uint64, "uint8": np.uint8}
            dtype = next(dtype for name, dtype in kinds.items() if name in wanted)
            value = np.frombuffer(value, dtype) if isinstance(value, bytes) else np.array(value, dtype)
        elif isinstance(value, list):
            value = [as_rosbags(item, store) for item in value]
        values[field.name] = value
    return kind(**values)


@pytest.mark.parametrize("topic", MESSAGES, ids=lambda topic: topic.name)
def test_the_bytes_are_those_of_rosbags(topic: topics.Topic, store: Typestore) -> None:
    message = MESSAGES[topic]
    expected = bytes(store.serialize_cdr(as_rosbags(message, store), rosbags_name(message)))
    assert message.serialize() == expected


@pytest.mark.parametrize("topic", MESSAGES, ids=lambda topic: topic.name)
def test_the_bytes_of_rosbags_are_read(topic: topics.Topic, store: Typestore) -> None:
    message = MESSAGES[topic]
    foreign = bytes(store.serialize_cdr(as_rosbags(message, store), rosbags_name(message)))
    assert topic.type.deserialize(foreign).serialize() == foreign


def test_every_topic_has_a_message_here() -> None:
    kinds = {topic.type for topic in (*topics.TO_CAR, *topics.FROM_CAR, *topics.HANDS, topics.STEP, topics.DONE)}
    assert {topic.type for topic in MESSAGES} == kinds


def test_names_on_dds_are_those_of_ros_2() -> None:
    assert topics.COMMAND.dds_name == "rt/vehicle/command"
    assert _name(MESSAGES[topics.COMMAND]) == "ackermann_msgs::msg::dds_::AckermannDriveStamped_"
    assert _name(MESSAGES[topics.TF]) == "tf2_msgs::msg::dds_::TFMessage_"


def test_what_comes_back_is_what_went_in() -> None:
    state = convert.state_from_ros(MESSAGES[topics.RESET])
    assert (state.t, state.x, state.y, state.yaw, state.v, state.vy, state.yaw_rate) == pytest.approx(
        (12.34, 1.5, -2.25, 3.0, 4.0, 0.1, 0.2)
    )
    known = msgspec.structs.replace(state, position_sigma=0.25)
    assert convert.state_from_ros(convert.state_to_ros(known, NS)).position_sigma == pytest.approx(0.25)
    assert state.position_sigma == 0.0
    back = convert.fix_from_ros(MESSAGES[topics.FIX], MESSAGES[topics.HEADING])
    assert (back.x, back.y, back.sigma, back.yaw) == pytest.approx((30.0, -40.0, 0.02, 0.7), abs=1e-6)
    assert convert.points_from_ros(MESSAGES[topics.POINTS]).points.tolist() == POINTS.tolist()
    assert convert.camera_from_ros(MESSAGES[topics.CAMERA]) == FRAME
    around = convert.objects_from_ros(MESSAGES[topics.OBJECTS])
    assert around.names == AROUND.names
    assert around.boxes == pytest.approx(BOXES)


def test_a_receiver_without_a_fix_gives_no_place_and_an_unstated_accuracy_is_not_perfect() -> None:
    """sensor_msgs/NavSatStatus: STATUS_NO_FIX = -1; NavSatFix: COVARIANCE_TYPE_UNKNOWN = 0, its matrix all zero."""
    sound = MESSAGES[topics.FIX]
    lost = dataclasses.replace(sound, status=dataclasses.replace(sound.status, status=-1))
    assert convert.fix_from_ros(lost) == convert.NoFix(12.34)
    unstated = dataclasses.replace(sound, position_covariance=[0.0] * 9, position_covariance_type=0)
    sigma = convert.fix_from_ros(unstated).sigma
    assert 1.0 - math.exp(-0.5 * (8.0 / sigma) ** 2) == pytest.approx(0.95, abs=1e-3)  # Rayleigh: within 8 m (GPS SPS)
    assert convert.fix_from_ros(unstated).x == pytest.approx(30.0, abs=1e-6)
