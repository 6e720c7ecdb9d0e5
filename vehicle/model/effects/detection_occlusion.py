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
    physics="a detector does not find what is partly behind something else",
    equation="shown while at most `share` of the angle that the box fills is behind nearer boxes",
    source="M. Everingham et al., The PASCAL Visual Object Classes Challenge, IJCV 2010 (occluded objects)",
    parameters=(
        Key("share", "-", 0.1, 0.9, neutral=1.0, least=0.05, minimum=0.0, maximum=1.0, meaning="hidden at most"),
    ),
    ties=("detection_misses",),
    reveals="a pedestrian who comes out from behind a parked car",
    shown_by=ShownBy(90),
)
def detection_occlusion(tracks: Tracks, p: Any, rng: np.random.Generator) -> Tracks:
    return tracks.rows(hidden_share(tracks) <= p.share)
