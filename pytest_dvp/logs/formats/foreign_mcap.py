"""MCAP of others, and our own when damaged -> Log or streams: JSON channels, ROS 2 CDR where rosbags is installed."""

from __future__ import annotations

import json
import re
from array import array
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from openscenario.findings import Findings
from pytest_dvp.logs.account import Account, open_account
from pytest_dvp.logs.budget import Budget, shown_size
from pytest_dvp.logs.formats.log_format import LogFormat
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.mcap_read import Channels, build_partial
from pytest_dvp.logs.mcap_scan import Channel, Message, Scan, scan_mcap
from pytest_dvp.logs.memory_map import Mapped, mapped
from pytest_dvp.logs.stream import Columns, Stream, flatten

LONGEST = 1 << 20
"""Bytes of a JSON message of signals (1,000 fields of 50 bytes are 50 kB); decoded, it takes up to 30 times as many."""
OVERHEAD = 200
"""Bytes that a kept message takes in memory beside its data (CPython 3.11: tuple, three whole numbers, bytes)."""
_UNIT = re.compile(r"^\s*\[(?P<unit>[^\]]+)\]")


def read_mcap(
    path: Path, findings: Findings, msg_dirs: Sequence[Path] = (), budget: Budget | None = None
) -> list[Stream] | Log:
    """Streams of a foreign file, or what is left of a log of ours. Raises LogError.

    The file is gone through twice: first messages are only counted, so that a file which is too large, or not what its
    name says, takes no memory; then each message is decoded and let go.
    """
    data = mapped(path)
    scan = scan_mcap(data, str(path), findings, Scan(open_account(path, budget)))
    if findings.errors:
        raise LogError.of(findings.in_order())
    if not scan.count:
        raise LogError(f"{path}: no message in it", "log.too_short")
    scan.account.rows(scan.count)
    if any(channel.topic == "/meta" and channel.schema.name == "dvp.meta" for channel in scan.channels.values()):
        return _ours(data, path, findings, budget)
    return _streams(data, scan, path, findings, msg_dirs, open_account(path, budget))


FORMAT = LogFormat("mcap", (".mcap",), ((b"\x89MCAP0\r\n", "an MCAP file"),), read_mcap)


def our_log(messages: Iterable[tuple[str, bytes]], path: Path, account: Account) -> tuple[Log, int]:
    """What is left of a log of ours, from its messages by topic, and the rows that it once had.

    Raises LogError if its head is lost.
    """
    decode = msgspec.json.Decoder().decode
    channels: Channels = {}
    try:
        for topic, content in messages:
            channels.setdefault(topic, []).append(decode(content))
        contents, rows = build_partial(channels, account)
        return Log.of(contents), rows
    except (LogError, LookupError, TypeError, ValueError, AttributeError, RecursionError) as error:
        if isinstance(error, LogError) and error.code == "log.too_large":
            raise
        raise LogError(f"{path}: nothing of the log can be recovered: {error}", "log.corrupt") from error


def kept_messages(scan: Scan) -> list[tuple[int, Message]]:
    """A list that the scan fills with each message and its channel's id; it is charged to the scan's account."""
    kept: list[tuple[int, Message]] = []

    def take(channel: int, message: Message) -> None:
        scan.account.hold(len(message.data) + OVERHEAD)
        kept.append((channel, message._replace(data=bytes(message.data))))

    scan.take = take
    return kept


def by_topic(scan: Scan, kept: Iterable[tuple[int, Message]]) -> Iterator[tuple[str, bytes]]:
    """The messages of a log of ours."""
    for identity, message in kept:
        channel = scan.channels.get(identity)
        if channel is not None and channel.schema.name.startswith("dvp."):
            yield channel.topic, bytes(message.data)


def _ours(data: Mapped, path: Path, findings: Findings, budget: Budget | None) -> Log:
    scan = Scan(open_account(path, budget))
    messages = kept_messages(scan)
    scan_mcap(data, str(path), Findings(), scan)
    log, rows = our_log(by_topic(scan, messages), path, scan.account)
    kept = len(log.t)
    step = log.duration / (kept - 1) if kept > 1 else 0.0
    if kept < rows:
        findings.add(
            "log.truncated", str(path), None, "",
            f"{kept} of {rows} rows are read, to t = {log.t[-1] if kept else 0.0:.2f} s; "
            f"{rows - kept} rows, about {(rows - kept) * step:.2f} s, are lost",
            severity="warning",
        )  # fmt: skip
    return log


