"""Range of the detector."""

from __future__ import annotations

from math import inf
from typing import Any

import numpy as np

from vehicle.model.effect import Key, effect
from vehicle.model.perception_effects import Tracks
from vehicle.model.shown_by import ShownBy


@effect(
    name="detection_range",
    slot="perception",
    order=5,
    physics="far objects give too few pixels or points",
    equation="shown while distance <= R",
    source="A. H. Lang et al., PointPillars, CVPR 2019 (range of the detection grid)",
    parameters=(Key("R", "m", 10.0, 80.0, neutral=inf, least=2.0, minimum=0.0, meaning="first seen at"),),
    ties=("detection_misses",),
    reveals="a slow approach to a parked object from 100 m",
    shown_by=ShownBy(30),
)
def detection_range(tracks: Tracks, p: Any, rng: np.random.Generator) -> Tracks:
    return tracks.rows(tracks.distance() <= p.R)
