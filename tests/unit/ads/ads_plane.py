"""A small map of the tests' own: roads made of lines and arcs, a lane to each side, right-hand traffic."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

WIDTH = 3.5


class Pose(NamedTuple):
    x: float
    y: float
    z: float
    h: float


class Place(NamedTuple):
    road: str
    lane: int
    s: float
    t: float
    offset: float
    h_road: float
    on_road: bool


class Zebra(NamedTuple):
    id: str
    road: str
    s: float
    outline: np.ndarray
    s_from: float
    s_to: float


class Lamp(NamedTuple):
    id: str
    road: str
    s: float
    orientation: str = "none"
    validity: tuple[tuple[int, int], ...] = ()


class Leg(NamedTuple):
    road: str
    lane: int
    s_from: float
    s_to: float


@dataclass(frozen=True)
class Road:
    length: float
    junction: str = "-1"


@dataclass
class PlaneMap:
    """One road "1" of pieces (length, curvature), starting at the origin along x; lanes -1 and 1."""

    pieces: list[tuple[float, float]]
    crosswalk_at: float | None = None
    crosswalk_t: tuple[float, float] = (-4.0, 4.0)
    signal_at: float | None = None
    step: float = 0.25
    rule: str = "RHT"
    table: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        rows = [(0.0, 0.0, 0.0, 0.0)]
        x = y = h = s = 0.0
        for length, curvature in self.pieces:
            for _ in range(round(length / self.step)):
                middle = h + 0.5 * curvature * self.step
                x, y = x + self.step * math.cos(middle), y + self.step * math.sin(middle)
                h, s = h + curvature * self.step, s + self.step
                rows.append((s, x, y, h))
        self.table = np.array(rows)

    @property
    def roads(self) -> dict[str, Road]:
        return {"1": Road(float(self.table[-1, 0]))}

    @property
    def crosswalks(self) -> tuple[Zebra, ...]:
        if self.crosswalk_at is None:
            return ()
        s, (low, high) = self.crosswalk_at, self.crosswalk_t
        corners = [self.at(s + ds, t) for ds, t in ((-1.5, low), (1.5, low), (1.5, high), (-1.5, high))]
        return (Zebra("zebra", "1", s, np.array([p[:2] for p in corners]), s - 1.5, s + 1.5),)

    @property
    def signals(self) -> tuple[Lamp, ...]:
        return () if self.signal_at is None else (Lamp("lamp", "1", self.signal_at),)

    def at(self, s: float, t: float) -> Pose:
        x, y, h = (float(np.interp(s, self.table[:, 0], self.table[:, k])) for k in (1, 2, 3))
        return Pose(x - t * math.sin(h), y + t * math.cos(h), 0.0, h)

    def lane_pose(self, road: str, lane: int, s: float, offset: float = 0.0) -> Pose:
        return self.at(s, math.copysign(WIDTH / 2, lane) + offset)

    def locate(self, x: float, y: float, h: float | None = None, hint: object = None) -> Place:
        i = int(np.argmin(np.hypot(self.table[:, 1] - x, self.table[:, 2] - y)))
        s, px, py, ph = (float(v) for v in self.table[i])
        t = -math.sin(ph) * (x - px) + math.cos(ph) * (y - py)
        lane = -1 if t < 0 else 1
        return Place("1", lane, s, t, t - math.copysign(WIDTH / 2, lane), ph, abs(t) < WIDTH)

    def lane_width(self, road: str, lane: int, s: float) -> float:
        return WIDTH

    def lane_type(self, road: str, lane: int, s: float) -> str:
        if lane not in (-1, 1):
            raise KeyError(lane)
        return "driving"

    def driving_sign(self, road: str, lane: int, s: float = 0.0) -> int:
        return 1 if lane < 0 else -1

    def advance(self, position: Place, ds: float) -> Place:
        s = position.s + ds * self.driving_sign("1", position.lane)
        return position._replace(s=min(max(s, 0.0), self.roads["1"].length))

    def dead_end(self, position: Place) -> bool:
        return position.s in (0.0, self.roads["1"].length)

    def route(self, start: tuple[str, int, float], goal: tuple[str, int, float]) -> tuple[Leg, ...]:
        return (Leg(start[0], start[1], start[2], goal[2]),)

    def centreline(self, route: object, step: float = 0.5) -> np.ndarray:
        rows = []
        for leg in route:  # type: ignore[attr-defined]
            n = max(round(abs(leg.s_to - leg.s_from) / step), 1)
            for s in np.linspace(leg.s_from, leg.s_to, n + 1):
                p = self.lane_pose(leg.road, leg.lane, float(s))
                rows.append((p.x, p.y, p.h if leg.lane < 0 else p.h + math.pi, 0.0))
        return np.array(rows)
