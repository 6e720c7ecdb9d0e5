"""Junctions: whether somebody goes first, how long a gap is, where to wait."""

from __future__ import annotations

import math

import numpy as np

from ads.control.speed_profile import stopping_distance
from ads.control.spline import SPEED, S
from ads.planning.memory import TrackMemory
from ads.planning.navigator import Navigator
from ads.planning.right_of_way import Priority, Way, priority_of
from vehicle.messages import Detection, FloatArray, VehicleDescription

NEAR = 30.0  # m before the junction from where on the car looks
LOOK_SPEED = 4.0  # m/s at a yield sign, so that there is time to look
GAP = 1.0  # m between the bumper and what others drive over
LINE_GAP = 0.5  # m between the bumper and the line at a stop sign
BESIDE = 1.8  # m beside the middle of a way that an object is on it
ALONG = 0.5  # cosine; an object that moves more across a way than this does not drive along it
MOVING = 0.8  # m/s
WAITS_TOO = 2.0  # s; who stood so long lets others go
AFTER = 1.5  # s between our leaving the way and the other's coming
BEFORE = 0.8  # s between the other's leaving and our coming
FREE_FOR = 0.4  # s until the way counts as free
ACCELERATION = 0.8  # m/s^2 of setting off
SET_OFF = 0.6  # s until the car moves
STANDS = 0.1  # m/s
AT_LINE = 3.0  # m; standing so near to it, the car has stopped at the sign


class JunctionRule:
    """Knows the next junction with somebody who goes first; remembers where it waits for him."""

    def __init__(self, car: VehicleDescription) -> None:
        self._car = car
        self._front = car.center_x + 0.5 * car.length
        self._rear = 0.5 * car.length - car.center_x
        self._known: dict[int, Priority | None] = {}
        self._monitor: object = None
        self._seen = -math.inf
        self._stopped = False
        self._stop_s: float | None = None
        self.priority: Priority | None = None
        self.passing: frozenset[int] = frozenset()  # tracks that drive on a way that goes first: no leads of ours

    def update(
        self, t: float, s: float, v: float, navigator: Navigator, detections: tuple[Detection, ...], memory: TrackMemory
    ) -> tuple[bool, bool]:
        """Whether such a junction is near, and whether the car is to wait before it."""
        before = self.priority
        self.priority = here = self._next(s, navigator)
        if here is None or before is None or here.line != before.line:
            self._stopped, self._stop_s, self._seen = False, None, -math.inf
        if here is None or s + self._front > here.first:  # on the others' way there is no waiting
            self._stop_s, self.passing = None, frozenset()
            return here is not None, False
        wait = here.line - self._front - LINE_GAP if here.sign else here.first - self._front - GAP
        if v < STANDS and abs(wait - s) < AT_LINE:
            self._stopped = True
        assert navigator.path is not None
        if self._taken(t, s, v, here, navigator.path, detections, memory):
            self._seen = t
        yields = t - self._seen < FREE_FOR or (here.sign == "stop" and not self._stopped)
        if not yields:
            self._stop_s = None
        elif self._stop_s is None:
            soonest = s + stopping_distance(v, 1.5) + 0.3 * v
            self._stop_s = min(max(wait, soonest), here.first - self._front - 0.3)
        return True, yields

    def limits(self, s: float, stop: bool) -> list[tuple[float, float]]:
        """Limits (distance [m], speed [m/s]) for the junction ahead; `stop` if the net says so."""
        here = self.priority
        if here is None:
            return []
        found = []
        if here.sign and s < here.line:
            found.append((here.line - self._front - s, LOOK_SPEED))
        if stop and self._stop_s is not None:
            found.append((self._stop_s - s, 0.0))
        return found

    def _next(self, s: float, navigator: Navigator) -> Priority | None:
        monitor, path = navigator.monitor, navigator.path
        if monitor is None or path is None:
            return None
        if monitor is not self._monitor:
            self._monitor = monitor
            self._known.clear()
        spans = monitor.spans
        for i in range(1, len(spans)):
            span = spans[i]
            if not span.junction or spans[i - 1].junction or span.s_to < s:
                continue
            if span.s_from > s + NEAR:
                return None
            if i not in self._known:
                self._known[i] = priority_of(navigator.network, spans[i - 1], span, path, monitor.side)
            found = self._known[i]
            return found if found is not None and s < found.last else None
        return None

    def _taken(
        self, t: float, s: float, v: float, here: Priority, path: FloatArray, detections: tuple[Detection, ...],
        memory: TrackMemory,
    ) -> bool:  # fmt: skip
        """Whether somebody who goes first comes before the car has gone by."""
        speed = self._speed(here, path)
        leaves = self._time_to(here.last + self._rear - s, v, speed)
        comes = self._time_to(here.first - self._front - s, v, max(v, speed))  # at the earliest
        taken, passing = False, set()
        for d in detections:
            if d.kind not in ("vehicle", "bicycle", "misc"):
                continue
            for way in here.ways:
                span = _on_way(way, d)
                if span is None:
                    continue
                rear, front, pace = span
                if front < way.first - 0.5 and pace < MOVING and memory.stood(t, d.track) > WAITS_TOO:
                    continue
                if rear > way.last:
                    continue
                if pace > MOVING:
                    passing.add(d.track)
                pace = max(pace, 0.1)
                his_coming, his_leaving = (way.first - front) / pace, (way.last - rear) / pace
                taken = taken or (his_coming < leaves + AFTER and his_leaving > comes - BEFORE)
        self.passing = frozenset(passing)
        return taken

    def _speed(self, here: Priority, path: FloatArray) -> float:
        i, j = np.searchsorted(path[:, S], (here.first, here.last))
        return max(float(path[i : j + 1, SPEED].min()), 1.0)

    @staticmethod
    def _time_to(distance: float, v: float, speed: float) -> float:
        """Time [s] to drive a distance [m] from `v` [m/s] on, at most at `speed` [m/s]."""
        if distance <= 0.0:
            return 0.0
        late = SET_OFF if v < 0.5 else 0.0
        if v >= speed:
            return distance / speed
        ramp = (speed * speed - v * v) / (2.0 * ACCELERATION)
        if distance < ramp:
            return late + (math.sqrt(v * v + 2.0 * ACCELERATION * distance) - v) / ACCELERATION
        return late + (speed - v) / ACCELERATION + (distance - ramp) / speed


def _on_way(way: Way, d: Detection) -> tuple[float, float, float] | None:
    """Rear and front of an object along a way [m], and its speed along it [m/s]; None if it is not on it."""
    line = way.line
    i = int(np.argmin((line[:, 0] - d.x) ** 2 + (line[:, 1] - d.y) ** 2))
    c, s = math.cos(line[i, 2]), math.sin(line[i, 2])
    dx, dy = d.x - line[i, 0], d.y - line[i, 1]
    if abs(dy * c - dx * s) > BESIDE or abs(dx * c + dy * s) > d.length:
        return None
    speed = math.hypot(d.vx, d.vy)
    along = d.vx * c + d.vy * s
    if speed > MOVING and along < ALONG * speed:
        return None
    middle = float(line[i, 3]) + dx * c + dy * s
    return middle - 0.5 * d.length, middle + 0.5 * d.length, max(along, 0.0)
