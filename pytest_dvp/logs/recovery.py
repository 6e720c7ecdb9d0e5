"""What is whole of a damaged CSV or MCAP file -> a new file, with how much was lost. Nothing is repaired or guessed."""

from __future__ import annotations

import csv
import dataclasses
import io
import struct
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType, Writer

from pytest_dvp.logs.account import Account, open_account
from pytest_dvp.logs.budget import Budget
from pytest_dvp.logs.column_names import canonical
from pytest_dvp.logs.file_kind import refuse_other_kind
from pytest_dvp.logs.formats.csv_file import EMPTY, normalised, number, read_head
from pytest_dvp.logs.formats.foreign_mcap import by_topic, kept_messages, our_log
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.mcap_read import MAGIC
from pytest_dvp.logs.mcap_scan import OPCODES, Message, Scan, read_chunk, read_record, records, unfitting
from pytest_dvp.logs.memory_map import Mapped, mapped
from pytest_dvp.logs.partial_log import SCHEMA, is_part, log_of_part
from pytest_dvp.logs.table import Table
from pytest_dvp.logs.text_times import seconds_of
from pytest_dvp.logs.units import find_unit
from reports.whole_file import write_whole

KINDS = (".csv", ".tsv", ".txt", ".mcap")
PART = ".part"  # end of the name of a log of a run that was not finished
NO_END = "the end of the file: nobody knows how much"
_COMPRESSED = (b"\x04\x00\x00\x00zstd", b"\x03\x00\x00\x00lz4")  # length and name in the head of a chunk
_NAME_AT = 9 + 28  # bytes from the start of a chunk's record to them


@dataclasses.dataclass(frozen=True)
class Recovered:
    """unit: "rows" or "messages"; seconds: what the kept ones span; lost: sentences, empty if nothing was."""

    kept: int
    unit: str
    seconds: float
    lost: tuple[str, ...]


def recover(path: Path, out: Path, budget: Budget | None = None) -> Recovered:
    """Write to `out` all rows or messages of `path` that are whole.

    CSV: rows with a number or an empty field in each column, word for word. MCAP: the messages of every chunk that
    passes its checksum, also behind a damaged place; of a log of dvp, the log of the rows that have a time; of the part
    of a log that a run was writing when it was ended, the log so far.
    Limits: what a damaged row or chunk held is lost; a value that was changed into another number cannot be seen in a
    CSV; attachments and metadata of an MCAP file are not copied.
    budget: how large the log may be; None: the budget of the command or session.
    Raises LogError if nothing is left or the log is too large, WriteError if `out` cannot be written.
    """
    if kind_of(path) != ".mcap":  # of that the first bytes may be what is damaged
        refuse_other_kind(path, "csv")
    account = open_account(path, budget)
    data = mapped(path)
    return _mcap(data, path, out, account) if kind_of(path) == ".mcap" else _csv(data[:], path, out, account)


def kind_of(path: Path) -> str:
    """The end of a log's name by which it is read: ".mcap" also of "log.mcap.part"."""
    return (Path(path.stem) if path.suffix.lower() == PART else path).suffix.lower()


def _csv(data: bytes, path: Path, out: Path, account: Account) -> Recovered:
    text = normalised(data, path)
    zeros = text.count(b"\x00")
    head = read_head(text.replace(b"\x00", b""), Table(str(path), "csv", []))
    names, separator = [canonical(header.name) for header in head.headers], head.separator
    if "t" not in names:
        raise LogError(f"{path}: nothing can be recovered: no time column in the header", "log.time_missing")
    clock, width = names.index("t"), len(names)
    account.rows(head.body.count(b"\n"))
    unit = find_unit(head.headers[clock].unit or "s")
    # Zero bytes stay in their row, which is none then: without them two halves of rows would look like a whole one.
    top = text.replace(b"\x00", b"")[: -len(head.body) or None]
    lines = text.split(b"\n", top.count(b"\n"))[-1].decode("latin-1").split("\n")
    rows = [_fields(line, separator) for line in lines]
    rows = [row[:-1] if len(row) == width + 1 and not row[-1].strip() else row for row in rows]
    whole = [row for row in rows if len(row) == width]
    counted = [sum(_number(row[i], separator) is not None for row in whole) for i in range(width)]
    words = {i for i in range(width) if counted[i] < 0.5 * len(whole)}
    time_of = _stamp if clock in words else _number
    words.add(clock)
    kept, lost_at, times = [], [], []
    for offset, (line, row) in enumerate(zip(lines, rows, strict=True)):
        if not row:
            continue
        time = time_of(row[clock], separator) if len(row) == width else None
        good = time is not None and all(i in words or _cell(cell, separator) for i, cell in enumerate(row))
        if good and time is not None and np.isfinite(time) and "\x00" not in line:
            kept.append(line)
            times.append(time)
        else:
            lost_at.append(head.line + offset)
    if len(kept) < 3:
        raise LogError(f"{path}: nothing can be recovered: {len(kept)} whole rows", "log.too_short")
    lost = [f"{len(lost_at)} row{'s' * (len(lost_at) > 1)} not whole, first in line {lost_at[0]}"] if lost_at else []
    lost += [f"{zeros} zero bytes"] if zeros else []
    write_whole(out, top + ("\n".join(kept) + "\n").encode("latin-1"))
    scale = unit.scale if unit is not None and time_of is _number else 1.0
    return Recovered(len(kept), "rows", (times[-1] - times[0]) * scale, tuple(lost))


