"""ROS 1's wire: a node of rospy behind a bridge, as rospy needs an interpreter that has it.

A file may say how it is reached; every line has a default:

    python = "/usr/bin/python3"                       # the interpreter with rospy; default: this one
    path = ["/opt/ros/noetic/lib/python3/dist-packages"]      # where it looks for modules besides
    master = "http://localhost:11311"                 # default: ROS_MASTER_URI
    namespace = "/tabby"                              # before all topics; default: ""
    [topics]                                          # names of a car of your own
    "/vehicle/odom" = "/odom"
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from vehicle.interpreter_bridge import Bridge
from vehicle.toml_file import TomlError, read_toml
from vehicle.wire import topics
from vehicle.wire.can_map import near
from vehicle.wire.end import Opener
from vehicle.wire.ros1_messages import from_bytes, kind_of, to_bytes
from vehicle.wire.topics import Topic

MASTER = "http://localhost:11311"
LOCAL = ("localhost", "127.0.0.1", "[::1]")
NAMES = tuple(t.name for t in (*topics.TO_CAR, *topics.FROM_CAR, *topics.HANDS, topics.STEP, topics.DONE))
NAMESPACE = re.compile(r"(/[A-Za-z]\w*)+")


class Ros1Error(ValueError):
    """No such settings, no interpreter with rospy, no roscore, or a bridge that died; one line."""


@dataclass(frozen=True)
class Ros1Settings:
    """How ROS 1 is reached; see the top of this file. `others` is what a file says besides."""

    python: str = sys.executable
    path: tuple[str, ...] = ()
    master: str = field(default_factory=lambda: os.environ.get("ROS_MASTER_URI", MASTER))
    namespace: str = ""
    topics: Mapping[str, str] = field(default_factory=dict)
    file: Path | None = None
    others: Mapping[str, Any] = field(default_factory=dict)


def read_settings(file: Path | None, others: Mapping[str, type] | None = None) -> Ros1Settings:
    """The settings in a file, or the defaults; `others` are further keys that it may have. Raises Ros1Error."""
    if file is None:
        return Ros1Settings()
    allowed: dict[str, type] = {
        "python": str,
        "path": list,
        "master": str,
        "namespace": str,
        "topics": dict,
        **(others or {}),
    }
    try:
        given, _ = read_toml(file)
    except TomlError as error:
        raise Ros1Error(f"{error.at(file)}: {error}") from None
    for key, value in given.items():
        if key not in allowed:
            raise Ros1Error(f"{file}: {key} is unknown{near(key, allowed)}")
        if not isinstance(value, allowed[key]):
            raise Ros1Error(f"{file}: {key}: found {value!r}, allowed: {_WORDS[allowed[key]]}")
    path, names = given.get("path", []), given.get("topics", {})
    if not all(isinstance(folder, str) for folder in path):
        raise Ros1Error(f"{file}: path: found {path!r}, allowed: {_WORDS[list]}")
    for name, to in names.items():
        if name not in NAMES:
            raise Ros1Error(f"{file}: [topics]: no topic {name}{near(name, NAMES)}")
        if not isinstance(to, str) or not to.startswith("/"):
            raise Ros1Error(f"{file}: [topics] {name}: found {to!r}, allowed: a name that begins with /")
    space = given.get("namespace", "")
    if space and not NAMESPACE.fullmatch(space):
        raise Ros1Error(f"{file}: namespace: found {space!r}, allowed: as /tabby")
    known = {key: given[key] for key in ("python", "master", "namespace") if key in given}
    rest = {key: value for key, value in given.items() if key in (others or {})}
    return Ros1Settings(path=tuple(path), topics=names, file=file, others=rest, **known)


_WORDS = {str: "text in quotes", list: "a list of folders", dict: "a table", bool: "true or false"}


def on_ros1(
    settings: Ros1Settings, role: str, *, within: str = "", error: Callable[[str], Exception] = Ros1Error
) -> Opener:
    """Opens ROS 1, with all topics under the namespace of the settings, and in that under `within` ("" or "/name").

    `role` ("harness", "car") makes the name of its node. `error` is what it raises if that cannot be, then and later.
    """
    space = settings.namespace + within
    node = "_".join([*space.split("/"), role]).strip("_")
    return partial(Ros1Transport, settings, node, space, error)


class Ros1Transport:
    """A node of rospy."""

    def __init__(
        self,
        settings: Ros1Settings,
        node: str,
        namespace: str,
        error: Callable[[str], Exception],
        writes: Sequence[Topic],
        reads: Sequence[Topic],
    ) -> None:
        environment = {"ROS_MASTER_URI": settings.master}
        if settings.master.split("://")[-1].rsplit(":", 1)[0] in LOCAL:
            environment["ROS_IP"] = "127.0.0.1"  # neither names of the network nor its interfaces matter
        self._numbers = {topic: number for number, topic in enumerate(writes)}
        self._reads = tuple(reads)
        self._bridge = Bridge(
            settings.python, settings.path, who="the bridge to ROS 1", error=error, environment=environment
        )
        self._error = error
        try:
            self._bridge.module("rospy")
            out, into = ([_about(topic, settings, namespace) for topic in some] for some in (writes, reads))
            self._bridge.ask("open", name=node, writes=out, reads=into)
        except BaseException:
            self._bridge.close()
            raise

    @property
    def pid(self) -> int:
        """Of the bridge."""
        return self._bridge.pid

    def matched(self, needed: Collection[Topic] | None) -> bool:
        """Whether each topic, or each of the `needed` ones, has found its other end."""
        every = (*self._numbers, *self._reads)
        wanted = [k for k, topic in enumerate(every) if needed is None or topic in needed]
        return bool(self._bridge.ask("matched", of=wanted))

    def unmatched(self) -> Mapping[Topic, str]:
        """None: rospy refuses other types by itself, and has no QoS."""
        return {}

    def write(self, topic: Topic, message: Any) -> None:
        """Put a message on a topic."""
        self._bridge.send({"topic": self._numbers[topic]}, to_bytes(topic, message))

    def read(self, wait: float) -> list[tuple[Topic, Any]]:
        """What has come since the last call; if that is nothing, what comes within `wait` [s]."""
        came = []
        for head, body in self._bridge.receive(wait):
            topic = self._reads[head["topic"]]
            try:
                came.append((topic, from_bytes(topic, body)))
            except ValueError as error:
                raise self._error(f"{topic.name}: {error}") from error
        return came

    def close(self) -> None:
        """Leave the graph."""
        self._bridge.close()


def _about(topic: Topic, settings: Ros1Settings, namespace: str) -> dict[str, str]:
    kind = kind_of(topic)
    name = namespace + settings.topics.get(topic.name, topic.name)
    return {"name": name, "type": kind.name, "md5": kind.md5, "text": kind.text}
