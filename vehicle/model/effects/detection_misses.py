"""Missed frames."""

from __future__ import annotations

from typing import Any

import numpy as np

from vehicle.model.effect import Key, effect
from vehicle.model.perception_effects import Tracks
from vehicle.model.shown_by import ShownBy


@effect(
    name="detection_misses",
    slot="perception",
    order=30,
    physics="a detector overlooks an object in some frames",
    equation="each row is lost with probability rate",
    source="Bernoulli drop-out",
    parameters=(
        Key("rate", "-", 0.0, 0.5, neutral=0.0, least=0.02, minimum=0.0, maximum=1.0, meaning="share of frames missed"),
    ),
    ties=("detection_range",),
    reveals="any object in view for 10 s",
    shown_by=ShownBy(40),
)
def detection_misses(tracks: Tracks, p: Any, rng: np.random.Generator) -> Tracks:
    return tracks.rows(rng.random(len(tracks.t)) >= p.rate)
