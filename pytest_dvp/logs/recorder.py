"""LogRecorder: collects a run at a few microseconds a tick and makes a Log of it at the end."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import DETECTION_COLUMNS, DetectionTable, FloatArray, LogEvent, ObjectTrack
from pytest_dvp.logs.signals import COMMAND_COLUMNS
from vehicle.messages import OBJECT_KINDS, TRACE_COLUMNS, Command, Detection, Surroundings

_SAME_TIME = 1e-6  # s: a tick and a row of the trace at the same time differ by rounding only


class Recorded(msgspec.Struct, array_like=True):
    """What a recorder got in a while, as plain data: arrays as their bytes, else as LogRecorder keeps it."""

    ego: bytes
    times: list[float]
    commands: list[Command | None]
    ads: list[dict[str, Any]]
    held: list[dict[str, Any]]
    names: list[tuple[str, ...]]
    boxes: list[bytes]
    kinds: list[bytes]
    between: list[tuple[float, dict[str, float]]]
    detections: list[tuple[float, list[Detection]]]
    paths: list[tuple[float, bytes]]
    events: list[LogEvent]


class LogRecorder:
    """One recorder a run. References to frozen messages are kept and arrays copied; all else waits for `finish`."""

    def __init__(
        self,
        meta: dict[str, Any] | None = None,
        *,
        reference: FloatArray | None = None,
        road: Sequence[Mapping[str, Any]] = (),
    ) -> None:
        self.meta: dict[str, Any] = meta if meta is not None else {}
        self.reference = reference if reference is not None else np.zeros((0, 2))
        self.road = road
        self._ego: list[FloatArray] = []
        self._times: list[float] = []
        self._commands: list[Command | None] = []
        self._ads: list[dict[str, float]] = []
        self._held: list[dict[str, float]] = []
        self._between: list[tuple[float, Mapping[str, float]]] = []
        self._names: list[tuple[str, ...]] = []
        self._boxes: list[FloatArray] = []
        self._kinds: list[NDArray[np.int64]] = []
        self._detections: list[tuple[float, Sequence[Detection]]] = []
        self._paths: list[tuple[float, FloatArray]] = []
        self._last_path: FloatArray | None = None
        self._events: list[LogEvent] = []
        # All lists, in the order of Recorded.
        self._kept: tuple[list[Any], ...] = (
            self._ego, self._times, self._commands, self._ads, self._held, self._names, self._boxes, self._kinds,
            self._between, self._detections, self._paths, self._events,
        )  # fmt: skip

    def ego_rows(self, trace: FloatArray) -> None:
        """Motion of the ego since the last call: array (n, 12) of TRACE_COLUMNS, as `Vehicle.step` returns it.

        SI units.
        """
        self._ego.append(trace.copy())

    def tick(
        self,
        t: float,
        *,
        command: Command | None = None,
        ads: Mapping[str, float] | None = None,
        surroundings: Surroundings | None = None,
        detections: Sequence[Detection] = (),
        path: FloatArray | None = None,
        held: Mapping[str, float] | None = None,
    ) -> None:
        """State of everything but the ego at time `t` [s] of the run.

        ads       the stack's trace, names without "ads."
        path      planned path, array (n, 2 or more) of x, y [m]; the same object means the same path
        held      other columns that hold until the next tick, under their own names ("on_road", "speed_cmd")
        """
        self._times.append(t)
        self._commands.append(command)
        self._ads.append(dict(ads) if ads else {})
        self._held.append(dict(held) if held else {})
        if surroundings is not None:
            self._names.append(surroundings.names)
            self._boxes.append(surroundings.boxes.copy())
            self._kinds.append(surroundings.kinds)
        else:
            self._names.append(())
            self._boxes.append(_NO_BOXES)
            self._kinds.append(_NO_KINDS)
        if detections:
            self._detections.append((t, detections))
        if path is not None and path is not self._last_path:
            self._last_path = path
            self._paths.append((t, np.array(path[:, :2], dtype=np.float64)))

    def hold(self, t: float, values: Mapping[str, float]) -> None:
        """Columns that hold from `t` [s] on, whenever that is, until they are given again; never those of a `tick`."""
        self._between.append((t, values))

    def event(self, t: float, kind: str, element: str, text: str = "", file: str = "", line: int | None = None) -> None:
        """Something happened; kinds as in LogEvent. `file` is relative to the scenario's folder."""
        self._events.append(LogEvent(t, kind, element, text, file, line))

    def mark(self) -> tuple[int, ...]:
        """Where `since` begins: how much of each kind is recorded."""
        return tuple(map(len, self._kept))

    def since(self, mark: tuple[int, ...]) -> tuple[Recorded, tuple[int, ...]]:
        """What was recorded since `mark`, and the mark from which to go on."""
        ego, times, commands, ads, held, names, boxes, kinds, between, detections, paths, events = (
            kept[begin:] for kept, begin in zip(self._kept, mark, strict=True)
        )
        recorded = Recorded(
            b"".join(rows.tobytes() for rows in ego),
            times,
            commands,
            ads,
            held,
            names,
            [rows.tobytes() for rows in boxes],
            [np.asarray(numbers, dtype=np.int64).tobytes() for numbers in kinds],
            [(t, dict(values)) for t, values in between],
            [(t, list(found)) for t, found in detections],
            [(t, points.tobytes()) for t, points in paths],
            events,
        )
        return recorded, self.mark()

    def cut(self, mark: tuple[int, ...]) -> None:
        """Forget what was recorded since `mark`: an interrupted tick leaves half of what belongs together."""
        for kept, end in zip(self._kept, mark, strict=True):
            del kept[end:]

    def take(self, recorded: Recorded) -> None:
        """Put back what `since` gave. Raises ValueError if its arrays are cut or do not belong together."""
        rows = np.frombuffer(recorded.ego).reshape(-1, len(TRACE_COLUMNS))
        boxes = [np.frombuffer(data).reshape(-1, _NO_BOXES.shape[1]) for data in recorded.boxes]
        kinds = [np.frombuffer(data, dtype=np.int64) for data in recorded.kinds]
        paths = [(t, np.frombuffer(data).reshape(-1, 2)) for t, data in recorded.paths]
        ticks = {len(of) for of in (recorded.times, recorded.commands, recorded.ads, recorded.held, boxes, kinds)}
        if ticks != {len(recorded.names)}:
            raise ValueError("its ticks do not belong together")
        for names, box, kind in zip(recorded.names, boxes, kinds, strict=True):
            if not len(names) == len(box) == len(kind) or any(not 0 <= k < len(OBJECT_KINDS) for k in kind.tolist()):
                raise ValueError("its road users do not belong together")
        put: tuple[list[Any], ...] = (
            [rows], recorded.times, recorded.commands, recorded.ads, recorded.held, recorded.names, boxes, kinds,
            recorded.between, recorded.detections, paths, recorded.events,
        )  # fmt: skip
        for kept, more in zip(self._kept, put, strict=True):
            kept.extend(more)

    def finish(self) -> Log:
        """The Log of all that was recorded so far; can be called after a run broke off."""
        rows = np.concatenate(self._ego) if self._ego else np.zeros((0, len(TRACE_COLUMNS)))
        columns = {name: np.ascontiguousarray(rows[:, i]) for i, name in enumerate(TRACE_COLUMNS)}
        columns.update(self._held_columns(columns["t"]))
        return Log(
            columns=columns,
            objects=self._tracks(),
            detections=self._table(),
            paths=tuple(self._paths),
            reference=np.array(self.reference[:, :2], dtype=np.float64),
            road=tuple({"kind": r["kind"], "points": np.asarray(r["points"], dtype=np.float64)} for r in self.road),
            events=tuple(self._events),
            meta=self.meta,
        )

    def _held_columns(self, t: FloatArray) -> dict[str, FloatArray]:
        """A value given at a tick holds from that instant on; before the first tick it is not measured."""
        nan = float("nan")
        values: dict[str, list[float]] = {}
        if any(command is not None for command in self._commands):
            table = [(c.steer, c.accel, c.throttle, c.brake) if c else (nan,) * 4 for c in self._commands]
            values.update(
                (name, list(column)) for name, column in zip(COMMAND_COLUMNS, zip(*table, strict=True), strict=True)
            )
        # Not sorted: the order of the stack's own trace is the order a reader expects, and it is reproducible.
        for prefix, rows in (("ads.", self._ads), ("", self._held)):
            for name in dict.fromkeys(itertools.chain.from_iterable(rows)):
                values[prefix + name] = [row.get(name, nan) for row in rows]
        found = _holding(self._times, values, t)
        between: dict[str, list[float]] = {
            name: [] for name in dict.fromkeys(n for _, row in self._between for n in row)
        }
        for name, column in between.items():
            column.extend(row.get(name, nan) for _, row in self._between)
        return found | _holding([time for time, _ in self._between], between, t)

    def _tracks(self) -> dict[str, ObjectTrack]:
        pieces: dict[str, list[FloatArray]] = {}
        kinds: dict[str, int] = {}
        start = 0
        for stop in range(1, len(self._names) + 1):
            if stop < len(self._names) and self._names[stop] == self._names[start]:
                continue
            names = self._names[start]
            if names:
                times = np.array(self._times[start:stop])
                block = np.stack(self._boxes[start:stop])
                for i, name in enumerate(names):
                    pieces.setdefault(name, []).append(np.column_stack((times, block[:, i])))
                    kinds.setdefault(name, int(self._kinds[start][i]))
            start = stop
        return {name: _track(np.concatenate(rows), kinds[name]) for name, rows in pieces.items()}

    def _table(self) -> DetectionTable:
        rows = [(t, d) for t, found in self._detections for d in found]
        cells = [(t, d.x, d.y, d.yaw, d.length, d.width, d.vx, d.vy) for t, d in rows]
        table = np.array(cells, dtype=np.float64).reshape(-1, len(DETECTION_COLUMNS))
        columns = {name: np.ascontiguousarray(table[:, i]) for i, name in enumerate(DETECTION_COLUMNS)}
        found = [d for _, d in rows]
        if any(d.track >= 0 for d in found):
            columns["track"] = np.array([d.track if d.track >= 0 else np.nan for d in found], dtype=np.float64)
        if any(tuple(d.covariance) != _NO_COVARIANCE for d in found):  # from another process it is a list
            stated = np.array([d.covariance for d in found], dtype=np.float64)
            columns |= {f"cov_{axes}": np.ascontiguousarray(stated[:, i]) for i, axes in enumerate(("xx", "xy", "yy"))}
        return DetectionTable(kind=tuple(d.kind for d in found), **columns)


def _holding(times: Sequence[float], values: Mapping[str, Sequence[float]], t: FloatArray) -> dict[str, FloatArray]:
    """Each column, given at `times` (ascending), at every stamp t (n,) [s]; NaN before the first."""
    index = np.searchsorted(np.array(times), t + _SAME_TIME, side="right")
    return {name: np.array([np.nan, *column], dtype=np.float64)[index] for name, column in values.items()}


_NO_COVARIANCE = (0.0, 0.0, 0.0)  # as Detection has it where a stack states none
_NO_BOXES: FloatArray = np.zeros((0, 9))
_NO_KINDS: NDArray[np.int64] = np.zeros(0, dtype=np.int64)


def _track(rows: FloatArray, kind: int) -> ObjectTrack:
    """From rows of t and the nine columns of Surroundings.boxes; the size is that of the first appearance."""
    t, x, y, z, yaw, length, width, height, vx, vy = (np.ascontiguousarray(rows[:, i]) for i in range(10))
    size = float(length[0]), float(width[0]), float(height[0])
    return ObjectTrack(OBJECT_KINDS[kind], *size, t, x, y, z, yaw, vx, vy)
