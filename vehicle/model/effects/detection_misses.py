"""Missed frames."""

from __future__ import annotations

from typing import Any

import numpy as np

from vehicle.messages import OBJECT_KINDS
from vehicle.model.effect import Key, effect
from vehicle.model.perception_effects import Tracks
from vehicle.model.shown_by import ShownBy


@effect(
    name="detection_misses",
    slot="perception",
    order=30,
    physics="a detector overlooks an object in some frames",
    equation="each row is lost with probability rate + slope distance + what its class adds",
    source="Bernoulli drop-out; by distance and class: A. Geiger et al., KITTI, CVPR 2012",
    parameters=(
        Key("rate", "-", 0.0, 0.5, neutral=0.0, least=0.02, minimum=0.0, maximum=1.0, meaning="share of frames missed"),
        Key("slope", "1/m", 0.0, 0.02, neutral=0.0, least=0.002, minimum=0.0, maximum=1.0, meaning="more per metre"),
        Key("pedestrian", "-", 0.0, 0.5, neutral=0.0, least=0.05, minimum=0.0, maximum=1.0, meaning="pedestrians more"),
        Key("bicycle", "-", 0.0, 0.5, neutral=0.0, least=0.05, minimum=0.0, maximum=1.0, meaning="bicycles more"),
    ),
    ties=("detection_range",),
    reveals="any object in view for 10 s",
    shown_by=ShownBy(40),
)
def detection_misses(tracks: Tracks, p: Any, rng: np.random.Generator) -> Tracks:
    share = p.rate + p.slope * tracks.distance()
    for kind in ("pedestrian", "bicycle"):
        share = share + np.where(tracks.kind == OBJECT_KINDS.index(kind), getattr(p, kind), 0.0)
    return tracks.rows(rng.random(len(tracks.t)) >= share)
