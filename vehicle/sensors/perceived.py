"""What the LiDAR and the camera of a twin take for what is around: the perception effects of its model at work.

They act on the boxes before both look at them, so that both show the same, whatever stack then makes detections of it.
A neutral or missing effect leaves the boxes as they are, the same object. What a model hides from the camera alone is
told by name.
"""

from __future__ import annotations

import zlib
from collections import deque
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from vehicle.messages import FloatArray, Surroundings
from vehicle.model.effects.detection_false import REACH, SIZE, STAYS
from vehicle.model.occlusion import hidden_share
from vehicle.model.perception_effects import LOOKS_BACK, TRACK_COLUMNS, Tracks, perceive, perception_in

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import AppliedEffect

MEMORY = 5.0  # s of looks that are kept: the greatest age that detection_latency allows
FALSE = "detection_false"
OCCLUSION = "detection_occlusion"


class Perceived:
    """Changes what is around as perception effects say. Same effects, seed and looks: same answers.

    Each effect draws from a generator of its own, so that adding one does not shift the dice of another.
    """

    def __init__(self, effects: Iterable[AppliedEffect], seed: int = 0) -> None:
        every = perception_in(effects)
        self._ghosts = _FalseObjects(next((a for a in every if a.name == FALSE), None), seed)
        chosen = [a for a in every if a.name != FALSE]
        self._backward = [(a, _generator(a.name, seed)) for a in chosen if a.effect.order <= LOOKS_BACK]
        self._frame = [(a, _generator(a.name, seed)) for a in chosen if a.effect.order > LOOKS_BACK]
        self._past: deque[tuple[float, Tracks]] = deque()
        self._numbers: dict[str, int] = {}
        self._shown: dict[int, tuple[str, float, float]] = {}  # name, z and height [m] of each object by its number
        self.changes = bool(every)

    def seen(self, t: float, x: float, y: float, yaw: float, around: Surroundings, z: float = 0.0) -> Surroundings:
        """What stands for `around` at `t` [s], which grows; reference point at x, y, z [m] with `yaw` [rad] on the map.

        What is not there stands at the height of the car.
        """
        if not self.changes:
            return around
        now = self._look(t, x, y, yaw, around)
        if self._backward:
            now = self._remembered(t, now)
        unseen: frozenset[str] = frozenset()  # by the camera
        for applied, rng in self._frame:
            if applied.name == OCCLUSION and applied.values["lidar"] < 0.5:
                behind = now.object[hidden_share(now) > applied.values["share"]]
                unseen = frozenset(self._shown[number][0] for number in behind.tolist() if number in self._shown)
            now = perceive(applied, now, rng)
        hidden = around.hidden
        if unseen:
            hidden = {**hidden, "camera": hidden.get("camera", frozenset()) | unseen}
        boxes, kinds, names = self._boxes(now, z)
        for k, box in enumerate(self._ghosts.at(t, x, y, z)):
            boxes.append(box)
            kinds.append(1)
            names.append(f"false {k}")
        return Surroundings(
            np.array(boxes, dtype=np.float64).reshape(-1, 9),
            np.array(kinds, dtype=np.int64),
            tuple(names),
            around.signals,
            hidden,
            around.extinction,
            around.light,
        )

    def _look(self, t: float, x: float, y: float, yaw: float, around: Surroundings) -> Tracks:
        n, box = len(around.names), around.boxes
        numbers = [self._numbers.setdefault(name, len(self._numbers)) for name in around.names]
        for number, name, row in zip(numbers, around.names, box, strict=True):
            self._shown[number] = (name, float(row[2]), float(row[6]))
        return Tracks(
            t=np.full(n, t), object=np.array(numbers, dtype=np.int64), x=box[:, 0].copy(), y=box[:, 1].copy(),
            yaw=box[:, 3].copy(), vx=box[:, 7].copy(), vy=box[:, 8].copy(), ego_x=np.full(n, x), ego_y=np.full(n, y),
            ego_yaw=np.full(n, yaw), length=box[:, 4].copy(), width=box[:, 5].copy(), kind=around.kinds.copy(),
        )  # fmt: skip

    def _remembered(self, t: float, now: Tracks) -> Tracks:
        """What the effects that look back show at this look."""
        past = self._past
        past.append((t, now))
        while past[0][0] < t - MEMORY - 1e-9:
            past.popleft()
        every = Tracks(*(np.concatenate([getattr(look, name) for _, look in past]) for name in TRACK_COLUMNS))
        for applied, rng in self._backward:
            every = perceive(applied, every, rng)
        return every.rows(every.t >= t - 1e-9)

    def _boxes(self, now: Tracks, ground: float) -> tuple[list[FloatArray], list[int], list[str]]:
        boxes, kinds, names = [], [], []
        for k, number in enumerate(now.object.tolist()):
            name, z, height = self._shown.get(number, (f"false of an effect {k}", ground + 0.5 * SIZE[2], SIZE[2]))
            boxes.append(np.array([
                now.x[k], now.y[k], z, now.yaw[k], now.length[k], now.width[k], height, now.vx[k], now.vy[k]
            ]))  # fmt: skip
            kinds.append(int(now.kind[k]))
            names.append(name)
        return boxes, kinds, names


class _FalseObjects:
    """False objects, which appear as a Poisson process, evenly over a disc around the ego, and stand for STAYS."""

    def __init__(self, applied: AppliedEffect | None, seed: int) -> None:
        self._rate = applied.values["rate"] if applied else 0.0
        self._rng = _generator(FALSE, seed)
        self._there: list[tuple[float, FloatArray]] = []  # until when [s], box
        self._before: float | None = None

    def at(self, t: float, x: float, y: float, z: float) -> list[FloatArray]:
        """Boxes (9,) at `t` [s] around an ego at x, y, z [m]; a new one stands at its height."""
        if self._rate <= 0.0:
            return []
        passed = 0.0 if self._before is None else max(t - self._before, 0.0)
        self._before = t
        self._there = [(until, box) for until, box in self._there if until > t + 1e-9]
        for _ in range(int(self._rng.poisson(self._rate * passed))):
            bearing, distance = self._rng.uniform(-np.pi, np.pi), REACH * np.sqrt(self._rng.random())
            box = np.zeros(9)
            box[:3] = x + distance * np.cos(bearing), y + distance * np.sin(bearing), z + 0.5 * SIZE[2]
            box[4:7] = SIZE
            self._there.append((t + STAYS, box))
        return [box for _, box in self._there]


def _generator(name: str, seed: int) -> np.random.Generator:
    return np.random.default_rng([seed, zlib.crc32(name.encode())])
