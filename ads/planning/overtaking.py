"""Overtaking: which obstacle, is there a gap, and the offset plan around it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ads.control.mpc import N, OffsetPlanner, offset_at, write_offsets
from ads.map_monitor import MapMonitor
from ads.parameters import Parameters
from vehicle.messages import FloatArray, VehicleDescription

CLEARANCE = 0.65  # m between the car's side and the obstacle's, at least
COMFORT_CLEARANCE = 0.9  # m, wanted
WAIT_GAP = 12.0  # m between bumpers when waiting behind an obstacle; enough to swing out from
SHORTEST_GAP = 3.0  # m; nearer than this the offset must clear the obstacle already
SWING = 22.0  # m of path for a swing, wanted
TIGHT_GAP = -0.5  # m; as SHORTEST_GAP, of a car that creeps out from where it stands: its corner leads its axle
TIGHT_SWING = 14.0  # m
CREEPS = 0.5  # m/s
SWING_EARLY = 6.0  # m before the car may return at which the swing back begins, gently
EDGE = 0.2  # m left between the car and the edge of the lane it passes in
SETTLED = 6.0  # s; a vehicle in the other lane that stood so long will not set off
UNKNOWN_SPEED = 5.0  # m/s assumed of one that may set off
CONTACT_TIME = 3.0  # s kept to oncoming traffic when back in the lane
STILL_CONTACT_TIME = 2.0  # s, once it has begun
RESOLVE = 0.4  # s between two solutions
OVERSHOOT = 0.5  # m beyond the wanted offset, at most
SETTLED_PATH = 8.0  # m ahead in which a new plan asks for no more offset than the old one has
LARGEST_BEND = 0.14  # 1/m
NO_BOUND = 1e3  # m
GONE_BY = 1.5  # m between an oncoming vehicle's rear and the place where the car needs its lane
STILL_GONE_BY = 0.5  # m, once it has begun
BESIDE_GAP = 0.4  # m between the car's front corner and an oncoming vehicle's side until it has gone by
SURELY_COMES = 1.5  # m/s; an oncoming vehicle as fast as this will go by
SET_OFF = 0.4  # s until a standing car moves
QUICKEST = 1.5  # m/s^2 of the car when it enters the other lane
MEETING_GAP = 8.0  # m between bumper and obstacle where the car leaves its lane once the oncoming vehicle has gone by
MEETING_TIME = 2.8  # s of time to collision with the obstacle, at least, while it waits for that
LEAST_GAP = 10.5  # m between bumpers from which it can swing out; 9.5 is the least with which there is a plan
FIRM = 1.5  # m/s^2
SLOWEST_MEETING = 1.0  # m/s; to be slower than this it stops
LEAST_CHANGE = 0.12  # m; a plan that differs less is not worth a new path


class Obstacle(NamedTuple):
    """A standing object in the lane, in path coordinates [m]."""

    track: int
    s_from: float
    s_to: float
    l_from: float
    l_to: float


class Neighbour(NamedTuple):
    """Object near the path: track, s_from, s_to, l_from, l_to [m], speed along it [m/s], how long it stood [s]."""

    track: int
    s_from: float
    s_to: float
    l_from: float
    l_to: float
    speed: float
    stood: float


class Overtaking:
    """Plans offsets around one obstacle. `offsets` belong to the points of the reference path it was reset to."""

    def __init__(self, parameters: Parameters, car: VehicleDescription) -> None:
        self._parameters = parameters
        self._car = car
        self._solver = OffsetPlanner()
        self._front = car.center_x + 0.5 * car.length
        self._rear = 0.5 * car.length - car.center_x
        self._pieces: FloatArray | None = None
        self._s_from = 0.0
        self._step = 1.0
        self._solved = self._asked = -math.inf
        self._draft: tuple[FloatArray, float, float] | None = None  # pieces, where they begin [m], step [m]
        self.meeting_speed: float | None = None  # m/s to come when oncoming vehicles have gone by; None: stop for them
        self.met: frozenset[int] = frozenset()  # tracks that will have gone by before the car needs their lane
        self.offsets: FloatArray | None = None  # None: in the lane everywhere
        self.s_end = -math.inf  # where the plan is back in the lane [m]
        self.obstacle: Obstacle | None = None
        self.creeps = False  # the car hardly moves: it may swing out as tightly as it can

    def reset(self) -> None:
        """Forget the plan: the reference path is a new one, or the manoeuvre is over."""
        self._pieces = self._draft = self.meeting_speed = None
        self.met = frozenset()
        self.offsets = None
        self.obstacle = None
        self.s_end = -math.inf

    def offset(self, s: float) -> float:
        """Planned offset [m] at arc length `s` [m]."""
        if self._pieces is None:
            return 0.0
        value: float = offset_at(self._pieces, self._s_from, self._step, s)[0]
        return value

    def needed_offset(self, obstacle: Obstacle, side: float, clearance: float) -> float:
        """Offset [m] (positive, to `side`) that passes an obstacle with `clearance` [m]."""
        edge = obstacle.l_to if side > 0.0 else -obstacle.l_from
        return edge + 0.5 * self._car.width + clearance

    def wanted_offset(self, obstacle: Obstacle, monitor: MapMonitor) -> float | None:
        """Offset [m] to drive past an obstacle, positive to the passing side; None if the road is too narrow."""
        room = monitor.room(0.5 * (obstacle.s_from + obstacle.s_to))
        widest = room.half_width + room.side_width - 0.5 * self._car.width - EDGE
        if self.needed_offset(obstacle, monitor.side, CLEARANCE) > widest:
            return None
        wanted = max(self._parameters.MPC_w, self.needed_offset(obstacle, monitor.side, COMFORT_CLEARANCE))
        return min(wanted, widest)

    def back_at(self, obstacle: Obstacle) -> float:
        """Arc length [m] of the rear axle where the car may begin to return."""
        return obstacle.s_to + self._rear + 2.0

    def gap_free(
        self, s: float, v: float, obstacle: Obstacle, monitor: MapMonitor, wanted: float, others: list[Neighbour]
    ) -> bool:
        """Whether the passing side stays free until the car is back in its lane; sets `meeting_speed`.

        Free, too, if who comes will have gone by before the car needs his lane.
        """
        half = 0.5 * self._car.width + 0.5
        low, high = wanted - half, wanted + half
        speed = self._parameters.DECISION_OT_speed
        back = self.back_at(obstacle) + SWING
        time = max(back - s, 0.0) / (0.9 * speed) + 0.5 * max(speed - v, 0.0)
        contact = CONTACT_TIME if self._pieces is None else STILL_CONTACT_TIME
        free, met, gone = True, math.inf, set()
        for other in others:
            l_from, l_to = (other.l_from, other.l_to) if monitor.side > 0.0 else (-other.l_to, -other.l_from)
            if l_to < low or l_from > high:
                continue
            if other.s_to < s - 1.0 and other.speed <= 0.0:
                continue  # it has gone by
            if other.speed > 0.5:  # same direction
                closing = max(other.speed - v, 0.0)
                if other.s_to > s - 8.0 - closing * time and other.s_from < back:
                    free, met = False, 0.0
                continue
            away = other.speed
            if away > -0.5:
                if other.stood >= SETTLED:
                    if other.s_from < back + 2.0 and other.s_to > s:
                        free, met = False, 0.0
                    continue
                away = -UNKNOWN_SPEED
            if other.s_from + 1.1 * away * time >= back + self._front + contact * (speed - away):
                continue
            if other.speed < -SURELY_COMES and self._goes_by_before(s, v, other, l_from, monitor.side):
                gone.add(other.track)
            elif other.speed > -SURELY_COMES:
                free, met = False, 0.0
            else:
                free, met = False, min(met, self._speed_to_meet(s, obstacle, other))
        self.meeting_speed = None if free or met < SLOWEST_MEETING else met
        self.met = frozenset(gone)
        return free

    def _goes_by_before(self, s: float, v: float, other: Neighbour, edge: float, side: float) -> bool:
        """Whether an oncoming vehicle, its side at `edge` [m], has gone by when the car comes to where it needs it."""
        enters = self._enters(s, edge - BESIDE_GAP, side)
        time = _time_to(enters - s, v, self._parameters.DECISION_OT_speed)
        # a plan under way is not given up for what a better look changes
        margin, share = (GONE_BY, 0.9) if self._pieces is None else (STILL_GONE_BY, 1.0)
        return other.s_to + share * other.speed * time + margin < enters + self._front

    def _enters(self, s: float, edge: float, side: float) -> float:
        """Arc length [m] from `s` on at which the car's front corner crosses `edge` [m] by the plan, or its draft."""
        draft = self._draft
        if self._pieces is not None:
            draft = self._pieces, self._s_from, self._step
        if draft is None:
            return s
        pieces, s_from, step = draft
        end = s_from + N * step
        at = s
        while at < end:
            offset, slope, _ = offset_at(pieces, s_from, step, at)
            if side * (offset + self._front * slope) + 0.5 * self._car.width > edge:
                break
            at += 0.5
        return at

    def _speed_to_meet(self, s: float, obstacle: Obstacle, other: Neighbour) -> float:
        """Speed [m/s] with which the car comes MEETING_GAP behind the obstacle just when `other` has gone by there."""
        front = obstacle.s_from - MEETING_GAP
        left = front - self._front - s
        if left <= 0.0:
            return 0.0
        pace = max(-other.speed, UNKNOWN_SPEED)  # a track that sets off is faster than it is known to be
        gap = obstacle.s_from - self._front - s
        stops = math.sqrt(2.0 * FIRM * max(gap - LEAST_GAP, 0.0))  # should it not come
        return min(left * pace / max(other.s_to + GONE_BY - front, 1e-3), gap / MEETING_TIME, stops)

    def plan(self, t: float, s: float, path: FloatArray, obstacle: Obstacle | None, monitor: MapMonitor) -> bool | None:
        """Plan from arc length `s` [m] on around an obstacle, or back to the lane if there is none; `t` [s].

        `path` (n, COLUMNS) of a spline. True: `offsets` are new; False: the old plan still holds; None: there is no
        plan that keeps the bounds.
        """
        same = self._pieces is not None and (obstacle is None) == (self.obstacle is None)
        if same and t - self._solved < RESOLVE - 1e-9:
            return False
        self._solved = t
        solution = self._solve(s, obstacle, monitor)
        if solution is None:
            return False if same else None  # the old plan was good a moment ago
        pieces, step = solution
        self.obstacle = obstacle
        if self._pieces is not None and self._change(pieces, s, step) < LEAST_CHANGE:
            return False
        if self.offsets is None or len(self.offsets) != len(path):
            self.offsets = np.zeros(len(path))
        self._pieces, self._s_from, self._step, self.s_end = pieces, s, step, s + N * step
        write_offsets(path, self.offsets, pieces, s, step)
        return True

    def feasible(self, t: float, s: float, obstacle: Obstacle, monitor: MapMonitor) -> bool:
        """Whether a plan around `obstacle` exists from `s` [m]; asks the solver every RESOLVE seconds."""
        if t - self._asked >= RESOLVE - 1e-9:
            self._asked = t
            found = self._solve(s, obstacle, monitor)
            self._draft = None if found is None else (found[0], s, found[1])
        return self._draft is not None

    def _change(self, pieces: FloatArray, s: float, step: float) -> float:
        """Largest difference [m] between a new plan from `s` on and the present one."""
        return max(
            abs(float(offset_at(pieces, s, step, x)[0]) - self.offset(float(x)))
            for x in np.linspace(s, s + N * step, 12)
        )

    def _solve(self, s: float, obstacle: Obstacle | None, monitor: MapMonitor) -> tuple[FloatArray, float] | None:
        """Pieces and step [m] of a plan from `s` [m] on, None if there is none."""
        found = self._solve_with(s, obstacle, monitor, SHORTEST_GAP, SWING)
        if found is None and obstacle is not None and self.creeps:
            found = self._solve_with(s, obstacle, monitor, TIGHT_GAP, TIGHT_SWING)
        return found

    def _solve_with(
        self, s: float, obstacle: Obstacle | None, monitor: MapMonitor, shortest: float, swing: float
    ) -> tuple[FloatArray, float] | None:
        """As _solve; clear of the obstacle `shortest` [m] before it, and `swing` [m] for the way back."""
        start = (0.0, 0.0, 0.0)
        if self._pieces is not None:
            start = offset_at(self._pieces, self._s_from, self._step, s)
        end = (self.back_at(obstacle) if obstacle is not None else s) + swing + 2.0
        step = max((end - s) / N, 0.8)
        at = s + step * np.arange(1, N + 1)
        wanted, low, high = np.zeros(N), np.full(N, -NO_BOUND), np.full(N, NO_BOUND)
        side, car = monitor.side, self._car
        if obstacle is not None:
            goal = self.wanted_offset(obstacle, monitor)
            if goal is None:
                return None
            gap = obstacle.s_from - (s + self._front)
            early = min(max(0.45 * gap, shortest), 12.0)
            full_from, full_to = obstacle.s_from - self._front - early, self.back_at(obstacle)
            share = np.clip((at - full_to + SWING_EARLY) / swing, 0.0, 1.0)  # evenly back: a sharp bend costs speed
            wanted = np.where(at >= full_from, side * goal * (0.5 + 0.5 * np.cos(np.pi * share)), 0.0)
            floor = self.needed_offset(obstacle, side, CLEARANCE)
            bound = (at >= obstacle.s_from - self._front - shortest) & (at <= obstacle.s_to + self._rear + 0.5)
            room = monitor.room(0.5 * (obstacle.s_from + obstacle.s_to))
            ceiling = min(room.half_width + room.side_width - 0.5 * car.width, goal + OVERSHOOT)
            needed = np.where(bound, floor, -NO_BOUND)
            if self._pieces is not None:  # no swerve for what a better look at the obstacle changes
                close = at < s + SETTLED_PATH
                needed[close] = np.minimum(needed[close], [side * self.offset(float(x)) for x in at[close]])
            (low if side > 0.0 else high)[:] = side * needed
            (high if side > 0.0 else low)[:] = side * max(ceiling, floor)
        bend = min(LARGEST_BEND, 0.85 * math.tan(car.max_steer) / car.wheelbase)
        pieces = self._solver.solve(start, step, wanted, low, high, bend)
        return None if pieces is None else (pieces, step)

    def back_in_lane(self, s: float) -> bool:
        """Whether the plan is over at `s` [m]."""
        return s >= self.s_end or (self._pieces is not None and self._is_flat(s))

    def _is_flat(self, s: float) -> bool:
        assert self._pieces is not None
        return all(abs(self.offset(s + d)) < 0.03 for d in (0.0, 3.0, 8.0, 15.0, 25.0))


def _time_to(distance: float, v: float, speed: float) -> float:
    """Least time [s] for a distance [m] from `v` [m/s] on, up to `speed` [m/s]."""
    late = SET_OFF if v < 0.1 else 0.0
    top = max(speed, v)
    ramp = (top * top - v * v) / (2.0 * QUICKEST)
    if distance <= ramp:
        return late + (math.sqrt(v * v + 2.0 * QUICKEST * distance) - v) / QUICKEST
    return late + (top - v) / QUICKEST + (distance - ramp) / max(top, 0.1)