class _Gathered:
    """What is gathered of a channel: when each message came [ns], and its numbers."""

    def __init__(
        self, channel: Channel, account: Account, decode: Callable[[bytes | memoryview], Any], kind: str = ""
    ) -> None:
        self.channel = channel
        self._kind = kind or channel.schema.name
        self.came = array("Q")
        self.columns = Columns(account)
        self.too_long = 0  # messages
        self._decode = decode

    def take(self, message: Message) -> None:
        if self.channel.encoding == "json" and len(message.data) > LONGEST:
            self.too_long += 1
            return
        words: dict[str, str] = {}
        self.columns.add(flatten(self._decode(message.data), words=words), words)
        self.came.append(message.log_time)

    def stream(self, first: int) -> Stream:
        receive = (np.frombuffer(self.came, dtype=np.uint64) - np.uint64(first)).astype(np.float64) * 1e-9
        channel, units = self.channel, _units(self.channel) if self.channel.encoding == "json" else {}
        si = channel.encoding == "json" and channel.schema.name.startswith("dvp.")
        return Stream(channel.topic, self._kind, receive, self.columns.arrays(), units, si, self.columns.texts())


def _streams(
    data: Mapped, counted: Scan, path: Path, findings: Findings, msg_dirs: Sequence[Path], account: Account
) -> list[Stream]:
    """A stream for each topic whose messages can be decoded; others are told. A topic that was written by several
    channels, as after a restart of the recorder, is one."""
    gathered: dict[int, _Gathered] = {}
    first_of: dict[tuple[str, str, str], _Gathered] = {}
    decoder: Any = None
    for identity, count in counted.counts.items():
        channel = counted.channels.get(identity)
        if channel is None:
            text = f"{count} messages without a channel"
            findings.add("log.corrupt", str(path), None, f"channel {identity}", text, severity="warning")
        elif channel.encoding == "json":
            gathered[identity] = _Gathered(channel, account, _json_decoder(channel, path))
        elif channel.encoding in ("cdr", "ros1"):
            from pytest_dvp.logs.formats.ros_bag import Decoder, full_name

            decoder = decoder or Decoder(path, msg_dirs)
            decode = decoder.of_channel(channel, findings)
            if decode is not None:
                gathered[identity] = _Gathered(channel, account, decode, full_name(channel.schema.name))
        else:
            text, known = f"messages in {channel.encoding!r} are left out", "json, cdr, ros1"
            findings.add(
                "log.encoding_unknown", str(path), None, channel.topic, text, allowed=known, severity="warning"
            )

    for identity, one in gathered.items():
        alike = (one.channel.topic, one.channel.encoding, one.channel.schema.name)
        gathered[identity] = first_of.setdefault(alike, one)

    def take(identity: int, message: Message) -> None:
        if (one := gathered.get(identity)) is not None:
            one.take(message)

    if gathered:
        scan_mcap(data, str(path), Findings(), Scan(account, take))
    for one in first_of.values():
        if one.too_long:
            findings.add(
                "log.message_too_long", str(path), None, one.channel.topic,
                f"{one.too_long} JSON messages are left out: pictures or point clouds, not signals",
                allowed=f"up to {shown_size(LONGEST)} each", severity="warning",
            )  # fmt: skip
    streams = [one.stream(counted.first) for one in first_of.values() if one.came]
    if not streams:
        raise LogError(f"{path}: no topic with messages that can be read", "log.foreign")
    return streams


def _json_decoder(channel: Channel, path: Path) -> Callable[[bytes | memoryview], Any]:
    decode = msgspec.json.Decoder().decode

    def decoded(content: bytes | memoryview) -> Any:
        try:
            try:
                return decode(content)
            except msgspec.DecodeError:
                return json.loads(bytes(content))  # Python's own writer puts NaN for what was not measured
        except (ValueError, msgspec.MsgspecError) as error:
            raise LogError(f"{path}: {channel.topic}: a message is not JSON: {error}", "log.corrupt") from error
        except RecursionError:
            raise LogError(f"{path}: {channel.topic}: a message is nested too deeply", "log.corrupt") from None

    return decoded


def _units(channel: Channel) -> dict[str, str]:
    """Units that a JSON schema states: `"unit": "m/s"`, or a description that begins with `[m/s]`."""
    try:
        schema = msgspec.json.decode(channel.schema.data) if channel.schema.data else {}
    except (msgspec.MsgspecError, UnicodeDecodeError):
        return {}
    units: dict[str, str] = {}

    def walk(node: Any, prefix: str, depth: int) -> None:
        properties = node.get("properties", {}) if isinstance(node, dict) and depth < 8 else {}
        for name, entry in properties.items() if isinstance(properties, dict) else ():
            dotted = f"{prefix}.{name}" if prefix else name
            if isinstance(entry, dict):
                stated = _UNIT.match(str(entry.get("description", "")))
                text = entry.get("unit") or (stated["unit"] if stated else "")
                if isinstance(text, str) and text:
                    units[dotted] = text
            walk(entry, dotted, depth + 1)

    walk(schema, "", 0)
    return units
