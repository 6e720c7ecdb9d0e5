"""Messages of the wire as ROS 1 (Noetic) has them: their bytes, made from and read into the types of `ros2_types`.

Field by field by name; what differs: a header's `seq` is 0 (ROS 1 leaves it to the sender), and vision_msgs 0.0 numbers
classes (place in OBJECT_KINDS), has no name of an object (its place in the list here), and brings images and clouds,
which are empty. Needs the extra `ros1` (cyclonedds for the types, rosbags for the bytes).
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from vehicle.messages import OBJECT_KINDS
from vehicle.wire import ros2_types as ros
from vehicle.wire.definitions import DEFINITIONS as ROS2_DEFINITIONS
from vehicle.wire.topics import Topic

DEFINITIONS: Mapping[str, str] = {
    **{name: text for name, text in ROS2_DEFINITIONS.items() if name.startswith("ackermann_msgs/")},
    "tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms",
    "vision_msgs/msg/BoundingBox2D": "geometry_msgs/Pose2D center\nfloat64 size_x\nfloat64 size_y",
    "vision_msgs/msg/BoundingBox3D": "geometry_msgs/Pose center\ngeometry_msgs/Vector3 size",
    "vision_msgs/msg/ObjectHypothesisWithPose": "int64 id\nfloat64 score\ngeometry_msgs/PoseWithCovariance pose",
    "vision_msgs/msg/Detection2D": "Header header\nvision_msgs/ObjectHypothesisWithPose[] results\n"
    "vision_msgs/BoundingBox2D bbox\nsensor_msgs/Image source_img",
    "vision_msgs/msg/Detection2DArray": "Header header\nvision_msgs/Detection2D[] detections",
    "vision_msgs/msg/Detection3D": "Header header\nvision_msgs/ObjectHypothesisWithPose[] results\n"
    "vision_msgs/BoundingBox3D bbox\nsensor_msgs/PointCloud2 source_cloud",
    "vision_msgs/msg/Detection3DArray": "Header header\nvision_msgs/Detection3D[] detections",
}


class Kind(NamedTuple):
    """A message type of ROS 1: its name `package/Type`, the checksum of its definition, and that definition."""

    name: str
    md5: str
    text: str


def kind_of(topic: Topic) -> Kind:
    """What ROS 1 calls the type of a topic."""
    store, name = _store(), _name(topic.type)
    text, md5 = store.generate_msgdef(name, ros_version=1)
    return Kind(name.replace("/msg/", "/"), md5, text)


def to_bytes(topic: Topic, message: Any) -> bytes:
    """A message as ROS 1 sends it."""
    name = _name(topic.type)
    return bytes(_store().serialize_ros1(_out(message, name), name))


def from_bytes(topic: Topic, data: bytes) -> Any:
    """A message of `topic.type` from what ROS 1 sent. Raises ValueError if it is no such message."""
    name = _name(topic.type)
    try:
        return _in(_store().deserialize_ros1(data, name))
    except Exception as error:  # generated code reads beyond the end in many ways
        raise ValueError(f"{name}: {len(data)} bytes that are no such message ({type(error).__name__})") from error


def _out(message: Any, name: str) -> Any:
    """One of our messages as rosbags' message of ROS 1 type `name`."""
    if name in _TO_ROS1:
        message = _TO_ROS1[name](message)
    kind = _store().types[name]
    return kind(**{field: _value(getattr(message, field, None), form) for field, form in _fields(name)})


def _value(value: Any, form: Any) -> Any:
    """A value in the form that rosbags describes; None: an empty one."""
    node, detail = form
    if node == Nodetype.NAME:
        return _out(value, detail)
    if node == Nodetype.BASE:
        return value if value is not None else "" if detail[0] == "string" else 0
    (inner, what), _ = detail
    if inner == Nodetype.NAME:
        return [_out(item, what) for item in value or ()]
    dtype = np.dtype(what[0])
    return np.frombuffer(value, dtype) if isinstance(value, bytes) else np.array(value or (), dtype)


def _in(message: Any) -> Any:
    """One of our messages from one of rosbags."""
    name = message.__msgtype__
    if name in _FROM_ROS1:
        return _FROM_ROS1[name](message)
    kind = _ours()[name]
    return kind(**{field.name: _read(getattr(message, field.name)) for field in dataclasses.fields(kind)})


def _read(value: Any) -> Any:
    if hasattr(value, "__msgtype__"):
        return _in(value)
    if isinstance(value, np.ndarray):
        return value.tobytes() if value.dtype == np.uint8 else value.tolist()
    return [_read(item) for item in value] if isinstance(value, list) else value


def _class(name: str) -> int:
    """The number of a class of objects; what is not known is the last, "misc"."""
    kinds: tuple[str, ...] = OBJECT_KINDS
    return kinds.index(name) if name in kinds else len(kinds) - 1


def _hypothesis(message: Any) -> Any:
    number = int(message.id) if 0 <= message.id < len(OBJECT_KINDS) else len(OBJECT_KINDS) - 1
    return ros.ObjectHypothesisWithPose(
        ros.ObjectHypothesis(OBJECT_KINDS[number], float(message.score)), _in(message.pose)
    )


def _box(message: Any) -> Any:
    at = message.center
    return ros.BoundingBox2D(ros.Pose2D(ros.Point2D(at.x, at.y), at.theta), message.size_x, message.size_y)


def _detection(kind: Any) -> Callable[[Any], Any]:
    return lambda message: kind(_in(message.header), _read(message.results), _in(message.bbox))


def _numbered(message: Any) -> Any:
    found = _read(message.detections)
    return ros.Detection3DArray(
        _in(message.header), [dataclasses.replace(each, id=str(k)) for k, each in enumerate(found)]
    )


_TO_ROS1: Mapping[str, Callable[[Any], Any]] = {
    "vision_msgs/msg/ObjectHypothesisWithPose": lambda message: SimpleNamespace(
        id=_class(message.hypothesis.class_id), score=message.hypothesis.score, pose=message.pose
    ),
    "geometry_msgs/msg/Pose2D": lambda message: SimpleNamespace(
        x=message.position.x, y=message.position.y, theta=message.theta
    ),
}
_FROM_ROS1: Mapping[str, Callable[[Any], Any]] = {
    "vision_msgs/msg/ObjectHypothesisWithPose": _hypothesis,
    "vision_msgs/msg/BoundingBox2D": _box,
    "vision_msgs/msg/Detection2D": _detection(ros.Detection2D),
    "vision_msgs/msg/Detection3D": _detection(ros.Detection3D),
    "vision_msgs/msg/Detection3DArray": _numbered,
}


@functools.cache
def _store() -> Any:
    store = get_typestore(Stores.ROS1_NOETIC)
    for name, text in DEFINITIONS.items():
        store.register(get_types_from_msg(text, name))
    return store


@functools.cache
def _ours() -> Mapping[str, Any]:
    """Our message types by name."""
    kinds = [kind for kind in vars(ros).values() if isinstance(kind, type) and dataclasses.is_dataclass(kind)]
    return {_name(kind): kind for kind in kinds}


def _name(kind: Any) -> str:
    package, _, _, name = kind.__idl_typename__.split("::")
    return f"{package}/msg/{name.removesuffix('_')}"


@functools.cache
def _fields(name: str) -> tuple[tuple[str, Any], ...]:
    """Fields of a ROS 1 message: their names, and rosbags' descriptions of their types."""
    return tuple(_store().fielddefs[name][1])
