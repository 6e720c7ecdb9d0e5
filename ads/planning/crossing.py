"""Pedestrian crossings: which one is next, is it occupied, where to stop for it."""

from __future__ import annotations

import math

from ads.control.longitudinal import NOW
from ads.control.speed_profile import stopping_distance
from ads.map_monitor import Crossing, MapMonitor
from ads.parameters import Parameters
from vehicle.messages import Detection, VehicleDescription

SPEED = 0.7  # of the set speed, within DECISION_PC_d_max
WATCH_SPEED = 0.5  # of the set speed, from DECISION_PC_d_min on, while a pedestrian is near the crossing
LEAST_SPEED = 2.0  # m/s
BAND = 1.5  # m before and behind the crosswalk in which a pedestrian counts
WATCH_SIDE = 7.0  # m beside the crosswalk's ends in which a pedestrian makes the ego watch
SOON = 10.0  # s; a pedestrian farther than this from the lane does not cross yet
SIDE = 0.9  # m beside the car that a pedestrian must be clear of
TOWARDS = 0.3  # m/s
LATE = 2.0  # m/s^2; a stop that needs more is left to the emergency net
GENTLE = 1.2  # m/s^2 of a stop that d_min leaves no room for
REACTION = 0.6  # s until the brake bites
EDGE_GAP = 1.0  # m between bumper and crosswalk, at least
FREE_FOR = 0.5  # s until a crossing counts as free
UNSEEN_FOR = 8.0  # s at most that a pedestrian counts who walks towards the lane and has left the sensors' view


class CrossingRule:
    """Knows the next crossing; remembers where it stops for it."""

    def __init__(self, parameters: Parameters, car: VehicleDescription) -> None:
        self._d_max, self._d_min = parameters.DECISION_PC_d_max, parameters.DECISION_PC_d_min
        self._front = car.center_x + 0.5 * car.length
        self._half = 0.5 * car.width + SIDE
        self.crossing: Crossing | None = None
        self._stop_s: float | None = None
        self._seen = -math.inf
        self._watch = False
        self._across: dict[int, float] = {}  # pedestrian's track -> time [s] when he will have crossed the lane

    def update(
        self, t: float, s: float, v: float, monitor: MapMonitor | None, detections: tuple[Detection, ...],
        placed: list[list[float]],
    ) -> tuple[bool, bool]:  # fmt: skip
        """Whether a crossing is within DECISION_PC_d_max, and whether the car is to stop for it."""
        self.crossing = crossing = self._next(s, monitor)
        if crossing is None:
            self._stop_s = None
            self._watch = False
            self._across.clear()
            return False, False
        if self._occupied(t, crossing, detections, placed):
            self._seen = t
        occupied = t - self._seen < FREE_FOR
        if not occupied:
            self._stop_s = None
        elif self._stop_s is None:
            self._stop_s = self._stop_place(crossing, s, v)
        return True, occupied and self._stop_s is not None

    def limits(self, s: float, set_speed: float, stop: bool) -> list[tuple[float, float]]:
        """Limits (distance [m], speed [m/s]) for the crossing ahead; `stop` if the net says so."""
        crossing = self.crossing
        if crossing is None:
            return []
        found = [(NOW, max(SPEED * set_speed, LEAST_SPEED))]
        if self._watch and s < crossing.s_from:
            left = crossing.s_middle - self._d_min - s
            found.append((left if left > 0.0 else NOW, max(WATCH_SPEED * set_speed, LEAST_SPEED)))
        if stop and self._stop_s is not None:
            found.append((self._stop_s - s, 0.0))
        return found

    def _next(self, s: float, monitor: MapMonitor | None) -> Crossing | None:
        """The next crossing within DECISION_PC_d_max that the rear axle has not passed."""
        if monitor is None:
            return None
        for crossing in monitor.crossings:
            if s < crossing.s_to:
                return crossing if crossing.s_middle - s < self._d_max else None
        return None

    def _stop_place(self, crossing: Crossing, s: float, v: float) -> float | None:
        """Where the rear axle is to stop [m along the path]: DECISION_PC_d_min before the middle of the crossing.

        A car that is already nearer stops as soon as comfort allows, the bumper at least EDGE_GAP before the crosswalk.
        None if it cannot.
        """
        wanted = crossing.s_middle - self._d_min
        soonest = s + stopping_distance(v, GENTLE) + REACTION * v
        if soonest <= wanted:
            return wanted
        at_edge = crossing.s_middle - crossing.s_from + self._front + EDGE_GAP
        last = crossing.s_middle - min(self._d_min, at_edge)
        if last - s < v * v / (2.0 * LATE):
            return None
        return min(max(wanted, soonest), last)

    def _occupied(
        self, t: float, crossing: Crossing, detections: tuple[Detection, ...], placed: list[list[float]]
    ) -> bool:
        """Whether a pedestrian is in the car's way on the crossing or walks towards it.

        Near the crosswalk he may be beside the camera's view and the LiDAR's; he walks on all the same.
        """
        half = self._half
        self._watch = False
        occupied = False
        for row, detection in zip(placed, detections, strict=True):
            if detection.kind not in ("pedestrian", "bicycle"):
                continue
            s_from, s_to, l_from, l_to, _, across = row
            if s_to < crossing.s_from - BAND or s_from > crossing.s_to + BAND:
                continue
            middle = 0.5 * (l_from + l_to)
            towards = -math.copysign(1.0, middle) * across
            if crossing.l_from - WATCH_SIDE < middle < crossing.l_to + WATCH_SIDE and towards > -TOWARDS:
                self._watch = True
            self._across.pop(detection.track, None)
            if l_from < half and l_to > -half:
                occupied = True
            elif towards > TOWARDS and abs(middle) - half < towards * SOON:
                occupied = True
                self._across[detection.track] = t + min((abs(middle) + half) / towards, UNSEEN_FOR)
        return occupied or any(t < until for until in self._across.values())
