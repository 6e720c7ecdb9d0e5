"""Channels of the MCAP record and their JSON schemas.

/ego/pose, /tf and /scene follow the public Foxglove message schemas (foxglove.PoseInFrame, FrameTransforms,
SceneUpdate; field names as documented there), so that a viewer shows them without configuration. The other channels are
ours; they hold the log exactly. Columns travel in blocks of about a second: a list, or one number where the block is
constant; null is NaN, "inf" and "-inf" are words because JSON has no number for them. /ego/signals repeats the main
ones of them at 10 Hz as a viewer plots them.
"""

from __future__ import annotations

from typing import Any, Final

import msgspec

from pytest_dvp.logs.signals import describe
from pytest_dvp.logs.viewer_channels import PLOTTED

FORMAT: Final = 1
"""Version of the layout; raised when an older reader could no longer understand a file."""


def _object(title: str = "", /, **properties: Any) -> dict[str, Any]:
    return {**({"title": title} if title else {}), "type": "object", "properties": properties}


def _list(items: dict[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": items}


_NUMBER = {"type": "number"}
_INTEGER = {"type": "integer"}
_TEXT = {"type": "string"}
_XYZ = {"x": _NUMBER, "y": _NUMBER, "z": _NUMBER}
_TIME = _object("time", sec=_INTEGER, nsec=_INTEGER)
_DURATION = _object("duration", sec=_INTEGER, nsec=_INTEGER)
_VECTOR = _object("foxglove.Vector3", **_XYZ)
_POINT = _object("foxglove.Point3", **_XYZ)
_QUATERNION = _object("foxglove.Quaternion", **_XYZ, w=_NUMBER)
_POSE = _object("foxglove.Pose", position=_VECTOR, orientation=_QUATERNION)
_COLOR = _object("foxglove.Color", r=_NUMBER, g=_NUMBER, b=_NUMBER, a=_NUMBER)
_CUBE = _object("foxglove.CubePrimitive", pose=_POSE, size=_VECTOR, color=_COLOR)
_LINE = _object(
    "foxglove.LinePrimitive",
    type=_INTEGER,
    pose=_POSE,
    thickness=_NUMBER,
    scale_invariant={"type": "boolean"},
    points=_list(_POINT),
    color=_COLOR,
)
_ENTITY = _object(
    "foxglove.SceneEntity",
    timestamp=_TIME,
    frame_id=_TEXT,
    id=_TEXT,
    lifetime=_DURATION,
    frame_locked={"type": "boolean"},
    cubes=_list(_CUBE),
    lines=_list(_LINE),
)
_POSE_IN_FRAME = _object("foxglove.PoseInFrame", timestamp=_TIME, frame_id=_TEXT, pose=_POSE)
_TRANSFORM = _object(
    "foxglove.FrameTransform",
    timestamp=_TIME,
    parent_frame_id=_TEXT,
    child_frame_id=_TEXT,
    translation=_VECTOR,
    rotation=_QUATERNION,
)
_TRANSFORMS = _object("foxglove.FrameTransforms", transforms=_list(_TRANSFORM))
_SCENE = _object("foxglove.SceneUpdate", entities=_list(_ENTITY))

_CELL = {"type": ["number", "null", "string"]}
_COLUMN: dict[str, Any] = {"type": ["array", "number", "null", "string"], "items": _CELL}
_POINTS = _list(_list(_CELL))
_COLUMNS: dict[str, Any] = {"type": "object", "additionalProperties": _COLUMN}
_BLOCK = {"row": {**_INTEGER, "description": "row of the log at which the block begins"}, "count": _INTEGER}


def _columns(names: tuple[str, ...] | list[str]) -> dict[str, Any]:
    signals = [describe(name) for name in names]
    told = {s.name: {**_COLUMN, "description": f"[{s.unit}] {s.frame} {s.meaning}".replace("  ", " ")} for s in signals}
    return {"type": "object", "properties": told}


def schemas(columns: list[str]) -> dict[str, tuple[str, bytes]]:
    """Schema name and JSON schema of each channel, by topic, for a log with these columns."""
    told = _columns(columns)
    held = {**_BLOCK, "held": {**_list(_INTEGER), "description": "offsets in the block at which a value changes"}}
    ours = {
        "/meta": _object(
            format=_INTEGER,
            rows=_INTEGER,
            columns=_list(_object(name=_TEXT, unit=_TEXT, frame=_TEXT)),
            objects=_list(_object(name=_TEXT, kind=_TEXT, length=_NUMBER, width=_NUMBER, height=_NUMBER)),
            meta={"type": "object"},
        ),
        "/road": _object(lines=_list(_object(kind=_TEXT, points=_POINTS))),
        "/reference": _object(points=_POINTS),
        "/signals": _object(**_BLOCK, columns=told),
        "/commands": _object(**held, columns=told),
        "/ads": _object(**held, columns=told),
        "/objects": _object(name=_TEXT, count=_INTEGER, columns=_COLUMNS),
        "/detections": _object(count=_INTEGER, kind=_list(_TEXT), columns=_COLUMNS),
        "/path": _object(t=_CELL, points=_POINTS),
        "/events": _object(
            t=_CELL, kind=_TEXT, element=_TEXT, text=_TEXT, file=_TEXT, line={"type": ["integer", "null"]}
        ),
    }
    plotted = {s.name: {**_NUMBER, "description": f"[{s.unit}] {s.meaning}"} for s in map(describe, PLOTTED)}
    signals = _object("dvp.ego_signals", **plotted)
    viewer = {
        "/tf": _TRANSFORMS,
        "/ego/pose": _POSE_IN_FRAME,
        "/ego/signals": signals,
        "/scene": _SCENE,
        "/scene/road": _SCENE,
    }
    result = {topic: (f"dvp.{topic[1:]}", msgspec.json.encode(schema)) for topic, schema in ours.items()}
    result.update((topic, (schema["title"], msgspec.json.encode(schema))) for topic, schema in viewer.items())
    return result
