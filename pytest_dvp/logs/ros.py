"""ROS 1 and ROS 2 bags, and CDR messages in MCAP -> streams. Needs the extra `bags` (rosbags), nothing of ROS."""

from __future__ import annotations

import dataclasses
import importlib
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from openscenario.findings import Findings
from pytest_dvp.log import LogError
from pytest_dvp.logs.mcap_scan import Channel, Message
from pytest_dvp.logs.stream import Stream, columns_of, flatten

_LARGE = re.compile(r"/(Compressed)?(Image|PointCloud2?|LaserScan|OccupancyGrid|CameraInfo|MarkerArray|Log)$")


def _rosbags(path: Path, part: str) -> Any:
    try:
        return importlib.import_module(part)
    except ImportError:
        raise LogError(
            f"{path}: ROS messages need the package rosbags: pip install -e '.[bags]' from the checkout",
            "log.extra_missing",
        ) from None


class Decoder:
    """Deserialises ROS messages with the definitions of the file, those of `msg_dirs`, and the standard ones."""

    def __init__(self, path: Path, msg_dirs: Sequence[Path]) -> None:
        self._path = path
        self._types = _rosbags(path, "rosbags.typesys")
        self.store = self._types.get_typestore(self._types.Stores.ROS2_HUMBLE)
        for folder in msg_dirs:
            self._add_folder(folder)

    def _add_folder(self, folder: Path) -> None:
        files = sorted(folder.rglob("*.msg"))
        if not files:
            raise LogError(f"{folder}: no .msg file in it", "log.no_messages")
        for file in files:
            package = file.parent.parent.name if file.parent.name == "msg" else file.parent.name
            self._register(file.read_text(encoding="utf-8", errors="replace"), f"{package}/msg/{file.stem}")

    def _register(self, definition: str, name: str) -> None:
        try:
            found = self._types.get_types_from_msg(definition, name)
            self.store.register({kind: body for kind, body in found.items() if kind not in self.store.types})
        except Exception as error:  # rosbags raises errors of its own parser
            text = f"{self._path}: the definition of {name} cannot be read: {error}".split("\n")[0]
            raise LogError(text, "log.bad_definition") from None

    def stream(self, channel: Channel, messages: list[Message], first: int, findings: Findings) -> Stream | None:
        """The stream of an MCAP channel, None if its messages cannot be decoded (told)."""
        kind = _full(channel.schema.name)
        if _LARGE.search(kind):
            return None
        if kind not in self.store.types and channel.schema.encoding in ("ros2msg", "ros1msg"):
            self._register(channel.schema.data.decode(errors="replace"), kind)
        if kind not in self.store.types:
            _unknown(findings, self._path, channel.topic, kind)
            return None
        read = self.store.deserialize_ros1 if channel.encoding == "ros1" else self.store.deserialize_cdr
        stamped = [(message.log_time - first, bytes(message.data)) for message in messages]
        return _stream(channel.topic, kind, stamped, read, self._path)


def decoder_of(path: Path, msg_dirs: Sequence[Path]) -> Decoder:
    """Raises LogError if rosbags is not installed or a definition cannot be read."""
    return Decoder(path, msg_dirs)


def read_bag(path: Path, findings: Findings, msg_dirs: Sequence[Path] = ()) -> list[Stream]:
    """Streams of a ROS 1 bag, or of a ROS 2 bag given by its folder or its .db3 file. Raises LogError."""
    reader_of = _rosbags(path, "rosbags.highlevel").AnyReader
    decoder = Decoder(path, msg_dirs)
    folder = path.parent if path.suffix.lower() == ".db3" else path
    if folder != path and not (folder / "metadata.yaml").is_file():
        text = f"{path}: no metadata.yaml beside it, and without it no bag: `ros2 bag reindex {folder}` writes it"
        raise LogError(text, "log.corrupt")
    try:
        with reader_of([folder], default_typestore=decoder.store) as reader:
            rows: dict[tuple[str, str], list[tuple[int, bytes]]] = {}
            for connection, stamp, raw in reader.messages():
                if not _LARGE.search(connection.msgtype):
                    rows.setdefault((connection.topic, connection.msgtype), []).append((stamp, bytes(raw)))
            first = reader.start_time
            streams: list[Stream] = []
            for (topic, kind), messages in rows.items():
                if kind not in reader.typestore.types:
                    _unknown(findings, path, topic, kind)
                    continue
                stamped = [(stamp - first, raw) for stamp, raw in messages]
                streams.append(_stream(topic, kind, stamped, lambda raw, name: reader.deserialize(raw, name), path))
    except LogError:
        raise
    except Exception as error:  # rosbags has errors of its own for each format; all mean: not readable
        text = f"{path}: the bag cannot be read: {error or type(error).__name__}".split("\n")[0]
        raise LogError(text, "log.corrupt") from None
    if not streams:
        raise LogError(f"{path}: no topic with messages that can be read", "log.foreign")
    return streams


def _full(kind: str) -> str:
    package, _, rest = kind.partition("/")
    return kind if rest.startswith("msg/") or not rest else f"{package}/msg/{rest}"


def _unknown(findings: Findings, path: Path, topic: str, kind: str) -> None:
    findings.add(
        "log.type_unknown", str(path), None, topic, "messages of an unknown type are left out", found=kind,
        hint="give the folder of its .msg files: --msg DIR", severity="warning",
    )  # fmt: skip


def _stream(
    topic: str, kind: str, stamped: list[tuple[int, bytes]], read: Callable[[bytes, str], Any], path: Path
) -> Stream:
    try:
        fields = columns_of(flatten(_plain(read(raw, kind))) for _, raw in stamped)
    except Exception as error:  # a message that does not fit its definition fails anywhere in the decoder
        text = f"{path}: {topic}: a message does not fit its definition {kind}: {error}".split("\n")[0]
        raise LogError(text, "log.corrupt") from None
    receive = np.array([stamp for stamp, _ in stamped], dtype=np.float64) * 1e-9
    return Stream(topic, kind, receive, fields)


def _plain(message: Any) -> Any:
    if dataclasses.is_dataclass(message) and not isinstance(message, type):
        return {
            field.name: _plain(getattr(message, field.name))
            for field in dataclasses.fields(message)
            if not field.name.startswith("__")
        }
    return message
