"""ROS 1 and ROS 2 bags, and CDR messages in MCAP -> streams. Needs the extra `bags` (rosbags), nothing of ROS."""

from __future__ import annotations

import dataclasses
import importlib
import re
from array import array
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from openscenario.findings import Findings
from pytest_dvp.logs.account import open_account
from pytest_dvp.logs.bag import messages, open_bag
from pytest_dvp.logs.budget import Budget
from pytest_dvp.logs.formats.log_format import LogFormat
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.mcap_scan import Channel
from pytest_dvp.logs.stream import Columns, Stream, flatten

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
    """Deserialises ROS messages with the definitions of the file, those of `msg_dirs`, and the standard ones.

    Raises LogError if rosbags is not installed or a definition cannot be read.
    """

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
        found = self._parsed(definition, name)
        self.store.register({kind: body for kind, body in found.items() if kind not in self.store.types})

    def _parsed(self, definition: str, name: str) -> dict[str, Any]:
        """The types of a definition by name. Raises LogError."""
        try:
            found: dict[str, Any] = self._types.get_types_from_msg(definition, name)
            self._types.get_typestore(self._types.Stores.EMPTY).register(found)
        except Exception as error:  # rosbags raises errors of its own parser
            text = f"{self._path}: the definition of {name} cannot be read: {error}".split("\n")[0]
            raise LogError(text, "log.bad_definition") from None
        return found

    def of_channel(self, channel: Channel, findings: Findings) -> Callable[[bytes | memoryview], Any] | None:
        """What decodes the messages of an MCAP channel, None if they are large or of an unknown type (told)."""
        kind = full_name(channel.schema.name)
        if _LARGE.search(kind):
            return None
        store = self._as_defined(channel, kind)
        if kind not in store.types:
            _unknown(findings, self._path, channel.topic, kind)
            return None
        read = store.deserialize_ros1 if channel.encoding == "ros1" else store.deserialize_cdr
        return lambda content: _decoded(bytes(content), channel.topic, kind, read, self._path)

    def _as_defined(self, channel: Channel, kind: str) -> Any:
        """The types of a channel: those of its definition, and the standard ones of its ROS for what that leaves out.
        The same name is not the same message in both: a header of ROS 1 has a `seq` more."""
        text = channel.schema.data.decode(errors="replace")
        defined = channel.schema.encoding in ("ros2msg", "ros1msg") and text.strip()
        found = self._parsed(text, kind) if defined else {}
        if not found and channel.encoding != "ros1":
            return self.store
        if channel.encoding == "ros1":
            found = self._types.get_typestore(self._types.Stores.ROS1_NOETIC).fielddefs | found
        store = self._types.get_typestore(self._types.Stores.EMPTY)
        store.register(self.store.fielddefs | found)
        return store


def read_bag(
    path: Path, findings: Findings, msg_dirs: Sequence[Path] = (), budget: Budget | None = None
) -> list[Stream]:
    """Streams of a ROS 1 bag, or of a ROS 2 bag given by its folder or its .db3 file. Raises LogError."""
    _rosbags(path, "rosbags.highlevel")
    decoder = Decoder(path, msg_dirs)
    folder = bag_of(path)
    account = open_account(folder, budget)
    gathered: dict[tuple[str, str], tuple[array[int], Columns]] = {}
    try:
        with open_bag(folder, decoder.store, account) as bag:
            first = bag.start_time
            wanted = []
            for connection in bag.connections:
                kind = connection.msgtype
                if _LARGE.search(kind):
                    continue
                if kind in bag.typestore.types:
                    wanted.append(connection)
                elif connection.msgcount:
                    _unknown(findings, path, connection.topic, kind)
            for connection, stamp, raw in messages(bag, account, wanted) if wanted else ():
                topic, kind = connection.topic, connection.msgtype
                if (topic, kind) not in gathered:
                    gathered[topic, kind] = array("q"), Columns(account)
                came, columns = gathered[topic, kind]
                words: dict[str, str] = {}
                columns.add(flatten(_decoded(raw, topic, kind, bag.deserialize, path), words=words), words)
                came.append(stamp - first)
    except LogError:
        raise
    except Exception as error:  # rosbags has errors of its own for each format; all mean: not readable
        text = f"{path}: the bag cannot be read: {error or type(error).__name__}".split("\n")[0]
        raise LogError(text, "log.corrupt") from None
    if not gathered:
        raise LogError(f"{path}: no topic with messages that can be read", "log.foreign")
    return [
        Stream(
            topic,
            kind,
            np.frombuffer(came, dtype=np.int64).astype(np.float64) * 1e-9,
            columns.arrays(),
            texts=columns.texts(),
        )
        for (topic, kind), (came, columns) in gathered.items()
    ]


FORMAT = LogFormat(
    "bag",
    (".bag", ".db3"),
    ((b"#ROSBAG", "a ROS 1 bag"), (b"SQLite format 3\x00", "an SQLite file, as in a ROS 2 bag")),
    read_bag,
    folder="metadata.yaml",
)


def bag_of(path: Path) -> Path:
    """What rosbags opens: the file of a ROS 1 bag, the folder of a ROS 2 bag. Raises LogError."""
    folder = path.parent if path.suffix.lower() == ".db3" else path
    if folder != path and not (folder / "metadata.yaml").is_file():
        text = f"{path}: no metadata.yaml beside it, and without it no bag: `ros2 bag reindex {folder}` writes it"
        raise LogError(text, "log.corrupt")
    return folder


def full_name(kind: str) -> str:
    """`package/msg/Type` of `package/Type`."""
    package, _, rest = kind.partition("/")
    return kind if rest.startswith("msg/") or not rest else f"{package}/msg/{rest}"


def _unknown(findings: Findings, path: Path, topic: str, kind: str) -> None:
    findings.add(
        "log.type_unknown", str(path), None, topic, "messages of an unknown type are left out", found=kind,
        hint="give the folder of its .msg files: --msg DIR", severity="warning",
    )  # fmt: skip


def _decoded(raw: bytes, topic: str, kind: str, read: Callable[[bytes, str], Any], path: Path) -> Any:
    try:
        return _plain(read(raw, kind))
    except Exception as error:  # a message that does not fit its definition fails anywhere in the decoder
        text = f"{path}: {topic}: a message does not fit its definition {kind}: {error}".split("\n")[0]
        raise LogError(text, "log.corrupt") from None


def _plain(message: Any) -> Any:
    if dataclasses.is_dataclass(message) and not isinstance(message, type):
        return {
            field.name: _plain(getattr(message, field.name))
            for field in dataclasses.fields(message)
            if not str(field.type).startswith("ClassVar")  # a constant of the definition
        }
    return message
