"""Noise of positions."""

from __future__ import annotations

from typing import Any

import numpy as np

from vehicle.model.effect import Key, effect
from vehicle.model.perception_effects import Tracks
from vehicle.model.shown_by import ShownBy


@effect(
    name="detection_noise",
    slot="perception",
    order=50,
    physics="the position of an object is less sure the farther it is",
    equation="sigma = sigma0 + slope distance",
    source="sensor data sheets (angular resolution)",
    parameters=(
        Key("sigma0", "m", 0.0, 1.0, neutral=0.0, least=0.02, minimum=0.0, meaning="at the sensor"),
        Key("slope", "-", 0.0, 0.1, neutral=0.0, least=0.002, minimum=0.0, meaning="growth over distance"),
    ),
    reveals="parked objects at 5 to 60 m, in view for 10 s each",
    shown_by=ShownBy(60),
)
def detection_noise(tracks: Tracks, p: Any, rng: np.random.Generator) -> Tracks:
    sigma = p.sigma0 + p.slope * tracks.distance()
    noise = rng.standard_normal((2, len(tracks.t)))
    return tracks.moved(sigma * noise[0], sigma * noise[1])
