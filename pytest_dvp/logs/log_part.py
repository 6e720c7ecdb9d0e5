"""`LOG@0:285`: a part of a log, in seconds of its own time."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import TRACK_COLUMNS, ObjectTrack
from pytest_dvp.logs.log_error import LogError

_ALONE = re.compile(r"^(?P<file>.+)@(?P<start>[-+.\deE]+)$")
_CUT = re.compile(r"^(?P<file>.+)@(?P<start>[-+.\deE]*):(?P<stop>[-+.\deE]*)$")


class Argument(NamedTuple):
    """A log argument: file, and the part [start, stop) in seconds (infinite where open)."""

    path: Path
    start: float
    stop: float

    @property
    def whole(self) -> bool:
        """Whether the argument names the whole file: neither end of the part is stated."""
        return self.start == -np.inf and self.stop == np.inf


def parse_argument(argument: str | Path) -> Argument:
    """`LOG`, `LOG@0:285`, `LOG@285:`, `LOG@:60`. A file that has this very name is that file.

    Raises LogError for a part that is none.
    """
    whole = Argument(Path(argument), -np.inf, np.inf)
    cut = _CUT.match(str(argument))
    if whole.path.exists():
        return whole
    alone = _ALONE.match(str(argument))
    if alone is not None and Path(alone["file"]).exists():
        ends = f"{argument}: from there on, {alone['file']}@:{alone['start']} up to there"
        raise LogError(f"{argument}: no such log; a part of one is {ends}", "log.bad_cut")
    if cut is None:
        return whole
    try:
        start = float(cut["start"]) if cut["start"] else -np.inf
        stop = float(cut["stop"]) if cut["stop"] else np.inf
    except ValueError:
        start = stop = np.nan
    if not start < stop:
        raise LogError(
            f"{argument}: not a part of a log, expected LOG@START:STOP in seconds, START < STOP", "log.bad_cut"
        )
    return Argument(Path(cut["file"]), start, stop)


def cut_log(log: Log, start: float, stop: float, name: str = "log") -> Log:
    """Rows, tracks, detections, paths and events with start <= t < stop [s]; times stay as they are.

    Raises LogError if fewer than 3 rows are left.
    """

    def inside(t: np.ndarray[tuple[int], np.dtype[np.float64]]) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        return (t >= start) & (t < stop)

    rows = inside(log.t)
    if np.count_nonzero(rows) < 3:
        span = f"{log.t[0]:.6g} to {log.t[-1]:.6g} s" if len(log.t) else "no rows"
        raise LogError(f"{name}: nothing between {start:g} and {stop:g} s; the log has {span}", "log.too_short")
    tracks = {}
    for key, track in log.objects.items():
        seen = inside(track.t)
        if seen.any():
            tracks[key] = ObjectTrack(
                track.kind,
                track.length,
                track.width,
                track.height,
                **{c: getattr(track, c)[seen] for c in TRACK_COLUMNS},
            )
    return dataclasses.replace(
        log,
        columns={key: values[rows] for key, values in log.columns.items()},
        objects=tracks,
        detections=log.detections.rows(inside(log.detections.t)),
        paths=[(t, points) for t, points in log.paths if start <= t < stop],
        events=[event for event in log.events if start <= event.t < stop],
        meta={**log.meta, "cut": [None if np.isinf(start) else start, None if np.isinf(stop) else stop]},
    )
