"""Small MCAP files made with the reference writer."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import CompressionType, Writer


def write_json(
    path: Path,
    topics: dict[str, list[tuple[float, dict[str, Any]]]],
    *,
    schema: str = "their.State",
    properties: dict[str, Any] | None = None,
    compression: CompressionType = CompressionType.ZSTD,
    chunk_size: int = 4096,
) -> Path:
    """Topics with (log time [s], message) each."""
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=chunk_size, compression=compression)
        writer.start()
        text = json.dumps({"type": "object", "properties": properties or {}}).encode()
        kind = writer.register_schema(schema, "jsonschema", text)
        channels = {topic: writer.register_channel(topic, "json", kind) for topic in topics}
        merged = sorted(((t, topic, m) for topic, rows in topics.items() for t, m in rows), key=lambda row: row[0])
        for t, topic, message in merged:
            writer.add_message(channels[topic], round(t * 1e9), json.dumps(message).encode(), round(t * 1e9))
        writer.finish()
    return path


def states(seconds: float = 8.0, rate: float = 50.0) -> list[tuple[float, dict[str, Any]]]:
    t = np.arange(round(seconds * rate)) / rate
    return [(float(s), {"speed": 36.0 + float(s), "pose": {"x": 10.0 * float(s), "y": 0.0}}) for s in t]
