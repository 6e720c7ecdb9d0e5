"""Size of detected boxes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from vehicle.model.effect import Key, effect
from vehicle.model.perception_effects import Tracks
from vehicle.model.shown_by import ShownBy


@effect(
    name="detection_size",
    slot="perception",
    order=12,
    physics="a detector sees objects blurred, or only in part, and takes them for larger or smaller ones",
    equation="length = length_ratio true length, width = width_ratio true width, about the middle of the box",
    source="H. Caesar et al., nuScenes, CVPR 2020 (average scale error)",
    parameters=(
        Key("length_ratio", "-", 0.7, 1.5, neutral=1.0, least=0.05, minimum=0.1, maximum=10.0, meaning="along the box"),
        Key("width_ratio", "-", 0.7, 1.5, neutral=1.0, least=0.05, minimum=0.1, maximum=10.0, meaning="across the box"),
    ),
    ties=("detection_offset",),
    reveals="driving around a parked car, so that all its sides are seen",
    shown_by=ShownBy(70),
)
def detection_size(tracks: Tracks, p: Any, rng: np.random.Generator) -> Tracks:
    return replace(tracks, length=tracks.length * p.length_ratio, width=tracks.width * p.width_ratio)
