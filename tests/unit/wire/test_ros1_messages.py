"""What ROS 1 gets: message types by the checksums that its own generators print, and fields that come back."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

pytest.importorskip("cyclonedds")

from test_cdr import AROUND, MESSAGES  # tests/unit/wire is on the path of its tests

from vehicle.messages import CameraBox, CameraFrame
from vehicle.wire import convert, topics
from vehicle.wire.ros1 import Ros1Error, read_settings
from vehicle.wire.ros1_messages import from_bytes, kind_of, to_bytes

MD5 = {  # as gencpp, genpy and others print them for Noetic
    topics.CLOCK: ("rosgraph_msgs/Clock", "a9c97c1d230cfc112e270351a944ee47"),
    topics.STEP: ("std_msgs/UInt64MultiArray", "6088f127afb1d6c72927aa1247e945af"),
    topics.COMMAND: ("ackermann_msgs/AckermannDriveStamped", "1fd5d7f58889cefd44d29f6653240d0c"),
    topics.RESET: ("nav_msgs/Odometry", "cd5e73d190d741a2f92e81eda573aca7"),
    topics.OBJECTS: ("vision_msgs/Detection3DArray", "05c51d9aea1fb4cfdc8effb94f197b6f"),
    topics.SIGNALS: ("std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1"),
    topics.IMU: ("sensor_msgs/Imu", "6a62c6daae103f4ff57a132d6f95cec2"),
    topics.FIX: ("sensor_msgs/NavSatFix", "2d3a8cd499b9b4a0249fb98fd05cfa48"),
    topics.POINTS: ("sensor_msgs/PointCloud2", "1158d486dd51d683ce2f1be655c3c181"),
    topics.CAMERA: ("vision_msgs/Detection2DArray", "402071f61477de256df9f1aa45e6e4c8"),
    topics.TF: ("tf2_msgs/TFMessage", "94810edda583a504dfda3829e70d7eec"),
    topics.OVERRIDE: ("std_msgs/Bool", "8b94c1b53db61fb6aed406028ad6332a"),
}


@pytest.mark.parametrize("topic", MD5, ids=lambda topic: topic.name)
def test_a_type_has_the_checksum_that_ros_1_knows_it_by(topic: topics.Topic) -> None:
    kind = kind_of(topic)
    assert (kind.name, kind.md5) == MD5[topic]


def test_every_type_is_held() -> None:
    assert {topic.type for topic in MD5} == {topic.type for topic in MESSAGES}


@pytest.mark.parametrize("topic", [t for t in MESSAGES if t != topics.OBJECTS], ids=lambda topic: topic.name)
def test_what_comes_back_is_what_went_in(topic: topics.Topic) -> None:
    message = MESSAGES[topic]
    assert from_bytes(topic, to_bytes(topic, message)).serialize() == message.serialize()


def test_of_objects_only_the_names_are_lost() -> None:
    """vision_msgs of ROS 1 has no place for them; classes go by number."""
    back = convert.objects_from_ros(from_bytes(topics.OBJECTS, to_bytes(topics.OBJECTS, MESSAGES[topics.OBJECTS])))
    assert back.boxes == pytest.approx(AROUND.boxes)
    assert (back.kinds.tolist(), back.names) == (AROUND.kinds.tolist(), ("0", "1"))


def test_an_acceleration_stands_where_ros_1_puts_it() -> None:
    """seq, secs, nsecs, length and text of frame_id, then five float32: the fourth."""
    data = to_bytes(topics.COMMAND, MESSAGES[topics.COMMAND])
    assert data[:12] == (0).to_bytes(4, "little") + (12).to_bytes(4, "little") + (340_000_000).to_bytes(4, "little")
    assert data[12:25] == (9).to_bytes(4, "little") + b"base_link"
    assert data[25 + 12 : 25 + 16] == bytes.fromhex("0000c0bf")  # -1.5
    assert len(data) == 25 + 20


@pytest.mark.parametrize(("number", "kind"), [(-1, "misc"), (0, "vehicle"), (2, "bicycle"), (3, "misc"), (4, "misc")])
def test_a_class_without_a_number_of_ours_is_misc(number: int, kind: str) -> None:
    """-1 is what detectors send that do not know the class; no vehicle."""
    frame = CameraFrame(0.0, (CameraBox(10.0, 10.0, 20.0, 20.0, "vehicle", 0.9),))
    data = bytearray(to_bytes(topics.CAMERA, convert.camera_to_ros(frame, 0)))
    score = data.index(struct.pack("<d", 0.9))
    assert data[score - 8 : score] == bytes(8)  # the number of "vehicle"
    data[score - 8 : score] = struct.pack("<q", number)
    (box,) = convert.camera_from_ros(from_bytes(topics.CAMERA, bytes(data))).boxes
    assert box.kind == kind


@pytest.mark.parametrize("data", [b"", b"\x00" * 7, b"\xff" * 300])
def test_bytes_that_are_no_message_are_told(data: bytes) -> None:
    with pytest.raises(ValueError, match=r"^nav_msgs/msg/Odometry: \d+ bytes that are no such message"):
        from_bytes(topics.RESET, data)


def test_a_file_says_how_ros_1_is_reached(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", "http://robot:11311")
    file = tmp_path / "ros1.toml"
    file.write_text('python = "/usr/bin/python3"\nnamespace = "/tabby"\n[topics]\n"/vehicle/odom" = "/odom"\n')
    settings = read_settings(file)
    assert (settings.python, settings.master, settings.namespace) == (
        "/usr/bin/python3",
        "http://robot:11311",
        "/tabby",
    )
    assert settings.topics == {"/vehicle/odom": "/odom"}


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("pyton = 'p'", r"ros1\.toml: pyton is unknown; did you mean python\?"),
        ("python = 3", r"ros1\.toml: python: found 3, allowed: text in quotes$"),
        ("path = ['a', 1]", r"ros1\.toml: path: found \['a', 1\], allowed: a list of folders$"),
        ("namespace = 'tabby'", r"ros1\.toml: namespace: found 'tabby', allowed: as /tabby$"),
        ("[topics]\n'/vehicle/odo' = '/odom'", r"\[topics\]: no topic /vehicle/odo; did you mean /vehicle/odom"),
        ("[topics]\n'/vehicle/odom' = 'odom'", r"ros1\.toml: \[topics\] /vehicle/odom: found 'odom', allowed: a name"),
        ("python = ", r"ros1\.toml:1: not TOML: Invalid value"),
    ],
)  # fmt: skip
def test_a_wrong_file_is_one_line(tmp_path: Path, text: str, says: str) -> None:
    (tmp_path / "ros1.toml").write_text(text)
    with pytest.raises(Ros1Error, match=says):
        read_settings(tmp_path / "ros1.toml")


def test_a_missing_file_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(Ros1Error, match=r"no\.toml: No such file or directory$"):
        read_settings(tmp_path / "no.toml")
