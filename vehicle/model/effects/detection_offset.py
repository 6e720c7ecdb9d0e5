"""Offset of detections."""

from __future__ import annotations

from typing import Any

import numpy as np

from vehicle.model.diagnosed import Diagnosed
from vehicle.model.effect import Key, effect
from vehicle.model.perception_effects import Tracks
from vehicle.model.shown_by import ShownBy


@effect(
    name="detection_offset",
    slot="perception",
    order=20,
    physics="the sensor is mounted elsewhere, or turned, than its calibration says",
    equation="object = true object + (x, y) in the ego frame",
    source="rigid transform",
    parameters=(
        Key("x", "m", -1.0, 1.0, neutral=0.0, least=0.05, minimum=-20.0, maximum=20.0, meaning="forward"),
        Key("y", "m", -1.0, 1.0, neutral=0.0, least=0.05, minimum=-20.0, maximum=20.0, meaning="to the left"),
    ),
    ties=(
        "detection_latency",
        "gnss_lever_arm",
    ),
    reveals="a parked object passed at walking speed",
    shown_by=ShownBy(20),
    diagnosed=Diagnosed(hides_in=(("CAMERA_x", 10),)),
)
def detection_offset(tracks: Tracks, p: Any, rng: np.random.Generator) -> Tracks:
    return tracks.moved(p.x, p.y)
