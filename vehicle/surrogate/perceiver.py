"""What the surrogate's detector makes of what is around: the hidden effects of perception, in a code of its own.

They act on the boxes before the LiDAR and the camera look at them, so that both show the same. One look every 0.1 s.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from vehicle.messages import OBJECT_KINDS, FloatArray, Surroundings
from vehicle.surrogate.hidden import PERCEPTION, Hidden

MEMORY = 5.0  # s of boxes that are kept; the greatest age
REACH = 40.0  # m around the car in which false objects appear
STAYS = 1.0  # s that one stays: what is there for one look alone, no tracker believes
FAN = 48  # directions in which an object's shadow is looked for
SIZE = (0.6, 0.6, 1.7)  # m, length, width, height of a false object: a pedestrian's


@dataclass(frozen=True)
class _Seen:
    t: float
    boxes: dict[str, FloatArray]


class Perceiver:
    """Changes what is around as the effects hidden in a car's perception say; without one it changes nothing.

    Same seed and looks, same answers; `t` [s] of the looks grows.
    """

    def __init__(self, hidden: Hidden, seed: int) -> None:
        self._rng = np.random.default_rng([seed, 2718])
        value = hidden.value
        self._age, self._range = value("detection_latency", "T"), value("detection_range", "R")
        self._offset = value("detection_offset", "x"), value("detection_offset", "y")
        self._missed, self._false = value("detection_misses", "rate"), value("detection_false", "rate")
        self._missed_far = value("detection_misses", "slope")
        self._missed_kind = {
            OBJECT_KINDS.index(name): value("detection_misses", name) for name in ("pedestrian", "bicycle")
        }
        self._size = value("detection_size", "length_ratio"), value("detection_size", "width_ratio")
        self._turn, self._hidden = value("detection_yaw", "b"), value("detection_occlusion", "share")
        self._noise = value("detection_noise", "sigma0"), value("detection_noise", "slope")
        self.changes = any(name in PERCEPTION for name in hidden.effects)
        self._before: deque[_Seen] = deque()
        self._ghosts: list[tuple[float, FloatArray]] = []  # until when, box
        self._looked: float | None = None

    def seen(self, t: float, x: float, y: float, yaw: float, around: Surroundings) -> Surroundings:
        """What the detector takes for what is around at `t` [s]; rear axle at x, y [m] with `yaw` [rad] on the map."""
        if not self.changes:
            return around
        shown, kinds, names = [], [], []
        c, s = math.cos(yaw), math.sin(yaw)
        now = _Seen(t, dict(zip(around.names, around.boxes, strict=True)))
        self._before.append(now)
        while self._before[0].t < t - MEMORY:
            self._before.popleft()
        then = {} if self._hidden >= 1.0 else self._all_ago(around.names, t - self._age)
        for name, kind in zip(around.names, around.kinds.tolist(), strict=True):
            # drawn for each object in each look, so that one effect does not shift the dice of another
            white, luck = self._rng.standard_normal(2), self._rng.random()
            box = self._ago(name, t - self._age)
            if box is None:
                continue
            distance = math.hypot(box[0] - x, box[1] - y)
            missed = self._missed + self._missed_far * distance + self._missed_kind.get(kind, 0.0)
            if distance > self._range or luck < missed:
                continue
            if then and _behind(box, [b for n, b in then.items() if n != name], x, y) > self._hidden:
                continue
            sigma = self._noise[0] + self._noise[1] * distance
            forward, left = self._offset[0] + sigma * white[0], self._offset[1] + sigma * white[1]
            box = box.copy()
            box[0] += forward * c - left * s
            box[1] += forward * s + left * c
            box[3] += self._turn
            box[4:6] *= self._size
            shown.append(box)
            kinds.append(kind)
            names.append(name)
        for number, box in enumerate(self._false_ones(t, x, y)):
            shown.append(box)
            kinds.append(OBJECT_KINDS.index("pedestrian"))
            names.append(f"false {number}")
        boxes = np.array(shown, dtype=np.float64).reshape(-1, 9)
        return Surroundings(boxes, np.array(kinds, dtype=np.int64), tuple(names), around.signals, around.hidden)

    def _all_ago(self, names: tuple[str, ...], then: float) -> dict[str, FloatArray]:
        """All boxes that were there at `then` [s]."""
        found = {name: self._ago(name, then) for name in names}
        return {name: box for name, box in found.items() if box is not None}

    def _ago(self, name: str, then: float) -> FloatArray | None:
        """A box as it was at `then` [s], straight between two looks; None of one that was not there yet."""
        later: _Seen | None = None
        for seen in reversed(self._before):
            if name not in seen.boxes:
                return None
            if seen.t <= then + 1e-9:
                box = seen.boxes[name]
                if later is None or later.t - seen.t < 1e-9:
                    return box
                share = (then - seen.t) / (later.t - seen.t)
                mixed: FloatArray = box + share * (later.boxes[name] - box)
                turn = math.remainder(float(later.boxes[name][3] - box[3]), 2.0 * math.pi)
                mixed[3] = box[3] + share * turn
                return mixed
            later = seen
        return None

    def _false_ones(self, t: float, x: float, y: float) -> list[FloatArray]:
        """False objects: they appear as a Poisson process, evenly over a disc around the car, and stand for a while."""
        passed = 0.0 if self._looked is None else t - self._looked
        self._looked = t
        self._ghosts = [(until, box) for until, box in self._ghosts if until > t + 1e-9]
        for _ in range(int(self._rng.poisson(self._false * max(passed, 0.0)))):
            bearing, distance = self._rng.uniform(-math.pi, math.pi), REACH * math.sqrt(self._rng.random())
            box = np.zeros(9)
            box[:3] = x + distance * math.cos(bearing), y + distance * math.sin(bearing), 0.5 * SIZE[2]
            box[4:7] = SIZE
            self._ghosts.append((t + STAYS, box))
        return [box for _, box in self._ghosts]


def _behind(box: FloatArray, others: list[FloatArray], x: float, y: float) -> float:
    """Share of a fan of rays from x, y [m] to the box that meets a box with a nearer middle first."""
    away = math.hypot(box[0] - x, box[1] - y)
    toward = math.atan2(box[1] - y, box[0] - x)
    edges = [math.remainder(angle - toward, 2.0 * math.pi) for angle in _corners(box, x, y)]
    fan = toward + min(edges) + (np.arange(FAN) + 0.5) / FAN * (max(edges) - min(edges))
    met = np.zeros(FAN, dtype=bool)
    for other in others:
        if math.hypot(other[0] - x, other[1] - y) < away:
            c, s = math.cos(other[3]), math.sin(other[3])
            px, py = x - other[0], y - other[1]
            origin = np.array([c * px + s * py, c * py - s * px])
            way = np.stack([np.cos(fan - other[3]), np.sin(fan - other[3])])
            half = 0.5 * other[4:6]
            with np.errstate(divide="ignore", invalid="ignore"):
                first = (-half - origin)[:, None] / way
                second = (half - origin)[:, None] / way
            near = np.nanmax(np.minimum(first, second), axis=0)
            far = np.nanmin(np.maximum(first, second), axis=0)
            met |= (near <= far) & (near > 0.0)
    return float(met.mean())


def _corners(box: FloatArray, x: float, y: float) -> list[float]:
    """Directions [rad] of the corners of a box from x, y [m]."""
    c, s = math.cos(box[3]), math.sin(box[3])
    ends = [(a * box[4], b * box[5]) for a in (-0.5, 0.5) for b in (-0.5, 0.5)]
    return [math.atan2(box[1] + s * u + c * v - y, box[0] + c * u - s * v - x) for u, v in ends]
