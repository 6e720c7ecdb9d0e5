"""Objects behind others."""

from __future__ import annotations

from typing import Any

import numpy as np

from vehicle.model.effect import Key, effect
from vehicle.model.occlusion import hidden_share
from vehicle.model.perception_effects import Tracks
from vehicle.model.shown_by import ShownBy


@effect(
    name="detection_occlusion",
    slot="perception",
    order=11,
    physics="a detector does not find what is partly behind something else; a LiDAR may still hit the rest",
    equation="shown while at most `share` of the angle that the box fills is behind nearer boxes; for lidar < 0.5 the "
    "LiDAR still sees it, and so do tracks that are not of the camera alone",
    source="M. Everingham et al., The PASCAL Visual Object Classes Challenge, IJCV 2010 (occluded objects)",
    parameters=(
        Key("share", "-", 0.1, 0.9, neutral=1.0, least=0.05, minimum=0.0, maximum=1.0, meaning="hidden at most"),
        Key("lidar", "-", 0.0, 1.0, neutral=1.0, least=0.5, minimum=0.0, maximum=1.0,
            meaning="1 if the LiDAR loses it as well, 0 if the camera alone does"),
    ),
    ties=("detection_misses",),
    reveals="a pedestrian who comes out from behind a parked car",
    shown_by=ShownBy(90),
)  # fmt: skip
def detection_occlusion(tracks: Tracks, p: Any, rng: np.random.Generator) -> Tracks:
    return tracks.rows(hidden_share(tracks) <= p.share) if p.lidar >= 0.5 else tracks
