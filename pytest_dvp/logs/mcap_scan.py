"""MCAP, any writer's, whole or damaged: every message that can be read, and a finding for all that cannot.

Read in the order of the file and never through the summary: a file that lost its end then yields all it holds.
Source: MCAP specification, "Serialization" and "Opcodes".
"""

from __future__ import annotations

import dataclasses
import struct
import zlib
from collections.abc import Callable, Iterator
from typing import NamedTuple, TypeAlias

from openscenario.findings import Findings
from pytest_dvp.logs.account import Account
from pytest_dvp.logs.mcap_read import LZ4_RATIO, MAGIC
from pytest_dvp.logs.memory_map import Mapped
from pytest_dvp.logs.unpack import UnpackError, unpack

OPCODES = {1: "Header", 2: "Footer", 3: "Schema", 4: "Channel", 5: "Message", 6: "Chunk", 7: "MessageIndex",
           8: "ChunkIndex", 9: "Attachment", 10: "AttachmentIndex", 11: "Statistics", 12: "MetadataIndex",
           13: "Metadata", 14: "SummaryOffset", 15: "DataEnd"}  # fmt: skip
_MAX_CHUNK = 1 << 30  # bytes after decompression; a larger one is an attack or a mistake


class Schema(NamedTuple):
    name: str
    encoding: str
    data: bytes


class Channel(NamedTuple):
    """A topic, its message encoding ("json", "cdr", ...) and schema."""

    topic: str
    encoding: str
    schema: Schema


class Message(NamedTuple):
    """Times in ns as the file has them; data: bytes where the message is kept, else a view."""

    log_time: int
    publish_time: int
    sequence: int
    data: bytes | memoryview


Taker: TypeAlias = Callable[[int, Message], None]
"""What is done with each message; it gets the channel's id, and the data are there for this call only."""


@dataclasses.dataclass
class Scan:
    """What a file holds: channels and numbers of messages by channel id, and whether the file is whole.

    account  charged for every chunk before it is unpacked
    take     gets each message, in the order of the file; None: messages are only counted
    first, last  log times [ns]
    """

    account: Account
    take: Taker | None = None
    channels: dict[int, Channel] = dataclasses.field(default_factory=dict)
    counts: dict[int, int] = dataclasses.field(default_factory=dict)
    schemas: dict[int, Schema] = dataclasses.field(default_factory=dict)
    statistics: int | None = None
    whole: bool = True
    lost_messages: int = 0
    first: int = 0
    last: int = 0

    @property
    def count(self) -> int:
        """Number of messages in all channels together."""
        return sum(self.counts.values())

    @property
    def seconds(self) -> float:
        """Time from the first to the last message [s]."""
        return (self.last - self.first) * 1e-9

    def add(self, channel: int, message: Message) -> None:
        """Count a message of a channel, widen first and last log time [ns] to hold it, and hand it to `take` if there
        is one.
        """
        time = message.log_time
        if not self.counts:
            self.first = self.last = time
        self.first, self.last = min(self.first, time), max(self.last, time)
        self.counts[channel] = self.counts.get(channel, 0) + 1
        if self.take is not None:
            self.take(channel, message)


class _CutError(Exception):
    """The file ends inside a record."""


class _TooLongError(Exception):
    """A record says that it is longer than the file that holds it."""


class _NoRecordError(Exception):
    """There is something else where a record should begin."""


unfitting = (_CutError, _TooLongError, _NoRecordError, struct.error, UnicodeDecodeError, IndexError)
"""What reading a record raises that does not hold what its kind needs."""


def scan_mcap(data: Mapped, file: str, findings: Findings, scan: Scan) -> Scan:
    """All that can be read of `data`; `findings` says what is lost, in messages and seconds.

    Raises LogError for a file that unpacks to more than the scan's account allows.
    """
    if data[:8] != MAGIC:
        findings.add(
            "log.not_mcap", file, None, "", "not an MCAP file", found=data[:8].hex(" "), allowed=MAGIC.hex(" "),
            hint="the first 8 bytes of an MCAP file are its magic",
        )  # fmt: skip
        return scan
    ended = data[-8:] == MAGIC
    position = 8
    try:
        position = _walk(data, scan, file, findings, ended)
    except _TooLongError as error:
        findings.add(
            "log.record_too_long", file, None, str(error), "a record is longer than the file that holds it",
            hint="perhaps `dvp recover` finds whole chunks behind it",
        )  # fmt: skip
        return scan
    except _CutError as cut:
        position = int(cut.args[0])
        scan.whole = False
    except (_NoRecordError, struct.error, UnicodeDecodeError, IndexError):
        findings.add(
            "log.corrupt", file, None, "", "a record does not hold what its kind needs",
            hint="perhaps `dvp recover` finds whole chunks behind it",
        )  # fmt: skip
        return scan
    if not ended or not scan.whole:
        _tell_cut(scan, file, findings, len(data) - position)
    return scan


