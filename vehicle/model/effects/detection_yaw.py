"""Yaw of detected boxes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from vehicle.model.effect import Key, effect
from vehicle.model.perception_effects import Tracks
from vehicle.model.shown_by import ShownBy


@effect(
    name="detection_yaw",
    slot="perception",
    order=14,
    physics="the axis of a box is fitted to the faces that are seen, which turns it to one side",
    equation="yaw = true yaw + b, about the middle of the box",
    source="H. Caesar et al., nuScenes, CVPR 2020 (average orientation error)",
    parameters=(
        Key("b", "rad", -0.3, 0.3, neutral=0.0, least=0.02, minimum=-1.6, maximum=1.6, meaning="turned to the left by"),
    ),
    ties=("heading_bias",),
    reveals="driving around a parked car, so that two of its sides are seen at once",
    shown_by=ShownBy(80),
)
def detection_yaw(tracks: Tracks, p: Any, rng: np.random.Generator) -> Tracks:
    return replace(tracks, yaw=tracks.yaw + p.b)
