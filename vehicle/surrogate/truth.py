"""The truth of a drive, for grading: a file of its own that nobody reads while the car drives.

It is a log in the layout of the harness's logs (`/meta`, `/signals`, `/objects`), so that what reads these reads it.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from mcap.writer import CompressionType, Writer

from vehicle.messages import OBJECT_KINDS, TRACE_COLUMNS, Surroundings, VehicleState

FORMAT = 1  # of the harness's logs
BLOCK = 100  # rows
_UNITS = ("s", "m", "m", "m", "rad", "m/s", "m/s", "m/s", "rad/s", "m/s^2", "m/s^2", "rad")  # of TRACE_COLUMNS
_PLACE = ("x", "y", "z", "yaw")  # the first columns of the boxes of Surroundings


class Truth:
    """What was true of a drive: motion of the car, and the road users around it as they were."""

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self.clear()

    def clear(self) -> None:
        """Forget everything: a drive begins anew."""
        self._rows: list[tuple[float, ...]] = []
        self._tracks: dict[str, list[tuple[float, ...]]] = {}
        self._about: dict[str, dict[str, Any]] = {}

    def car(self, state: VehicleState) -> None:
        """The true motion [SI] at `state.t`."""
        self._rows.append(tuple(float(getattr(state, name)) for name in TRACE_COLUMNS))

    def around(self, t: float, around: Surroundings) -> None:
        """The road users as they are at `t` [s]."""
        for name, kind, box in zip(around.names, around.kinds.tolist(), around.boxes.tolist(), strict=True):
            size = dict(zip(("length", "width", "height"), box[4:7], strict=True))
            self._about.setdefault(name, {"name": name, "kind": OBJECT_KINDS[kind], **size})
            self._tracks.setdefault(name, []).append((t, *box[:4]))

    def write(self, path: Path) -> None:
        """Write the file, whole. Raises OSError."""
        stream = io.BytesIO()
        writer = Writer(stream, compression=CompressionType.LZ4)
        writer.start(profile="", library="truth of the surrogate")
        channels: dict[str, int] = {}
        for number, (topic, at, content) in enumerate(self._messages()):
            if topic not in channels:
                schema = writer.register_schema(f"dvp.{topic[1:]}", "jsonschema", b'{"type": "object"}')
                channels[topic] = writer.register_channel(topic, "json", schema)
            stamp = max(0, round(at * 1e9))
            writer.add_message(channels[topic], stamp, msgspec.json.encode(content), stamp, number)
        writer.finish()  # type: ignore[no-untyped-call]
        part = path.with_name(f"{path.name}.part")
        part.write_bytes(stream.getvalue())
        part.replace(path)

    def _messages(self) -> list[tuple[str, float, dict[str, Any]]]:
        columns = [{"name": n, "unit": u, "frame": ""} for n, u in zip(TRACE_COLUMNS, _UNITS, strict=True)]
        meta = {"stage": "truth", "seed": self._seed, "vehicle": {"name": "surrogate"}}
        head = {"format": FORMAT, "rows": len(self._rows), "columns": columns,
                "objects": list(self._about.values()), "meta": meta}  # fmt: skip
        found: list[tuple[str, float, dict[str, Any]]] = [
            ("/meta", 0.0, head), ("/road", 0.0, {"lines": []}), ("/reference", 0.0, {"points": []}),
        ]  # fmt: skip
        rows = np.array(self._rows).reshape(-1, len(TRACE_COLUMNS))
        for a in range(0, len(rows), BLOCK):
            block = rows[a : a + BLOCK]
            table = {name: block[:, i].tolist() for i, name in enumerate(TRACE_COLUMNS)}
            found.append(("/signals", float(block[0, 0]), {"row": a, "count": len(block), "columns": table}))
        for name, track in self._tracks.items():
            whole = np.array(track)
            at = whole[:, 0]
            table = {column: whole[:, i].tolist() for i, column in enumerate(("t", *_PLACE))}
            for column, place in (("vx", whole[:, 1]), ("vy", whole[:, 2])):  # velocities do not travel on the wire
                table[column] = (np.gradient(place, at) if len(at) > 1 else 0.0 * at).tolist()
            found.append(("/objects", float(whole[0, 0]), {"name": name, "count": len(whole), "columns": table}))
        return sorted(found, key=lambda message: message[1])