def _walk(data: Mapped, scan: Scan, file: str, findings: Findings, ended: bool) -> int:
    stop = len(data) - (8 if ended else 0)
    checked = damaged = False
    pending: list[tuple[float, float]] = []  # start and end [s] of each chunk that could not be read
    for opcode, start, end in records(data, 8, stop, ended):
        if opcode == 6:
            damaged = not read_chunk(data, start, end, scan)
            if damaged:
                low, high = struct.unpack_from("<QQ", data, start)
                pending.append((low * 1e-9, high * 1e-9))
        elif opcode == 7:
            if not damaged:  # the index of a chunk follows it
                continue
            (size,) = struct.unpack_from("<I", data, start + 2)
            scan.lost_messages += size // 16
        elif opcode == 15:
            (crc,) = struct.unpack_from("<I", data, start)
            checked = True
            if crc and not pending and zlib.crc32(memoryview(data)[: start - 9]) != crc:
                findings.add(
                    "log.corrupt", file, None, "", "the checksum of the data does not match: some value was changed",
                    hint="take the file from its source again",
                )  # fmt: skip
        elif opcode == 11:
            scan.statistics = struct.unpack_from("<Q", data, start)[0]
        elif opcode == 2:
            _summary(data, start, file, findings)
            break
        else:
            read_record(data, opcode, start, end, scan)
    if pending:
        seconds = sum(high - low for low, high in pending)
        findings.add(
            "log.corrupt", file, None, "",
            f"{len(pending)} chunks are damaged and left out: {scan.lost_messages} messages, {seconds:.3g} s, "
            f"first at {pending[0][0]:.3f} s",
            severity="warning", hint="what is left is whole; `dvp recover` writes it to a new file",
        )  # fmt: skip
        scan.whole = scan.whole and checked
    return stop


def records(data: Mapped, position: int, stop: int, ended: bool) -> Iterator[tuple[int, int, int]]:
    """(opcode, start, end) of the records. Raises when one does not fit in."""
    while position < stop:
        if position + 9 > stop:
            raise _CutError(position)
        opcode, length = struct.unpack_from("<BQ", data, position)
        if not opcode:  # "not a valid opcode"; a file of zeros would have a record every 9 bytes
            raise _NoRecordError(position)
        start = position + 9
        if start + length > stop:
            if ended or length > 1 << 40 or position == 8:
                raise _TooLongError(OPCODES.get(opcode, f"opcode {opcode}"))
            raise _CutError(position)
        position = start + length
        yield opcode, start, position


def read_record(data: Mapped, opcode: int, start: int, end: int, scan: Scan) -> None:
    """Add the record data[start:end] to the scan: a schema (opcode 3), a channel (4) or a message (5); others do
    nothing.
    """
    if opcode == 5:
        channel, sequence, log_time, publish_time = struct.unpack_from("<HIQQ", data, start)
        scan.add(channel, Message(log_time, publish_time, sequence, memoryview(data)[start + 22 : end]))
    elif opcode == 4:
        identity, schema = struct.unpack_from("<HH", data, start)
        topic, position = _string(data, start + 4)
        encoding, _ = _string(data, position)
        scan.channels[identity] = Channel(topic, encoding, scan.schemas.get(schema, Schema("", "", b"")))
    elif opcode == 3:
        (identity,) = struct.unpack_from("<H", data, start)
        name, position = _string(data, start + 2)
        encoding, position = _string(data, position)
        (size,) = struct.unpack_from("<I", data, position)
        scan.schemas[identity] = Schema(name, encoding, bytes(data[position + 4 : position + 4 + size]))


def _string(data: Mapped, position: int) -> tuple[str, int]:
    (length,) = struct.unpack_from("<I", data, position)
    return bytes(data[position + 4 : position + 4 + length]).decode(), position + 4 + length


def read_chunk(data: Mapped, start: int, end: int, scan: Scan) -> bool:
    """Reads a chunk; False if it is damaged. Raises LogError for one that is too large."""
    size, crc = struct.unpack_from("<QI", data, start + 16)
    name, position = _string(data, start + 28)
    (packed,) = struct.unpack_from("<Q", data, position)
    if size > _MAX_CHUNK or packed != end - position - 8:
        return False
    content = data[position + 8 : end]
    if not _possible(name, content, size):
        return False
    scan.account.unpack(size)
    try:
        chunk = unpack(name, content, size)
    except UnpackError:
        return False
    if len(chunk) != size or (crc and zlib.crc32(chunk) != crc):
        return False
    try:
        for opcode, low, high in records(chunk, 0, len(chunk), True):
            read_record(chunk, opcode, low, high, scan)
    except (_CutError, _TooLongError, _NoRecordError):
        return False
    return True


def _possible(name: str, packed: bytes, size: int) -> bool:
    """Whether so many bytes can unpack to that size at all; a size that a flipped bit made is one damaged chunk."""
    if name == "lz4":
        return size <= LZ4_RATIO * len(packed)
    if name == "zstd":
        import zstandard

        try:
            return zstandard.frame_content_size(packed) in (-1, size)  # a frame is taken at its word; -1: it has none
        except zstandard.ZstdError:
            return False
    return size == len(packed)


def _summary(data: Mapped, start: int, file: str, findings: Findings) -> None:
    summary, _offsets, crc = struct.unpack_from("<QQI", data, start)
    begin = summary or start - 9
    if crc and zlib.crc32(memoryview(data)[begin : start + 16]) != crc:
        findings.add(
            "log.corrupt", file, None, "Footer", "the checksum of the summary does not match; the messages are whole",
            severity="warning",
        )  # fmt: skip


def _tell_cut(scan: Scan, file: str, findings: Findings, left: int) -> None:
    findings.add(
        "log.truncated", file, None, "",
        f"the end of the file is missing: {scan.count} messages over {scan.seconds:.3f} s are whole and read, "
        f"{max(left, 0)} bytes of an unfinished record are not",
        severity="warning", hint="the recording was not finished; `dvp recover` writes what is whole to a new file",
    )  # fmt: skip
