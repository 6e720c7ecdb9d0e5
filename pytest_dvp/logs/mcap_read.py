"""MCAP -> Log, strict: a cut or changed file is an error that says so, never a log with less in it."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from pytest_dvp.logs.account import Account, open_account
from pytest_dvp.logs.budget import Budget
from pytest_dvp.logs.log_contents import (
    DETECTION_COLUMNS,
    TRACK_COLUMNS,
    TRACKING_COLUMNS,
    DetectionTable,
    FloatArray,
    LogContents,
    LogEvent,
    ObjectTrack,
    no_detections,
)
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.mcap_schemas import FORMAT
from pytest_dvp.logs.memory_map import Mapped, mapped
from pytest_dvp.logs.unfinished_run import PART, told_of

MAGIC = bytes((137, 77, 67, 65, 80, 48, 13, 10))  # MCAP specification, "Magic"
_FOOTER, _CHANNEL, _MESSAGE, _CHUNK, _DATA_END = 0x02, 0x04, 0x05, 0x06, 0x0F  # MCAP specification, "Opcodes"
_FOOTER_SIZE = 9 + 20  # bytes: opcode and length, then the record of the MCAP specification
_MAX_CHUNK = 1 << 30  # bytes after decompression; a larger one is an attack or a mistake
LZ4_RATIO = 255
"""The most bytes that one byte of LZ4 becomes (LZ4 block format: a match's length grows by 255 for each byte)."""
_VIEWER = frozenset({"/tf", "/ego/pose", "/ego/signals", "/scene", "/scene/road"})

Channels = dict[str, list[Any]]


class _BrokenError(Exception):
    """What is wrong with the file, without its name, and the code of LogError."""

    def __init__(self, message: str, code: str = "log.corrupt") -> None:
        super().__init__(message)
        self.code = code


def load_log(path: Path, budget: Budget | None = None) -> LogContents:
    """Read a log that `Log.save` wrote. Raises LogError with one line."""
    if path.name == PART:
        raise LogError(told_of(path) or f"{path}: no such log", "log.unreadable")
    try:
        account = open_account(path, budget)
        data = mapped(path)
    except LogError as error:
        if error.code != "log.unreadable":
            raise
        raise LogError(told_of(path) or f"{error}{_of_a_comparison(path)}", error.code) from error
    try:
        return _build(_messages(data, account), account)
    except (_BrokenError, LogError) as error:
        if error.code == "log.too_large":
            raise
        raise LogError(f"{path}: {error}", error.code) from error
    except RecursionError:
        raise LogError(f"{path}: not a log of dvp: a message is nested too deeply", "log.foreign") from None
    except (msgspec.MsgspecError, struct.error, LookupError, TypeError, ValueError, AttributeError) as error:
        raise LogError(
            f"{path}: not a log of dvp: {type(error).__name__}: {error}".split("\n")[0], "log.foreign"
        ) from error


def _of_a_comparison(path: Path) -> str:
    """A hint for who names the folder of stages held against each other, which has no log of its own."""
    try:
        result = msgspec.json.decode(path.with_name("result.json").read_bytes())
    except (OSError, msgspec.MsgspecError):
        return ""
    logs = result.get("logs") if isinstance(result, dict) else None
    places = ", ".join(map(str, logs.values())) if isinstance(logs, dict) else ""
    return f"; it holds stages against each other, their logs are in {places}" if places else ""


def _messages(data: Mapped, account: Account) -> Channels:
    """Decoded JSON of our own channels, by topic, after every checksum was compared."""
    if data[:8] != MAGIC:
        raise _BrokenError("not an MCAP file", "log.not_mcap")
    if data[-8:] != MAGIC or len(data) < 16 + _FOOTER_SIZE:
        raise _BrokenError(f"cut after {len(data)} bytes: the end of the file is missing", "log.truncated")
    _check_summary(data)
    topics: dict[int, str] = {}
    channels: Channels = {}
    decode = msgspec.json.Decoder().decode
    for opcode, start, end in _records(data, 8, len(data) - 8):
        if opcode == _DATA_END:
            (crc,) = struct.unpack_from("<I", data, start)
            if crc and zlib.crc32(memoryview(data)[: start - 9]) != crc:
                raise _BrokenError("corrupt: the checksum of the data does not match")
            return channels
        if opcode != _CHUNK:
            continue
        chunk = _chunk(data, start, end, account)
        for inner, low, high in _records(chunk, 0, len(chunk)):
            if inner == _MESSAGE:
                topic = topics[struct.unpack_from("<H", chunk, low)[0]]
                if topic not in _VIEWER:
                    channels.setdefault(topic, []).append(decode(memoryview(chunk)[low + 22 : high]))
            elif inner == _CHANNEL:
                identity, _schema, length = struct.unpack_from("<HHI", chunk, low)
                topics[identity] = chunk[low + 8 : low + 8 + length].decode()
    raise _BrokenError("corrupt: the data has no end")


def _check_summary(data: Mapped) -> None:
    start = len(data) - 8 - _FOOTER_SIZE
    opcode, length, summary, _offsets, crc = struct.unpack_from("<BQQQI", data, start)
    if opcode != _FOOTER or length != 20 or summary > start:
        raise _BrokenError("corrupt: no footer")
    # The checksum covers the summary and the footer up to the checksum itself (MCAP specification, "Footer").
    begin = summary or start
    if crc and zlib.crc32(memoryview(data)[begin : start + 9 + 16]) != crc:
        raise _BrokenError("corrupt: the checksum of the summary does not match")


def _records(data: Mapped, position: int, stop: int) -> Iterator[tuple[int, int, int]]:
    """(opcode, start, end) of the records in data[position:stop]."""
    while position < stop:
        if position + 9 > stop:
            raise _BrokenError(f"corrupt: half a record at byte {position}")
        opcode, length = struct.unpack_from("<BQ", data, position)
        start = position + 9
        position = start + length
        if position > stop:
            raise _BrokenError(f"corrupt: a record at byte {start - 9} reaches beyond the end", "log.record_too_long")
        yield opcode, start, position


def _chunk(data: Mapped, start: int, end: int, account: Account) -> bytes:
    size, crc, length = struct.unpack_from("<QII", data, start + 16)
    name = data[start + 32 : start + 32 + length].decode()
    (packed_size,) = struct.unpack_from("<Q", data, start + 32 + length)
    packed = data[start + 40 + length : end]
    if size > min(_MAX_CHUNK, LZ4_RATIO * len(packed)) or packed_size != len(packed):
        raise _BrokenError(f"corrupt: a chunk at byte {start - 9} of impossible size")
    account.unpack(size)
    try:
        chunk = _decompress(name, packed, size)
    except (RuntimeError, EOFError) as error:
        raise _BrokenError(f"corrupt: the chunk at byte {start - 9} cannot be decompressed") from error
    if len(chunk) != size or (crc and zlib.crc32(chunk) != crc):
        raise _BrokenError(f"corrupt: the checksum of the chunk at byte {start - 9} does not match")
    return chunk


def _decompress(name: str, packed: bytes, size: int) -> bytes:
    if name == "lz4":
        from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped]

        return bytes(LZ4FrameDecompressor().decompress(packed, max_length=size + 1))
    if name == "":
        return packed
    raise _BrokenError(f"compression {name!r} is not one of ours; expected lz4", "log.foreign")


