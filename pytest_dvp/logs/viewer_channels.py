"""The part of the record that is there for viewers only: /ego/pose, /ego/signals, /tf, /scene and /scene/road.

Rounded to millimetres and written through templates, because a viewer needs no more and 3,000 messages of nested
objects would cost more than the rest of the log.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import msgspec
import numpy as np
from numpy.typing import NDArray

from pytest_dvp.logs.log_contents import FloatArray, LogContents, ObjectTrack

PERIOD = 0.1  # s between two pictures
_HEIGHT = 1.4  # m, of an ego whose height the log does not tell
_COLORS = {"vehicle": (0.2, 0.4, 0.9), "pedestrian": (0.9, 0.5, 0.1), "bicycle": (0.5, 0.7, 0.1)}
_OTHER = (0.5, 0.5, 0.5)
_EGO = (0.1, 0.7, 0.3)
_LINE_COLORS = {"edge": (0.9, 0.9, 0.9), "lane": (0.7, 0.7, 0.7), "centre": (0.9, 0.8, 0.2)}

PLOTTED = ("v", "yaw_rate", "ax", "ay", "steer", "steer_cmd", "accel_cmd")
"""Columns of /ego/signals, one number a message: a viewer plots `/ego/signals.v` as it is, and blocks it cannot."""

_TIME = '{"sec":%d,"nsec":%d}'
_POSE = '{"position":{"x":%.3f,"y":%.3f,"z":%.3f},"orientation":{"x":0,"y":0,"z":%.6f,"w":%.6f}}'  # about z only
_POSE_MESSAGE = f'{{"timestamp":{_TIME},"frame_id":"map","pose":{_POSE}}}'
_TF_MESSAGE = (
    f'{{"transforms":[{{"timestamp":{_TIME},"parent_frame_id":"map","child_frame_id":"ego",'
    '"translation":{"x":%.3f,"y":%.3f,"z":%.3f},"rotation":{"x":0,"y":0,"z":%.6f,"w":%.6f}}]}'
)


def viewer_messages(log: LogContents) -> Iterator[tuple[int, str, bytes]]:
    """(log time [ns], topic, JSON) of all messages a viewer shows; none for a log without a pose."""
    if not len(log.t) or not {"x", "y", "yaw"} <= log.columns.keys():
        return
    yield from _road(log)
    rows = _picture_rows(log.t)
    t, x, y, yaw = (log.columns[name][rows] for name in ("t", "x", "y", "yaw"))
    z = log.columns["z"][rows] if "z" in log.columns else np.zeros(len(rows))
    z = np.where(np.isfinite(z), z, 0.0)
    usable = np.isfinite(t) & np.isfinite(x) & np.isfinite(y) & np.isfinite(yaw) & (t >= 0.0)
    t, x, y, z, yaw = t[usable], x[usable], y[usable], z[usable], yaw[usable]
    boxes = [_box(_track_at(track, t), name, track) for name, track in log.objects.items()]
    ego = _ego_box(log, x, y, z, yaw)
    nanoseconds = np.round(t * 1e9).astype(np.int64)
    plots = _plots(log, rows[usable])
    cells = zip(x.tolist(), y.tolist(), z.tolist(), np.sin(yaw / 2).tolist(), np.cos(yaw / 2).tolist(), strict=True)
    for i, (time, pose) in enumerate(zip(nanoseconds.tolist(), cells, strict=True)):
        stamp = divmod(time, 1_000_000_000)
        yield time, "/tf", (_TF_MESSAGE % (stamp + pose)).encode()
        yield time, "/ego/pose", (_POSE_MESSAGE % (stamp + pose)).encode()
        entities = [template % (stamp + row) for template, values in [ego, *boxes] if (row := values[i]) is not None]
        yield time, "/ego/signals", plots[i]
        yield time, "/scene", ('{"entities":[' + ",".join(entities) + "]}").encode()


def _plots(log: LogContents, rows: NDArray[np.intp]) -> list[bytes]:
    """JSON of /ego/signals for these rows; what was not measured is left out, as JSON has no number for it."""
    names = [name for name in PLOTTED if name in log.columns]
    values = np.stack([log.columns[name][rows] for name in names], axis=1) if names else np.zeros((len(rows), 0))
    keys = [f'"{name}":%.4f' for name in names]
    every = "{" + ",".join(keys) + "}"
    whole = np.logical_and.reduce(np.isfinite(values), axis=1)
    values += 0.0  # no "-0.0000" of a negative zero
    return [
        (every % tuple(row) if full else _some(keys, row)).encode()
        for row, full in zip(values.tolist(), whole.tolist(), strict=True)
    ]


def _some(keys: list[str], row: list[float]) -> str:
    return "{" + ",".join(key % value for key, value in zip(keys, row, strict=True) if math.isfinite(value)) + "}"


def _picture_rows(t: FloatArray) -> NDArray[np.intp]:
    step = float(np.median(np.diff(t))) if len(t) > 1 else PERIOD
    stride = max(1, round(PERIOD / step)) if step > 0 else 1
    return np.arange(0, len(t), stride, dtype=np.intp)


def _entity(name: str, size: tuple[float, float, float], color: tuple[float, float, float], alpha: float) -> str:
    """Template of a scene entity; `%` in a user's name is doubled because the result is formatted once more."""
    text = msgspec.json.encode(name).decode().replace("%", "%%")
    return (
        # Two periods of life: an object that leaves the run leaves the picture.
        f'{{"timestamp":{_TIME},"frame_id":"map","id":{text},"lifetime":{{"sec":0,"nsec":200000000}},'
        f'"frame_locked":false,"cubes":[{{"pose":{_POSE},'
        f'"size":{{"x":{size[0]:.3f},"y":{size[1]:.3f},"z":{size[2]:.3f}}},'
        f'"color":{{"r":{color[0]},"g":{color[1]},"b":{color[2]},"a":{alpha}}}}}]}}'
    )


