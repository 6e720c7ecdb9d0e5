"""Small logs with known answers."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from hypothesis import settings

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import DetectionTable, FloatArray, LogEvent, ObjectTrack

STEP = 0.01  # s
relaxed = settings(deadline=None)  # the first example may compile
EGO = {"length": 3.0, "width": 1.5, "height": 1.4, "center_x": 1.2}


def log_of(
    duration: float = 10.0,
    *,
    columns: Mapping[str, FloatArray | float] | None = None,
    meta: Mapping[str, Any] | None = None,
    **rest: Any,
) -> Log:
    """A log of `duration` [s] at 100 Hz; columns not given stand still at the origin."""
    t = np.arange(round(duration / STEP) + 1) * STEP
    names = ("x", "y", "yaw", "v", "vx", "vy", "yaw_rate")
    values: dict[str, FloatArray | float] = {**dict.fromkeys(names, 0.0), **(columns or {})}
    table = {
        name: np.full(len(t), value) if np.isscalar(value) else np.asarray(value) for name, value in values.items()
    }
    return Log({"t": t, **table}, meta={"stage": "dt", "ego": EGO, **(meta or {})}, **rest)


def content(value: Any) -> Any:
    """All that a log holds as plain data, in its order, and numbers bit by bit: also a NaN is the same as itself."""
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, float):
        return value.hex()
    if dataclasses.is_dataclass(value):
        return [(field.name, content(getattr(value, field.name))) for field in dataclasses.fields(value)]
    if isinstance(value, Mapping):
        return [(name, content(part)) for name, part in value.items()]
    return [content(part) for part in value] if isinstance(value, list | tuple) else value


def times(duration: float = 10.0) -> FloatArray:
    return np.arange(round(duration / STEP) + 1) * STEP


def drive_straight(speed: float, duration: float = 10.0, **rest: Any) -> Log:
    """Along the x axis at constant speed [m/s], the reference point in the origin at t = 0."""
    t = times(duration)
    return log_of(duration, columns={"x": speed * t, "v": speed, "vx": speed}, **rest)


def track(
    t: FloatArray,
    x: FloatArray | float,
    y: FloatArray | float,
    *,
    yaw: float = 0.0,
    vx: float = 0.0,
    vy: float = 0.0,
    size: tuple[float, float] = (4.0, 2.0),
    kind: str = "vehicle",
) -> ObjectTrack:
    def full(value: FloatArray | float) -> FloatArray:
        return np.broadcast_to(np.asarray(value, dtype=np.float64), t.shape).copy()

    return ObjectTrack(kind, *size, 1.5, t, full(x), full(y), full(0.75), full(yaw), full(vx), full(vy))


def rich_log(seed: int = 0, rows: int = 250) -> Log:
    """Random numbers in every place a log has, with NaN, infinities and -0.0 among them."""
    rng = np.random.default_rng(seed)
    t = np.arange(rows) * STEP

    def odd(n: int) -> FloatArray:
        values = rng.normal(size=n) * 10.0 ** rng.integers(-300, 300, n)
        values[rng.random(n) < 0.05] = np.nan
        values[rng.random(n) < 0.05] = np.inf
        values[rng.random(n) < 0.05] = -np.inf
        values[rng.random(n) < 0.05] = -0.0
        return values

    held = np.repeat(odd(rows // 5 + 1), 5)[:rows]
    place = np.repeat([0.0, 1.0], rows)[:rows]
    table: dict[str, FloatArray] = {"t": t, "x": rng.normal(size=rows), "y": rng.normal(size=rows), "yaw": odd(rows)}
    table |= {"v": odd(rows), "steer": np.zeros(rows), "steer_cmd": held, "ads.x": odd(rows), "ads.net.a.p": place}
    tracks = {
        'car "100%s"': track(t[::5], odd(len(t[::5])), 1.0, vx=2.0),
        "walker": track(t[10:50:5], 1.0, odd(len(t[10:50:5])), kind="pedestrian"),
        "never": track(np.zeros(0), 0.0, 0.0),
    }
    n = 333
    kinds = tuple(rng.choice(["vehicle", "pedestrian"], n).tolist())
    detections = DetectionTable(np.sort(rng.uniform(0, 2, n)), kinds, *(odd(n) for _ in range(7)))
    events: Sequence[LogEvent] = (
        LogEvent(0.0, "story.event", "Story/Act/Event", "standbyState -> runningState", "a.xosc", 12),
        LogEvent(1.5, "collision", "walker"),
    )
    return Log(
        table,
        tracks,
        detections,
        [(0.0, rng.normal(size=(30, 2))), (0.65, np.zeros((0, 2)))],
        rng.normal(size=(40, 2)),
        [{"kind": "edge", "points": rng.normal(size=(7, 2))}, {"kind": "lane", "points": np.zeros((0, 2))}],
        events,
        {"stage": "dt", "seed": 7, "ego": EGO, "P": {"LQR_q11": 30.0}, "text": "naïve \x1b[31m"},
    )