def _build(channels: Channels, account: Account) -> LogContents:
    if not channels.get("/meta"):
        raise _BrokenError("a valid MCAP file but not a log of dvp: no /meta", "log.foreign")
    head = channels["/meta"][0]
    if head["format"] != FORMAT:
        raise _BrokenError(f"log format {head['format']!r}, this version reads {FORMAT}", "log.foreign")
    rows = int(head["rows"])
    account.rows(rows)
    parts: dict[str, list[FloatArray]] = {c["name"]: [] for c in head["columns"]}
    for topic in ("/signals", "/commands", "/ads"):
        for block in channels.get(topic, []):
            _append_block(parts, block, account)
    columns = {name: _join(pieces) for name, pieces in parts.items()}
    if any(len(values) != rows for values in columns.values()):
        raise _BrokenError("incomplete: rows are missing")
    return LogContents(
        columns=columns,
        objects=_objects(head["objects"], channels.get("/objects", []), account),
        detections=_detections(channels.get("/detections", []), account),
        paths=[(_float(p["t"]), _points(p["points"])) for p in channels.get("/path", [])],
        reference=_points(channels["/reference"][0]["points"]),
        road=[{"kind": r["kind"], "points": _points(r["points"])} for r in channels["/road"][0]["lines"]],
        events=[LogEvent(**{**e, "t": _float(e["t"])}) for e in channels.get("/events", [])],
        meta=head["meta"],
    )


