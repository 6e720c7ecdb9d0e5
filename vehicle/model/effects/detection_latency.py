"""Age of detections."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from vehicle.model.effect import Key, effect
from vehicle.model.perception_effects import Tracks
from vehicle.model.shown_by import ShownBy


@effect(
    name="detection_latency",
    slot="perception",
    order=10,
    physics="images and scans are processed and passed on late",
    equation="object(t) = true object(t - T)",
    source="dead time of a processing chain",
    parameters=(Key("T", "s", 0.03, 0.5, neutral=0.0, least=0.02, minimum=0.0, maximum=5.0, meaning="age"),),
    ties=(
        "detection_offset",
        "gnss_latency",
    ),
    reveals="a crossing object at constant speed",
    shown_by=ShownBy(10),
)
def detection_latency(tracks: Tracks, p: Any, rng: np.random.Generator) -> Tracks:
    """Each object where it was T ago, straight between its stamps; nothing before it was first there."""
    kept = []
    shown = {name: np.array(getattr(tracks, name)) for name in ("x", "y", "yaw", "vx", "vy")}
    for number in np.unique(tracks.object):
        rows = np.flatnonzero(tracks.object == number)
        t = tracks.t[rows]
        kept.append(rows[t - p.T >= t[0]])
        for name, values in shown.items():
            own = np.unwrap(values[rows]) if name == "yaw" else values[rows]
            values[rows] = np.interp(t - p.T, t, own)
    return replace(tracks, **shown).rows(np.sort(np.concatenate(kept))) if kept else tracks
