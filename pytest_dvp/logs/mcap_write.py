"""Log -> MCAP, fast and byte for byte reproducible.

Columns travel in blocks of BLOCK rows (about a second), so that JSON costs little and a file that was cut still yields
its first seconds. LZ4 because it is deterministic and three times as fast as zstd on such text.
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np
from mcap.writer import CompressionType, Writer

from pytest_dvp.logs.log_contents import DETECTION_COLUMNS, TRACK_COLUMNS, FloatArray, LogContents
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.mcap_schemas import FORMAT, schemas
from pytest_dvp.logs.signals import describe
from pytest_dvp.logs.viewer_channels import viewer_messages
from pytest_dvp.text.plain_json import finite
from reports.whole_file import WriteError, write_whole

BLOCK = 100  # rows: 1 s at the 100 Hz of the log
TRACK_BLOCK = 20  # rows: 1 s at the 20 Hz of the world
DETECTION_BLOCK = 200  # boxes
CHUNK_SIZE = 512 * 1024  # bytes before compression: some ten seconds of a run

_plain = msgspec.json.Encoder().encode


class Message(NamedTuple):
    """One MCAP message to be: log time [ns], topic, JSON."""

    time: int
    topic: str
    data: bytes


def save_log(log: LogContents, path: Path) -> None:
    """Write beside the target, then rename: a reader never sees half a file. Raises LogError."""
    try:
        write_whole(path, encode_log(log))
    except WriteError as error:
        raise LogError(str(error), "log.unwritable") from error
    except (TypeError, msgspec.MsgspecError) as error:
        raise LogError(f"{path}: the log cannot be written: {error}", "log.unwritable") from error


def encode_log(log: LogContents) -> bytes:
    """The MCAP file as bytes."""
    stream = io.BytesIO()
    writer = Writer(stream, chunk_size=CHUNK_SIZE, compression=CompressionType.LZ4, enable_data_crcs=True)
    # Own library string: that of the mcap package holds its version and would make equal logs differ.
    writer.start(profile="", library=f"pytest-dvp log {FORMAT}")
    channels: dict[str, int] = {}
    for topic, (name, schema) in schemas(list(log.columns)).items():
        channels[topic] = writer.register_channel(topic, "json", writer.register_schema(name, "jsonschema", schema))
    order = {topic: i for i, topic in enumerate(channels)}
    messages = [*_head(log), *_signals(log), *_held(log), *_objects(log), *_detections(log), *_paths(log)]
    messages += [*_events(log), *(Message(time, topic, data) for time, topic, data in viewer_messages(log))]
    messages.sort(key=lambda m: (m.time, order[m.topic]))
    for sequence, message in enumerate(messages):
        writer.add_message(channels[message.topic], message.time, message.data, message.time, sequence)
    writer.finish()  # type: ignore[no-untyped-call]
    return stream.getvalue()


def _encode(data: object) -> bytes:
    try:
        return _plain(data)
    except UnicodeEncodeError:  # a file name that is no UTF-8
        return _plain(finite(data))


def _nanoseconds(t: float) -> int:
    # The exact time is in the message; MCAP's own is unsigned and only sorts.
    return max(0, round(t * 1e9)) if math.isfinite(t) else 0


def _head(log: LogContents) -> Iterator[Message]:
    signals = [describe(name) for name in log.columns]
    objects = [
        {"name": n, "kind": o.kind, "length": o.length, "width": o.width, "height": o.height}
        for n, o in log.objects.items()
    ]
    meta = {
        "format": FORMAT,
        "rows": len(log.t),
        "columns": [{"name": s.name, "unit": s.unit, "frame": s.frame} for s in signals],
        "objects": objects,
        "meta": log.meta,
    }
    yield Message(0, "/meta", _encode(meta))
    lines = [{"kind": line["kind"], "points": _cells(np.asarray(line["points"], dtype=float))} for line in log.road]
    yield Message(0, "/road", _encode({"lines": lines}))
    yield Message(0, "/reference", _encode({"points": _cells(log.reference)}))


def _signals(log: LogContents) -> Iterator[Message]:
    names = [name for name in log.columns if not describe(name).keeps_value]
    columns = [_Blocks(log.columns[name]) for name in names]
    for a in range(0, len(log.t), BLOCK):
        b = min(a + BLOCK, len(log.t))
        block = {name: column.cut(a, b) for name, column in zip(names, columns, strict=True)}
        yield Message(_nanoseconds(float(log.t[a])), "/signals", _encode({"row": a, "count": b - a, "columns": block}))


def _held(log: LogContents) -> Iterator[Message]:
    """Quantities that change with the stack's tick only: their rows of change instead of all rows."""
    held = [name for name in log.columns if describe(name).keeps_value]
    for topic, names in (
        ("/commands", [n for n in held if not n.startswith("ads.")]),
        ("/ads", [n for n in held if n.startswith("ads.")]),
    ):
        if not names or not len(log.t):
            continue
        changes = np.zeros(len(log.t), dtype=bool)
        changes[::BLOCK] = True  # every block stands alone
        for name in names:
            bits = np.ascontiguousarray(log.columns[name]).view(np.int64)
            changes[1:] |= bits[1:] != bits[:-1]
        rows = np.flatnonzero(changes)
        columns = [_Blocks(log.columns[name][rows]) for name in names]
        starts = range(0, len(log.t), BLOCK)
        cuts = np.searchsorted(rows, [*starts, len(log.t)]).tolist()
        for i, a in enumerate(starts):
            low, high = cuts[i], cuts[i + 1]
            block = {name: column.cut(low, high) for name, column in zip(names, columns, strict=True)}
            count = min(BLOCK, len(log.t) - a)
            data = {"row": a, "count": count, "held": (rows[low:high] - a).tolist(), "columns": block}
            yield Message(_nanoseconds(float(log.t[a])), topic, _encode(data))


