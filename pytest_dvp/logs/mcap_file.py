"""MCAP of others, and our own when damaged -> Log or streams: JSON channels, ROS 2 CDR where rosbags is installed."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from openscenario.findings import Findings
from pytest_dvp.log import Log, LogError
from pytest_dvp.log_read import Channels, build_partial
from pytest_dvp.logs.mcap_scan import Channel, Message, Scan, scan_mcap
from pytest_dvp.logs.stream import Stream, columns_of, flatten

_UNIT = re.compile(r"^\s*\[(?P<unit>[^\]]+)\]")


def read_mcap(path: Path, findings: Findings, msg_dirs: Sequence[Path] = ()) -> list[Stream] | Log:
    """Streams of a foreign file, or what is left of a log of ours. Raises LogError."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise LogError(f"{path}: the log cannot be read: {error.strerror or error}", "log.unreadable") from error
    scan = scan_mcap(data, str(path), findings)
    if findings.errors:
        raise LogError.of(findings.in_order())
    if not scan.count:
        raise LogError(f"{path}: no message in it", "log.too_short")
    topics = {channel.topic: identity for identity, channel in scan.channels.items()}
    if "/meta" in topics and scan.channels[topics["/meta"]].schema.name == "dvp.meta":
        return _ours(scan, path, findings)
    return streams_of(scan, path, findings, msg_dirs)


def our_log(scan: Scan, path: Path) -> tuple[Log, int]:
    """What is left of a log of ours, and the rows that it once had. Raises LogError if its head is lost."""
    decode = msgspec.json.Decoder().decode
    channels: Channels = {
        scan.channels[identity].topic: [decode(message.data) for message in messages]
        for identity, messages in scan.messages.items()
        if scan.channels[identity].schema.name.startswith("dvp.")
    }
    try:
        return build_partial(channels)
    except (LogError, LookupError, TypeError, ValueError, AttributeError) as error:
        raise LogError(f"{path}: nothing of the log can be recovered: {error}", "log.corrupt") from error


def _ours(scan: Scan, path: Path, findings: Findings) -> Log:
    log, rows = our_log(scan, path)
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


def streams_of(scan: Scan, path: Path, findings: Findings, msg_dirs: Sequence[Path]) -> list[Stream]:
    """A stream for each topic whose messages can be decoded; others are told."""
    first = min(message.log_time for messages in scan.messages.values() for message in messages)
    streams: list[Stream] = []
    decoder: Any = None
    for identity, messages in scan.messages.items():
        channel = scan.channels.get(identity)
        if channel is None:
            text = f"{len(messages)} messages without a channel"
            findings.add("log.corrupt", str(path), None, f"channel {identity}", text, severity="warning")
            continue
        if channel.encoding == "json":
            streams.append(_json(channel, messages, first, path))
        elif channel.encoding in ("cdr", "ros1"):
            from pytest_dvp.logs.ros import decoder_of

            decoder = decoder or decoder_of(path, msg_dirs)
            stream = decoder.stream(channel, messages, first, findings)
            if stream is not None:
                streams.append(stream)
        else:
            text, known = f"messages in {channel.encoding!r} are left out", "json, cdr, ros1"
            findings.add(
                "log.encoding_unknown", str(path), None, channel.topic, text, allowed=known, severity="warning"
            )
    if not streams:
        raise LogError(f"{path}: no topic with messages that can be read", "log.foreign")
    return streams


def _json(channel: Channel, messages: list[Message], first: int, path: Path) -> Stream:
    decode = msgspec.json.Decoder().decode
    try:
        fields = columns_of(flatten(decode(message.data)) for message in messages)
    except (msgspec.MsgspecError, UnicodeDecodeError) as error:
        raise LogError(f"{path}: {channel.topic}: a message is not JSON: {error}", "log.corrupt") from error
    receive = np.array([message.log_time - first for message in messages], dtype=np.float64) * 1e-9
    return Stream(
        channel.topic, channel.schema.name, receive, fields, _units(channel), channel.schema.name.startswith("dvp.")
    )


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
