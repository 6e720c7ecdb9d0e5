"""Object tracks as a perception would report them, with hidden perception effects.

The objects stand, walk and drive beside the ego of an urban log. Effects as in DIAGNOSIS: detection_latency (T),
detection_offset (x, y), detection_range (R), detection_misses (rate), detection_false (rate), detection_noise (sigma0,
slope).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tests.truth.car import PERIOD, SUBSTEPS, H
from tests.truth.effects import Effects, FloatArray
from tests.truth.generate import fine_truth

FRAME = 0.1  # s between two frames
# name -> kind, start x, y [m], velocity [m/s], begin of motion [s]
OBJECTS: dict[str, tuple[str, float, float, float, float, float]] = {
    "parked": ("vehicle", 52.0, 0.0, 0.0, 0.0, 0.0),
    "walker": ("pedestrian", 128.0, -6.0, 0.0, 1.75, 16.0),
    "oncoming": ("vehicle", 190.0, 3.6, -5.0, 0.0, 4.0),
    "cyclist": ("bicycle", 150.0, -2.0, 1.5, 0.0, 0.0),
}
KEYS = {
    "detection_latency": {"T": 0.0},
    "detection_offset": {"x": 0.0, "y": 0.0},
    "detection_range": {"R": math.inf},
    "detection_misses": {"rate": 0.0},
    "detection_false": {"rate": 0.0},
    "detection_noise": {"sigma0": 0.0, "slope": 0.0},
}
TYPICAL = {
    "detection_latency": {"T": 0.2},
    "detection_offset": {"x": 0.4, "y": -0.3},
    "detection_range": {"R": 35.0},
    "detection_misses": {"rate": 0.15},
    "detection_false": {"rate": 0.2},
    "detection_noise": {"sigma0": 0.1, "slope": 0.01},
}


@dataclass(frozen=True)
class Tracks:
    """`ego` (n, 4: t, x, y, yaw) at 50 Hz; `truth` by name: (k, 3: t, x, y) box centres at every frame;
    `detections` (m, 4: t, object, x, y) in map frame, object -1 for a false one, else its place in `names`."""

    ego: FloatArray
    names: tuple[str, ...]
    kinds: tuple[str, ...]
    truth: dict[str, FloatArray]
    detections: FloatArray


def place(name: str, t: float) -> tuple[float, float]:
    """Where an object truly is [m] at t [s]."""
    _, x, y, vx, vy, begin = OBJECTS[name]
    moved = max(t - begin, 0.0)
    return x + vx * moved, y + vy * moved


def make_tracks(effects: Effects, seed: int = 0) -> Tracks:
    """Ego, truth and detections of one urban drive; same arguments, same bytes. Raises ValueError on unknown names."""
    values = {name: dict(keys) for name, keys in KEYS.items()}
    for name, given in effects.items():
        if name not in values or set(given) - set(values[name]):
            raise ValueError(f"no perception effect {name!r} with keys {sorted(given)}; known: {KEYS}")
        values[name].update(given)
    old = values["detection_latency"]["T"]
    off_x, off_y = values["detection_offset"]["x"], values["detection_offset"]["y"]
    far = values["detection_range"]["R"]
    noise = values["detection_noise"]
    rng = np.random.default_rng([seed, 99])
    _, fine = fine_truth({}, "urban", seed)
    names = tuple(OBJECTS)
    truth: dict[str, list[tuple[float, float, float]]] = {name: [] for name in names}
    rows: list[tuple[float, float, float, float]] = []
    frames = round(len(fine) * H / FRAME)
    for j in range(frames):
        t = round(j * FRAME, 6)
        now = fine[j * round(FRAME / H)]
        for k, name in enumerate(names):
            truth[name].append((t, *place(name, t)))
            then = max(t - old, 0.0)
            x, y = place(name, then)
            seen_from = fine[round(then / H)]
            distance = math.hypot(x - seen_from[0], y - seen_from[1])
            sigma = noise["sigma0"] + noise["slope"] * distance
            white = (
                rng.normal(0.0, 1.0, 2) * sigma
            )  # drawn for unseen ones, too: effects do not shift each other's dice
            missed = rng.random() < values["detection_misses"]["rate"]
            if distance > far or missed:
                continue
            c, s = math.cos(seen_from[2]), math.sin(seen_from[2])
            rows.append((t, k, x + c * off_x - s * off_y + white[0], y + s * off_x + c * off_y + white[1]))
        for _ in range(rng.poisson(values["detection_false"]["rate"] * FRAME)):
            reach, angle = rng.uniform(4.0, min(far, 40.0)), rng.uniform(-0.6, 0.6) + now[2]
            rows.append((t, -1.0, now[0] + reach * math.cos(angle), now[1] + reach * math.sin(angle)))
    stamps = np.arange(len(fine) // SUBSTEPS) * PERIOD
    return Tracks(
        ego=np.column_stack([np.round(stamps, 6), fine[::SUBSTEPS, :3]]),
        names=names,
        kinds=tuple(OBJECTS[name][0] for name in names),
        truth={name: np.array(points) for name, points in truth.items()},
        detections=np.array(rows).reshape(-1, 4),
    )
