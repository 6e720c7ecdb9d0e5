"""Road users of the tests' own, and a perception that sees them as they are."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from ads_loop import Car

from ads.localization import Estimate
from vehicle.messages import Detection, Observation


@dataclass
class Actor:
    """A box that moves straight from `start` [s] on, for `reach` [m]."""

    kind: str
    x: float
    y: float
    yaw: float
    length: float
    width: float
    speed: float = 0.0
    start: float = 0.0
    reach: float = math.inf

    def at(self, t: float) -> tuple[float, float]:
        d = min(self.speed * max(t - self.start, 0.0), self.reach)
        return self.x + d * math.cos(self.yaw), self.y + d * math.sin(self.yaw)

    def pace(self, t: float) -> float:
        """Speed [m/s] at `t` [s]."""
        return self.speed if 0.0 <= (t - self.start) * self.speed < self.reach else 0.0

    def corners(self, t: float) -> np.ndarray:
        return corners(*self.at(t), self.yaw, self.length, self.width)


def parked(x: float, y: float = -1.75, yaw: float = 0.0) -> Actor:
    return Actor("vehicle", x, y, yaw, 4.4, 1.8)


def corners(x: float, y: float, yaw: float, length: float, width: float) -> np.ndarray:
    c, s = math.cos(yaw), math.sin(yaw)
    local = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)]) * (length / 2, width / 2)
    return np.array([x, y]) + local @ np.array([[c, s], [-s, c]])


def separation(a: np.ndarray, b: np.ndarray) -> float:
    """Smallest distance [m] between two convex outlines that do not cross; 0 or less if they overlap."""
    best = -math.inf
    for p in (a, b):
        for i in range(len(p)):
            edge = p[(i + 1) % len(p)] - p[i]
            normal = np.array([edge[1], -edge[0]]) / np.linalg.norm(edge)
            qa, qb = a @ normal, b @ normal
            best = max(best, qa.min() - qb.max(), qb.min() - qa.max())
    return best


def time_to_contact(a: np.ndarray, b: np.ndarray, velocity: np.ndarray) -> float:
    """Time [s] until outline `a`, moving at `velocity` [m/s] past `b`, first touches it: slabs over all normals."""
    enter, leave = 1e-6, math.inf
    for p in (a, b):
        for i in range(2):
            edge = p[i + 1] - p[i]
            normal = np.array([edge[1], -edge[0]]) / np.linalg.norm(edge)
            qa, qb, v = a @ normal, b @ normal, float(velocity @ normal)
            ahead, behind = qb.min() - qa.max(), qb.max() - qa.min()
            if abs(v) < 1e-9:
                if ahead > 0.0 or behind < 0.0:
                    return math.inf
                continue
            t0, t1 = sorted((ahead / v, behind / v))
            enter, leave = max(enter, t0), min(leave, t1)
    return enter if enter <= leave else math.inf


class SeeingAll:
    """Perception without error up to `reach` [m]."""

    def __init__(self, actors: list[Actor], reach: float = 60.0) -> None:
        self.actors = actors
        self.reach = reach

    def update(self, observation: Observation, estimate: Estimate) -> tuple[Detection, ...]:
        t, found = observation.t, []
        for i, a in enumerate(self.actors):
            x, y = a.at(t)
            if math.hypot(x - estimate.x, y - estimate.y) < self.reach:
                v = a.pace(t)
                found.append(
                    Detection(
                        t,
                        a.kind,
                        x,
                        y,
                        a.yaw,
                        a.length,
                        a.width,
                        v * math.cos(a.yaw),
                        v * math.sin(a.yaw),
                        track=i,  # type: ignore[arg-type]
                    )
                )
        return tuple(found)


class Watch:
    """Notes the least distance to any actor and the largest inverse time to collision (straight on, 5 cm steps)."""

    def __init__(self, actors: list[Actor]) -> None:
        self.actors = actors
        self.least = math.inf
        self.inverse_ttc = 0.0
        self.when = 0.0

    def __call__(self, t: float, car: Car) -> None:
        d = car.description
        x, y = car.x + d.center_x * math.cos(car.yaw), car.y + d.center_x * math.sin(car.yaw)
        own = corners(x, y, car.yaw, d.length, d.width)
        for a in self.actors:
            other = a.corners(t)
            gap = separation(own, other)
            self.least = min(self.least, gap)
            v = a.pace(t)
            relative = np.array(
                [car.v * math.cos(car.yaw) - v * math.cos(a.yaw), car.v * math.sin(car.yaw) - v * math.sin(a.yaw)]
            )
            ttc = time_to_contact(own, other, relative)
            if 1.0 / ttc > self.inverse_ttc:
                self.inverse_ttc, self.when = 1.0 / ttc, t


Sense = Callable[[float, Car], dict[str, object]]
