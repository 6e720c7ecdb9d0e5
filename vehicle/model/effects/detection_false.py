"""False objects."""

from __future__ import annotations

from typing import Any

import numpy as np

from vehicle.messages import OBJECT_KINDS
from vehicle.model.effect import Key, effect
from vehicle.model.perception_effects import TRACK_COLUMNS, Tracks
from vehicle.model.shown_by import ShownBy

REACH = 50.0  # m around the ego
STAYS = 1.0  # s that one stays while the twin drives: what is there for one look alone, no tracker believes
SIZE = (0.6, 0.6, 1.7)  # m, length, width and height of one: a pedestrian's


@effect(
    name="detection_false",
    slot="perception",
    order=40,
    physics="clutter is taken for objects",
    equation="Poisson process: rate false objects appear a second, evenly over a disc around the ego; one that stays "
    "counts once",
    source="Y. Bar-Shalom et al., Estimation with Applications to Tracking and Navigation (clutter model)",
    parameters=(
        Key(
            "rate",
            "1/s",
            0.0,
            0.5,
            neutral=0.0,
            least=0.02,
            minimum=0.0,
            maximum=1000.0,
            meaning="false objects that appear a second",
        ),
    ),
    reveals="an empty road for a minute",
    shown_by=ShownBy(50),
)
def detection_false(tracks: Tracks, p: Any, rng: np.random.Generator) -> Tracks:
    """Each false object lives for one stamp of the tracks; a track list without rows stays empty."""
    if not len(tracks.t):
        return tracks
    count = int(rng.poisson(p.rate * (tracks.t[-1] - tracks.t[0])))
    rows = rng.integers(0, len(tracks.t), count)
    bearing, distance = rng.uniform(-np.pi, np.pi, count), REACH * np.sqrt(rng.random(count))
    false = tracks.rows(rows)
    columns = {name: getattr(false, name) for name in TRACK_COLUMNS}
    columns |= {
        "object": np.full(count, -1),
        "x": false.ego_x + distance * np.cos(bearing),
        "y": false.ego_y + distance * np.sin(bearing),
        "vx": np.zeros(count),
        "vy": np.zeros(count),
        "length": np.full(count, SIZE[0]),
        "width": np.full(count, SIZE[1]),
        "kind": np.full(count, OBJECT_KINDS.index("pedestrian")),
    }
    both = {name: np.concatenate((getattr(tracks, name), columns[name])) for name in TRACK_COLUMNS}
    return Tracks(**both).rows(np.argsort(both["t"], kind="stable"))