def _objects(log: LogContents) -> Iterator[Message]:
    for name, track in log.objects.items():
        columns = {c: _Blocks(getattr(track, c)) for c in TRACK_COLUMNS}
        for a in range(0, len(track.t), TRACK_BLOCK):
            b = min(a + TRACK_BLOCK, len(track.t))
            block = {c: column.cut(a, b) for c, column in columns.items()}
            yield Message(
                _nanoseconds(float(track.t[a])), "/objects", _encode({"name": name, "count": b - a, "columns": block})
            )


def _detections(log: LogContents) -> Iterator[Message]:
    table = log.detections
    columns = {c: _Blocks(getattr(table, c)) for c in (*DETECTION_COLUMNS, *table.tracking)}
    for a in range(0, len(table.t), DETECTION_BLOCK):
        b = min(a + DETECTION_BLOCK, len(table.t))
        block = {c: column.cut(a, b) for c, column in columns.items()}
        data = {"count": b - a, "kind": table.kind[a:b], "columns": block}
        yield Message(_nanoseconds(float(table.t[a])), "/detections", _encode(data))


def _paths(log: LogContents) -> Iterator[Message]:
    for t, points in log.paths:
        yield Message(_nanoseconds(t), "/path", _encode({"t": _number(t), "points": _cells(points)}))


def _events(log: LogContents) -> Iterator[Message]:
    for e in log.events:
        data = {"t": _number(e.t), "kind": e.kind, "element": e.element, "text": e.text, "file": e.file, "line": e.line}
        yield Message(_nanoseconds(e.t), "/events", _encode(data))


class _Blocks:
    """A column turned into Python numbers once and handed out in blocks."""

    __slots__ = ("_change", "_values")

    def __init__(self, values: FloatArray) -> None:
        bits = np.ascontiguousarray(values).view(np.int64)
        # Index of the last change at or before each row: a block is constant if none lies inside it.
        change = np.zeros(len(bits), dtype=np.int64)
        if len(bits):
            change[1:] = np.where(bits[1:] != bits[:-1], np.arange(1, len(bits)), 0)
        self._change: list[int] = np.maximum.accumulate(change).tolist()
        self._values = _cells(values)

    def cut(self, a: int, b: int) -> Any:
        return self._values[a] if self._change[b - 1] <= a else self._values[a:b]


def _cells(values: FloatArray) -> list[Any]:
    """Nested lists; NaN stays (msgspec writes null), infinities become words."""
    cells: list[Any] = values.tolist()
    if np.isinf(values).any():
        return _words(cells)
    return cells


def _words(cells: Sequence[Any]) -> list[Any]:
    return [_words(cell) if isinstance(cell, list) else _number(cell) for cell in cells]


def _number(value: float) -> float | str:
    return ("inf" if value > 0 else "-inf") if math.isinf(value) else value
