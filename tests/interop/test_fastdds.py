"""Every message of the wire to a peer of another make and back: Fast DDS in C++, its types from ROS's definitions.

The peer takes each sample apart into named fields, which it prints, and sends what it puts together again.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("cyclonedds")

from rosbags.typesys import Stores, get_types_from_msg, get_typestore

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[1] / "unit" / "wire"))
from test_cdr import MESSAGES, rosbags_name
from types_xml import dds_name, types_xml

from vehicle.adapters.process import Lease
from vehicle.wire import topics
from vehicle.wire.dds import on_domain
from vehicle.wire.definitions import DEFINITIONS
from vehicle.wire.end import End
from vehicle.wire.topics import Topic

HERE = Path(__file__).parent
PATIENCE = 60.0  # s for two processes to find each other on a busy machine
FIELDS = {  # what the peer must have understood, as it prints it
    topics.COMMAND: ("steering_angle: 0.125", "acceleration: -1.5"),
    topics.FEEDBACK: ("speed: 4.5", "steering_angle: -0.25"),
    topics.IMU: ("x: 0.5", "y: -0.25", "z: 0.125"),
    topics.RESET: ("x: 1.5", "y: -2.25", "child_frame_id: base_link"),
    topics.SIGNALS: ("data: s1\tred",),
    topics.CLOCK: ("sec: 12", "nanosec: 340000000"),
}


class Back(Topic):
    """The topic that the peer answers on."""

    @property
    def dds_name(self) -> str:
        return "rtecho" + self.name


@pytest.fixture(scope="session")
def probe(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if not os.environ.get("DVP_INTEROP"):
        pytest.skip("compiles and starts a peer in C++: make interop")
    if shutil.which("g++") is None or not Path("/usr/include/fastdds").is_dir():
        pytest.skip("needs g++ and Fast DDS: apt-get install g++ libfastrtps-dev (make interop)")
    out = tmp_path_factory.mktemp("probe") / "probe"
    command = ["g++", "-std=c++17", "-O1", str(HERE / "probe.cpp"), "-lfastrtps", "-lfastcdr", "-o", str(out)]
    subprocess.run(command, check=True)
    return out


class Peer:
    """The running probe, and our end of the wire to it."""

    def __init__(self, probe: Path, folder: Path) -> None:
        store = get_typestore(Stores.ROS2_HUMBLE)
        for name, text in DEFINITIONS.items():
            store.register(get_types_from_msg(text, name))
        names = {topic: rosbags_name(message) for topic, message in MESSAGES.items()}
        (folder / "types.xml").write_text(types_xml(store, list(names.values())))
        lines = [f"{topic.name} {dds_name(name)}" for topic, name in names.items()]
        (folder / "topics.txt").write_text("\n".join(lines) + "\n")
        self.lease = Lease()
        self.said = (folder / "said.txt").open("w+")
        arguments = [str(self.lease.domain), str(folder / "types.xml"), str(folder / "topics.txt")]
        self.process = subprocess.Popen([str(probe), *arguments], stdin=subprocess.PIPE, stdout=self.said)
        out = [topic for topic in MESSAGES if topic != topics.STEP]
        back = {topic: Back(*topic) for topic in MESSAGES}
        self.back = back
        self.end = End(
            on_domain(self.lease.domain), out, [back[t] for t in out], (topics.STEP, back[topics.STEP]), self.alive
        )
        deadline = time.monotonic() + PATIENCE
        while not self.end.matched():
            self.alive()
            assert time.monotonic() < deadline, "the peer was not found"

    def alive(self) -> None:
        assert self.process.poll() is None, f"the peer ended with {self.process.returncode}"

    def told(self) -> dict[str, str]:
        """What the peer printed of the last sample of each topic."""
        self.said.seek(0)
        parts = self.said.read().split("== ")[1:]
        return {part.split("\n", 1)[0]: part.split("\n", 1)[1] for part in parts}

    def close(self) -> None:
        self.end.close()
        assert self.process.stdin is not None
        self.process.stdin.close()
        self.process.wait(10)
        self.said.close()
        self.lease.release()


@pytest.fixture(scope="session")
def answered(
    probe: Path, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[tuple[dict[Topic, Any], dict[str, str]]]:
    """What came back on each topic, and what the peer printed."""
    peer = Peer(probe, tmp_path_factory.mktemp("peer"))
    try:
        for topic, message in MESSAGES.items():
            if topic != topics.STEP:
                peer.end.send(topic, message)
        peer.end.step(7, 12_340_000_000)  # comes back with how much was sent on each topic: all of it must be here then
        assert peer.end.next_step(PATIENCE) == (7, 12_340_000_000)
        came = {topic: peer.end.take(peer.back[topic]) for topic in MESSAGES if topic != topics.STEP}
        yield came, peer.told()
    finally:
        peer.close()


@pytest.mark.parametrize("topic", [topic for topic in MESSAGES if topic != topics.STEP], ids=lambda topic: topic.name)
def test_a_message_comes_back_as_it_was_sent(topic: Topic, answered: tuple[dict[Topic, Any], dict[str, str]]) -> None:
    (back,) = answered[0][topic]
    assert back.serialize() == MESSAGES[topic].serialize()


@pytest.mark.parametrize("topic", FIELDS, ids=lambda topic: topic.name)
def test_the_peer_understood_its_fields(topic: Topic, answered: tuple[dict[Topic, Any], dict[str, str]]) -> None:
    printed = answered[1][topic.name]
    for field in FIELDS[topic]:
        assert field in printed