_Rows = list[tuple[float, float, float, float, float] | None]


def _box(rows: _Rows, name: str, track: ObjectTrack) -> tuple[str, _Rows]:
    size = tuple(v if math.isfinite(v) and v > 0 else 0.5 for v in (track.length, track.width, track.height))
    return _entity(name, (size[0], size[1], size[2]), _COLORS.get(track.kind, _OTHER), 0.8), rows


def _track_at(track: ObjectTrack, t: FloatArray) -> _Rows:
    """Pose at the last sample not later than each picture; None before its first and after its last one."""
    if not len(track.t):
        return [None] * len(t)
    index = np.searchsorted(track.t, t + 1e-6, side="right") - 1
    there = (index >= 0) & (t <= track.t[-1] + PERIOD)
    index = np.clip(index, 0, None)
    x, y, z, yaw = (getattr(track, c)[index] for c in ("x", "y", "z", "yaw"))
    there &= np.isfinite(x) & np.isfinite(y) & np.isfinite(z) & np.isfinite(yaw)
    rows = zip(x.tolist(), y.tolist(), z.tolist(), np.sin(yaw / 2).tolist(), np.cos(yaw / 2).tolist(), strict=True)
    return [row if seen else None for row, seen in zip(rows, there.tolist(), strict=True)]


def _ego_box(log: LogContents, x: FloatArray, y: FloatArray, z: FloatArray, yaw: FloatArray) -> tuple[str, _Rows]:
    ego = log.meta.get("ego")
    size = ego if isinstance(ego, dict) else {}

    def number(key: str, default: float) -> float:
        value = size.get(key, default)
        return float(value) if isinstance(value, int | float) and math.isfinite(value) else default

    height, ahead = number("height", _HEIGHT), number("center_x", 0.0)
    template = _entity("ego", (number("length", 3.0), number("width", 1.5), height), _EGO, 0.9)
    middle_x, middle_y, middle_z = x + ahead * np.cos(yaw), y + ahead * np.sin(yaw), z + 0.5 * height
    rows = zip(
        middle_x.tolist(),
        middle_y.tolist(),
        middle_z.tolist(),
        np.sin(yaw / 2).tolist(),
        np.cos(yaw / 2).tolist(),
        strict=True,
    )
    return template, list(rows)


def _road(log: LogContents) -> Iterator[tuple[int, str, bytes]]:
    still = {"position": {"x": 0, "y": 0, "z": 0}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}
    lines = []
    for line in log.road:
        points = np.round(np.asarray(line["points"], dtype=float), 3)
        r, g, b = _LINE_COLORS.get(str(line["kind"]), _OTHER)
        lines.append(
            {
                "type": 0,
                "pose": still,
                "thickness": 0.1,
                "scale_invariant": False,
                "points": [{"x": p[0], "y": p[1], "z": 0} for p in points[np.isfinite(points).all(axis=1)].tolist()],
                "color": {"r": r, "g": g, "b": b, "a": 1},
            }
        )
    if lines:
        never = {"sec": 0, "nsec": 0}
        road = {"timestamp": never, "frame_id": "map", "id": "road", "lifetime": never, "frame_locked": False}
        yield 0, "/scene/road", msgspec.json.encode({"entities": [{**road, "lines": lines}]})
