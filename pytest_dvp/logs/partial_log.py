"""log.mcap.part: what a run has recorded so far, on disk while it drives, for `dvp recover` if the harness is killed.

An MCAP file whose end is missing. Its first chunk holds what is known before the first tick; each further one, complete
in itself, what the recorder got in the second before. It holds what was recorded, not columns: which columns a log has,
and what of a track belongs together, only the end of a run can tell.
"""

from __future__ import annotations

import io
import os
from collections.abc import Iterable
from pathlib import Path
from typing import IO, Any

import msgspec
import numpy as np
from mcap.writer import CompressionType, IndexType, Writer

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.mcap_schemas import FORMAT
from pytest_dvp.logs.recorder import LogRecorder, Recorded
from pytest_dvp.text.plain_json import finite

SCHEMA = "dvp.part"  # of both topics, for readers of MCAP
BEGUN, RECORDED = "/begun", "/recorded"
PERIOD = 0.9  # s simulated between two chunks: with the tick that is under way, a kill never costs more than one second


class _Line(msgspec.Struct):
    kind: str
    points: bytes


class _Begun(msgspec.Struct):
    """What is known before the first tick; meta as JSON, arrays as their bytes."""

    format: int
    meta: bytes
    reference: bytes
    road: list[_Line]


class LogPart:
    """The part of a run's log at `path`, of what `recorder` gets. Never raises: it must not cost a run its verdict.

    failed  why the file could not be written, as one line; from then on nothing is. "" while it can.
    """

    def __init__(self, path: Path, recorder: LogRecorder) -> None:
        self.path, self._recorder = path, recorder
        self.failed = ""
        self._mark = recorder.mark()
        self._due = 0.0
        self._file: IO[bytes] | None = None
        try:
            self._file = path.open("wb", buffering=0)
            self._begin()
        except (OSError, TypeError, ValueError) as error:
            self._give_up(error)

    def reached(self, t: float) -> None:
        """The run has come to `t` [s]: write what was recorded since the last chunk, if that is a while ago."""
        if t >= self._due:
            self._due = t + PERIOD
            self.write()

    def write(self) -> None:
        """Write what was recorded since the last chunk."""
        if self._file is None:
            return
        try:
            recorded, self._mark = self._recorder.since(self._mark)
            time = round(1e9 * recorded.times[0]) if recorded.times else 0
            self._add(self._channels[RECORDED], _packed(recorded), max(0, time))
        except (OSError, TypeError, ValueError) as error:
            self._give_up(error)

    def close(self) -> None:
        """Write no more; the file stays."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def drop(self) -> None:
        """The whole log is written: remove the part."""
        self.close()
        self.path.unlink(missing_ok=True)

    def _begin(self) -> None:
        recorder = self._recorder
        self._stream = io.BytesIO()
        # A chunk of one byte is full with its first message. What only indexes at the end would need is left out.
        self._writer = Writer(
            self._stream,
            chunk_size=1,
            compression=CompressionType.LZ4,
            index_types=IndexType.NONE,
        )
        self._writer.start(profile="", library=f"pytest-dvp part {FORMAT}")
        schema = self._writer.register_schema(SCHEMA, "", b"")
        self._channels = {topic: self._writer.register_channel(topic, "msgpack", schema) for topic in (BEGUN, RECORDED)}
        begun = _Begun(
            FORMAT,
            msgspec.json.encode(finite(recorder.meta)),
            _bytes(recorder.reference[:, :2]),
            [_Line(str(line["kind"]), _bytes(np.asarray(line["points"], dtype=np.float64))) for line in recorder.road],
        )
        self._add(self._channels[BEGUN], _packed(begun), 0)

    def _add(self, channel: int, data: bytes, time: int) -> None:
        """One chunk in one write: a kill leaves it whole or not there at all, or cut where a disk is full."""
        self._writer.add_message(channel, time, data, time)
        chunk = self._stream.getvalue()
        self._stream.seek(0)
        self._stream.truncate()
        assert self._file is not None
        left = memoryview(chunk)
        while left:
            left = left[os.write(self._file.fileno(), left) :]

    def _give_up(self, error: Exception) -> None:
        why = error.strerror or str(error) if isinstance(error, OSError) else str(error)
        self.failed = f"{self.path}: cannot be written: {why}"
        if self._file is not None:
            self._file.close()
            self._file = None


def is_part(topics: Iterable[str]) -> bool:
    """Whether a file with these topics is the part of a log."""
    return {BEGUN, RECORDED} & set(topics) != set()


def log_of_part(messages: Iterable[tuple[str, bytes]], path: Path) -> Log:
    """The log of what is left of a part, from its messages by topic. Raises LogError if its head is lost."""
    recorder: LogRecorder | None = None
    try:
        for topic, content in messages:
            if topic == BEGUN:
                begun = msgspec.msgpack.decode(content, type=_Begun)
                if begun.format != FORMAT:
                    raise LogError(f"{path}: log format {begun.format}, this version reads {FORMAT}", "log.foreign")
                road = [{"kind": line.kind, "points": _points(line.points)} for line in begun.road]
                meta = msgspec.json.decode(begun.meta, type=dict[str, Any])
                recorder = LogRecorder(meta, reference=_points(begun.reference), road=road)
            elif topic == RECORDED and recorder is not None:
                recorder.take(msgspec.msgpack.decode(content, type=Recorded))
        if recorder is None:
            raise LogError("its beginning is lost")
        return recorder.finish()
    except (LogError, LookupError, TypeError, ValueError, RecursionError) as error:
        if isinstance(error, LogError) and error.code == "log.foreign":
            raise
        raise LogError(f"{path}: nothing of the log can be recovered: {error}", "log.corrupt") from error


def _packed(what: object) -> bytes:
    return msgspec.msgpack.encode(what, enc_hook=_plain)


def _plain(value: object) -> float:
    """Numbers of numpy, which a stack may give."""
    return float(value)  # type: ignore[arg-type]


def _bytes(values: Any) -> bytes:
    return np.ascontiguousarray(values, dtype=np.float64).tobytes()


def _points(data: bytes) -> Any:
    return np.frombuffer(data, dtype=np.float64).reshape(-1, 2)
