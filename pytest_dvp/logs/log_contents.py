"""What a log holds: columns, the motion of other road users, detections and events."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.logs.log_error import LogError

FloatArray: TypeAlias = NDArray[np.float64]


TRACK_COLUMNS = ("t", "x", "y", "z", "yaw", "vx", "vy")


DETECTION_COLUMNS = ("t", "x", "y", "yaw", "length", "width", "vx", "vy")

TRACKING_COLUMNS = ("track", "cov_xx", "cov_xy", "cov_yy")
"""Columns that a table of detections has where the stack tells them."""


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class ObjectTrack:
    """True motion of one road user: sizes [m], and arrays (n,) of its own time base t [s].

    x, y, z [m] are the middle of its box in the map frame, yaw [rad], vx, vy [m/s] in the map frame.
    """

    kind: str
    length: float
    width: float
    height: float
    t: FloatArray
    x: FloatArray
    y: FloatArray
    z: FloatArray
    yaw: FloatArray
    vx: FloatArray
    vy: FloatArray

    def __repr__(self) -> str:
        return f"ObjectTrack({self.kind}, {self.length:g} x {self.width:g} m, {_span(self.t)})"


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class DetectionTable:
    """What the perception reported, a row a box: t [s], kind, x, y [m] of the middle and yaw [rad] in the map frame,
    length, width [m], vx, vy [m/s] in the map frame. Arrays (n,); `kind` holds n words.

    track: number of the track, NaN for none; cov_xx, cov_xy, cov_yy [m^2]: covariance of x, y as the stack states it.
    None where the stack tells none."""

    t: FloatArray
    kind: tuple[str, ...]
    x: FloatArray
    y: FloatArray
    yaw: FloatArray
    length: FloatArray
    width: FloatArray
    vx: FloatArray
    vy: FloatArray
    track: FloatArray | None = None
    cov_xx: FloatArray | None = None
    cov_xy: FloatArray | None = None
    cov_yy: FloatArray | None = None

    @property
    def tracking(self) -> dict[str, FloatArray]:
        """Those of TRACKING_COLUMNS that it has, by name: arrays (n,), covariances in [m^2]."""
        told = {name: getattr(self, name) for name in TRACKING_COLUMNS}
        return {name: values for name, values in told.items() if values is not None}

    def rows(self, keep: NDArray[np.bool_]) -> DetectionTable:
        """The table with only the rows of the mask (n,)."""
        columns = {name: getattr(self, name)[keep] for name in DETECTION_COLUMNS}
        columns |= {name: values[keep] for name, values in self.tracking.items()}
        return DetectionTable(kind=tuple(k for k, kept in zip(self.kind, keep, strict=True) if kept), **columns)

    def __repr__(self) -> str:
        return f"DetectionTable({_span(self.t)})"


@dataclasses.dataclass(frozen=True, slots=True)
class LogEvent:
    """Something that happened at `t` [s].

    kind   "story.event" and the like for storyboard transitions (text "standbyState -> runningState"), "collision"
           (element: the object hit), "request" (a storyboard action on the ego), "start" and "goal" of the task,
           "stop" (the scenario ended by its own triggers), "timeout" (the time limit ended it), "fault",
           "gate" (element: what the guard did, text: why), "wire" (element: topic, text: what was wrong),
           "wire_note" (element: topic, text: what was assumed of sound messages),
           "signal" (a traffic light, element: its id, text: its new state),
           "environment" (what holds from now on of road, air and light),
           "monitor" (of the scenario, element: its name, text: its value),
           "replay" (the stack no longer asks for what was asked for in the recording).
    file, line  place in the user's file that caused it, if one did.
    """

    t: float
    kind: str
    element: str
    text: str = ""
    file: str = ""
    line: int | None = None


def no_detections() -> DetectionTable:
    """An empty table."""
    return DetectionTable(kind=(), **{name: np.zeros(0) for name in DETECTION_COLUMNS})


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class LogContents:
    """One run, as it is in memory; `pytest_dvp.logs.log.Log` also knows files.

    columns     float64 arrays (n,) by name, "t" [s] first; NaN = not measured. Names and units:
                pytest_dvp.logs.signals.
    objects     true motion of the other road users by name, in the order of their appearance
    detections  what the perception reported
    paths       (t [s], array (k, 2) of x, y [m]) of the planned path whenever it changed
    reference   array (m, 2) of x, y [m]: centre line of the task's lane or route, in driving direction
    road        {"kind": "edge"|"lane"|"centre"|"crosswalk", "points": array (k, 2)} lines for pictures
    events      in the order in which they happened
    meta        JSON-able conditions of the run: no wall clock, host or absolute path
    tick_time   figures of `pytest_dvp.drive.tick_time`, known while a run is judged; they are never saved

    Raises LogError if the columns do not belong together.
    """

    columns: Mapping[str, FloatArray]
    objects: Mapping[str, ObjectTrack] = dataclasses.field(default_factory=dict)
    detections: DetectionTable = dataclasses.field(default_factory=no_detections)
    paths: Sequence[tuple[float, FloatArray]] = ()
    reference: FloatArray = dataclasses.field(default_factory=lambda: np.zeros((0, 2)))
    road: Sequence[Mapping[str, Any]] = ()
    events: Sequence[LogEvent] = ()
    meta: dict[str, Any] = dataclasses.field(default_factory=dict)
    tick_time: Mapping[str, Any] | None = None

    def __post_init__(self) -> None:
        if next(iter(self.columns), None) != "t":
            raise LogError('log: the first column must be "t"')
        n = len(self.columns["t"])
        for name, values in self.columns.items():
            if values.dtype != np.float64 or values.shape != (n,):
                raise LogError(f"log: column {name!r} is {values.dtype}{list(values.shape)}, expected float64[{n}]")

    def __repr__(self) -> str:
        parts = [str(self.meta.get("scenario", "")), _span(self.t), f"{len(self.columns)} columns"]
        parts.append(f"{len(self.objects)} object{'' if len(self.objects) == 1 else 's'}")
        return f"Log({', '.join(part for part in parts if part)})"

    @property
    def t(self) -> FloatArray:
        """Time base [s]. Shape (n,)."""
        return self.columns["t"]

    @property
    def duration(self) -> float:
        """Time from the first to the last sample [s]; 0 for an empty log."""
        return float(self.t[-1] - self.t[0]) if len(self.t) else 0.0

    def __getitem__(self, name: str) -> FloatArray:
        """Column by name. Raises LogError with the name that was meant."""
        values = self.columns.get(name)
        if values is None:
            raise LogError(f"log: no column {name!r}{_meant(name, self.columns)}")
        return values


def _meant(name: str, names: Iterable[str]) -> str:
    import difflib

    from pytest_dvp.logs.column_names import canonical

    other = canonical(name)  # "speed" is a usual name of "v", and near to nothing by its letters
    if other != name and other in names:
        return f", did you mean {other!r}?"
    near = difflib.get_close_matches(name, names, n=1)
    return f", did you mean {near[0]!r}?" if near else ""


def _span(t: FloatArray) -> str:
    return f"{len(t)} rows, {t[0]:.2f} to {t[-1]:.2f} s" if len(t) else "no rows"