def _fields(line: str, separator: str) -> list[str]:
    if line.count('"') % 2:  # a quote that is not closed would take the lines below with it
        return [line]
    try:
        return next(csv.reader([line], delimiter=separator), []) if line.strip(" \t\x00") else []
    except csv.Error:  # longer than a field may be
        return [line]


def _number(cell: str, separator: str) -> float | None:
    return number(cell.replace(",", ".") if separator != "," else cell)


def _stamp(cell: str, separator: str) -> float | None:
    """Seconds of a time that is written in words."""
    found = seconds_of([cell])
    return None if found is None else float(found[0])


def _cell(cell: str, separator: str) -> bool:
    return cell.strip().lower() in EMPTY or _number(cell, separator) is not None


def _mcap(data: Mapped, path: Path, out: Path, account: Account) -> Recovered:
    scan = Scan(account)
    kept = kept_messages(scan)
    lost = _salvage(data, scan)
    if not scan.count:
        raise LogError(f"{path}: nothing can be recovered: no whole message in it", "log.too_short")
    if not any(identity in scan.channels for identity, _ in kept):
        why = "what says of which topics its messages are is lost"
        raise LogError(f"{path}: nothing can be recovered: {why}", "log.corrupt")
    if scan.statistics is not None and scan.statistics > scan.count:
        lost.append(f"{scan.statistics - scan.count} of {scan.statistics} messages")
    topics = {channel.topic: channel for channel in scan.channels.values()}
    if is_part(channel.topic for channel in topics.values() if channel.schema.name == SCHEMA):
        log = log_of_part(by_topic(scan, kept), path)
        account.table(len(log.t), len(log.columns))
        log.save(out)
        return Recovered(len(log.t), "rows", log.duration, (*_of_part(lost), "what came after the last whole second"))
    if "/meta" in topics and topics["/meta"].schema.name == "dvp.meta":
        log, rows = our_log(by_topic(scan, kept), path, account)
        if len(log.t) < rows:
            lost.append(f"{rows - len(log.t)} of {rows} rows")
        log.save(out)
        return Recovered(len(log.t), "rows", log.duration, tuple(lost))
    write_whole(out, _encoded(scan, kept))
    return Recovered(scan.count, "messages", scan.seconds, tuple(lost))


def _of_part(lost: list[str]) -> list[str]:
    """What is lost of a part: that its end is missing goes without saying."""
    return [text for text in lost if text != NO_END]


def _salvage(data: Mapped, scan: Scan) -> list[str]:
    """Reads records to the first that does not fit, goes on at the next chunk, and so forth; says what was passed."""
    lost = [] if data[:8] == MAGIC else ["the first 8 bytes"]
    position, skipped, damaged, seconds = 8, 0, 0, 0.0
    footer = False
    while position < len(data) and not footer:
        try:
            for opcode, start, end in records(data, position, len(data), False):
                if opcode not in OPCODES:
                    break
                if opcode == 6 and not read_chunk(data, start, end, scan):
                    damaged += 1
                    low, high = struct.unpack_from("<QQ", data, start)
                    seconds += max(high - low, 0) * 1e-9
                elif opcode in (3, 4, 5):
                    read_record(data, opcode, start, end, scan)
                elif opcode == 11:
                    scan.statistics = struct.unpack_from("<Q", data, start)[0]
                elif opcode == 2:
                    footer = True
                    position = end
                    break
                position = end
        except unfitting:
            pass
        if not footer:
            following = _next_chunk(data, position + 1)
            skipped += following - position
            position = following
    if damaged:
        lost.append(f"{damaged} damaged chunks" + (f" of {seconds:.3g} s in all" if seconds < 1e6 else ""))
    if skipped:
        lost.append(f"{skipped} bytes that are no whole record")
    if not footer:
        lost.append(NO_END)
    return lost


def _next_chunk(data: Mapped, position: int) -> int:
    """Start of the next compressed chunk, the length of the data if there is none."""
    found = len(data)
    for name in _COMPRESSED:
        at = data.find(name, position + _NAME_AT, found + _NAME_AT)
        while at >= 0:
            if data[at - _NAME_AT] == 6:
                found = min(found, at - _NAME_AT)
                break
            at = data.find(name, at + 1, found + _NAME_AT)
    return found


def _encoded(scan: Scan, kept: list[tuple[int, Message]]) -> bytes:
    """The messages in the order of their log times, as a new MCAP file: same topics, schemas, stamps and bytes."""
    stream = io.BytesIO()
    writer = Writer(stream, compression=CompressionType.ZSTD)
    writer.start(profile="", library="pytest-dvp recover")
    first = {identity: place for place, identity in enumerate(dict.fromkeys(identity for identity, _ in kept))}
    kept.sort(key=lambda entry: (entry[1].log_time, first[entry[0]]))
    channels: dict[int, int] = {}
    for identity in dict.fromkeys(identity for identity, _ in kept):
        channel = scan.channels.get(identity)
        if channel is None:
            continue  # its channel record is lost: nobody knows what these bytes mean
        schema = channel.schema
        number = writer.register_schema(schema.name, schema.encoding, schema.data) if schema.name else 0
        channels[identity] = writer.register_channel(channel.topic, channel.encoding, number)
    for identity, message in kept:
        if identity in channels:
            writer.add_message(
                channels[identity], message.log_time, bytes(message.data), message.publish_time, message.sequence
            )
    writer.finish()  # type: ignore[no-untyped-call]
    return stream.getvalue()
