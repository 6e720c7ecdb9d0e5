"""What the top view of a run report draws, as JSON-able numbers of a size a page can carry."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reports.figures import NET_PREFIX, event_label, is_shown, numbers, place_intervals
from reports.run_data import RunData

RATE = 20.0  # Hz, of the ego in the top view; boxes come at their own rate
PATH_PERIOD = 0.2  # s, least time between two planned paths that are shown
TURN = 0.04  # rad, and
STRIDE = 15.0  # m: a polyline is thinned to a point each, which leaves it within some mm of the original


def scene(run: RunData, ttc_inverse: Mapping[str, Any] | None, stride: int = 1) -> dict[str, Any]:
    """Ego, boxes, detections, paths, road and events; every `stride`-th sample of what moves (1 = all)."""
    columns, meta = run["columns"], run["meta"]
    ego = meta.get("ego") or {}
    return {
        "ego": {
            "name": str(ego.get("name", "Ego")),
            "length": float(ego.get("length", 4.0)),
            "width": float(ego.get("width", 1.8)),
            "center_x": float(ego.get("center_x", 1.3)),
            **_ego_track(columns, stride),
        },
        "ttc": None if not ttc_inverse else _series(ttc_inverse, stride),
        "objects": [_object(entry, stride) for entry in run["objects"]],
        "detections": _detections(run["detections"], stride),
        "paths": _paths(run["paths"], stride),
        "road": [{"kind": str(line["kind"]), "points": _points(line["points"])} for line in run["road"]],
        "events": [
            {"t": float(event["t"]), "kind": str(event["kind"]), "label": event_label(event)}
            for event in run["events"]
            if is_shown(event)
        ],
        "places": _places(columns),
    }


def _ego_track(columns: Mapping[str, NDArray[np.float64]], stride: int) -> dict[str, list[float | None]]:
    t = columns.get("t")
    if t is None or len(t) == 0:
        return {"t": []}
    step = float(np.median(np.diff(t))) if len(t) > 1 else 1.0
    every = max(1, round(1.0 / (RATE * step))) * stride if step > 0 else stride
    keep = np.unique(np.append(np.arange(0, len(t), every), len(t) - 1))
    wanted = {"t": 3, "x": 3, "y": 3, "yaw": 4, "v": 3, "steer": 4, "ax": 3, "ads.x": 3, "ads.y": 3, "ads.yaw": 4}
    return {name: numbers(columns[name][keep], digits) for name, digits in wanted.items() if name in columns}


def _series(series: Mapping[str, Any], stride: int) -> dict[str, list[float | None]]:
    return {"t": numbers(series["t"], 3)[::stride], "value": numbers(series["value"], 4)[::stride]}


def _object(entry: Mapping[str, Any], stride: int) -> dict[str, Any]:
    track = {name: numbers(np.asarray(entry[name])[::stride], 3) for name in ("t", "x", "y", "yaw")}
    size = {name: float(entry[name]) for name in ("length", "width")}
    return {"name": str(entry.get("name", "")), "kind": str(entry.get("kind", "misc")), **size, **track}


def _detections(table: Mapping[str, Any], stride: int) -> dict[str, Any]:
    """Grouped by time stamp: times, and the boxes of each as flat lists x, y, yaw, length, width."""
    if not table or len(table.get("t", ())) == 0:
        return {"t": [], "boxes": []}
    t = np.round(np.asarray(table["t"], dtype=np.float64), 3)
    fields = [np.asarray(table[name], dtype=np.float64) for name in ("x", "y", "yaw", "length", "width")]
    flat = np.round(np.stack(fields, axis=1), 3) + 0.0
    times, starts = np.unique(t, return_index=True)
    groups = np.split(flat, starts[1:]) if np.all(np.diff(t) >= 0) else [flat[t == time] for time in times]
    return {"t": times[::stride].tolist(), "boxes": [numbers(group.ravel(), 3) for group in groups[::stride]]}


def _paths(paths: Sequence[tuple[float, NDArray[np.float64]]], stride: int) -> dict[str, Any]:
    """Of each period the last plan, as that one may hold for long, and the very first."""
    kept = {
        0 if k == 0 else 1 + math.floor((t - paths[0][0]) / (PATH_PERIOD * stride) + 1e-9): (t, points)
        for k, (t, points) in enumerate(paths)
    }
    return {
        "t": [round(float(t), 3) for t, _ in kept.values()],
        "points": [_points(points) for _, points in kept.values()],
    }


def _points(points: ArrayLike, limit: int = 2000) -> list[list[float | None]]:
    array = np.asarray(points, dtype=np.float64)[:, :2]
    if len(array) > 2 and np.isfinite(array).all():
        step = np.diff(array, axis=0)
        turn = np.abs(np.diff(np.unwrap(np.arctan2(step[:, 1], step[:, 0]))))
        way = np.hypot(step[1:, 0], step[1:, 1])
        mark = np.floor(np.cumsum(turn / TURN + way / STRIDE))
        array = array[np.concatenate([[True], np.diff(mark, prepend=0.0) > 0, [True]])]
    if len(array) > limit:
        array = array[np.unique(np.linspace(0, len(array) - 1, limit).round().astype(int))]
    rounded: list[list[float | None]] = (np.round(array, 2) + 0.0).tolist()
    return rounded if np.isfinite(array).all() else [numbers(row, 2) for row in array]


def _places(columns: Mapping[str, NDArray[np.float64]]) -> list[list[Any]]:
    if not any(name.startswith(NET_PREFIX) for name in columns):
        return []
    return [[net, place, round(start, 3), round(end, 3)] for net, place, start, end in place_intervals(columns)]