def build_partial(channels: Channels, account: Account) -> tuple[LogContents, int]:
    """The log of the messages that are left of a damaged file, and the rows that it once had.

    Rows whose time is lost are left out, other lost values are NaN; what is missing is for the caller to tell.
    Raises LogError, LookupError, TypeError or ValueError if the head is lost.
    """
    head = channels["/meta"][0]
    rows = int(head["rows"])
    account.table(rows, len(head["columns"]))
    columns = {c["name"]: np.full(rows, np.nan) for c in head["columns"]}
    for topic in ("/signals", "/commands", "/ads"):
        for block in channels.get(topic, []):
            pieces: dict[str, list[FloatArray]] = {name: [] for name in block["columns"]}
            _append_block(pieces, block, account)
            for name, (values,) in pieces.items():
                columns[name][block["row"] : block["row"] + block["count"]] = values
    left = np.isfinite(columns["t"])
    whole = {
        **channels,
        "/meta": [{**head, "rows": int(np.count_nonzero(left))}],
        "/signals": [{"count": int(np.count_nonzero(left)), "columns": {n: v[left] for n, v in columns.items()}}],
        "/commands": [],
        "/ads": [],
        "/reference": channels.get("/reference") or [{"points": []}],
        "/road": channels.get("/road") or [{"lines": []}],
    }
    return _build(whole, account), rows


def _append_block(parts: dict[str, list[FloatArray]], block: Any, account: Account) -> None:
    count = block["count"]
    held = block.get("held")
    if held is None:
        for name, cell in block["columns"].items():
            parts[name].append(_column(cell, count, account))
        return
    lengths = np.diff([*held, count])
    for name, cell in block["columns"].items():
        account.hold(8 * int(np.sum(np.abs(lengths))))
        parts[name].append(np.repeat(_column(cell, len(held), account), lengths))


def _objects(head: list[Any], blocks: list[Any], account: Account) -> dict[str, ObjectTrack]:
    parts: dict[str, list[Any]] = {o["name"]: [] for o in head}
    for block in blocks:
        parts[block["name"]].append(block)
    return {
        o["name"]: ObjectTrack(
            o["kind"],
            _float(o["length"]),
            _float(o["width"]),
            _float(o["height"]),
            **_columns(parts[o["name"]], TRACK_COLUMNS, account),
        )
        for o in head
    }


def _detections(blocks: list[Any], account: Account) -> DetectionTable:
    if not blocks:
        return no_detections()
    kinds = tuple(kind for block in blocks for kind in block["kind"])
    told = tuple(c for c in TRACKING_COLUMNS if all(c in block["columns"] for block in blocks))  # older logs have none
    return DetectionTable(kind=kinds, **_columns(blocks, (*DETECTION_COLUMNS, *told), account))


def _columns(blocks: list[Any], names: tuple[str, ...], account: Account) -> dict[str, FloatArray]:
    return {name: _join([_column(b["columns"][name], b["count"], account) for b in blocks]) for name in names}


def _column(cell: Any, count: int, account: Account) -> FloatArray:
    whole = isinstance(cell, list | np.ndarray)
    account.hold(8 * (len(cell) if whole else count))
    if whole:
        return np.array(cell, dtype=np.float64)  # numpy reads None as NaN and the words "inf", "-inf"
    return np.full(count, _float(cell))


def _float(cell: Any) -> float:
    return float("nan") if cell is None else float(cell)


def _join(pieces: list[FloatArray]) -> FloatArray:
    return np.concatenate(pieces) if pieces else np.zeros(0)


def _points(cells: list[Any]) -> FloatArray:
    return np.array(cells, dtype=np.float64) if cells else np.zeros((0, 2))
