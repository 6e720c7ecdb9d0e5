"""Pedestrian crossings: which one is next, is it occupied, how slow to come or where to stop for it."""

from __future__ import annotations

import math

from ads.control.longitudinal import NOW
from ads.control.speed_profile import stopping_distance
from ads.map_monitor import Crossing, MapMonitor
from ads.parameters import Parameters
from vehicle.messages import Detection, VehicleDescription

SPEED = 0.75  # of the set speed, from DECISION_PC_d_min on; on the way there from DECISION_PC_d_max it falls evenly
WATCH_SPEED = 0.5  # of the set speed, from DECISION_PC_d_min on, while a pedestrian is near the crossing
LEAST_SPEED = 2.0  # m/s
BAND = 1.5  # m before and behind the crosswalk in which a pedestrian counts
WATCH_SIDE = 7.0  # m beside the crosswalk's ends in which a pedestrian makes the ego watch
SOON = 10.0  # s; a pedestrian farther than this from the lane does not cross yet
SIDE = 0.9  # m beside the car that a pedestrian must be clear of
SIDE_LEAVING = 0.6  # m of one who walks away from the car's way
TOWARDS = 0.3  # m/s
WALKS = 0.8  # m/s; when he leaves the lane is not known of one who is slower
BEHIND_HIM = 0.6  # s between his leaving the car's way and the car's coming
SLOWEST = 0.6  # m/s; where the car would have to come slower than this, it stops
LATE = 2.0  # m/s^2; a stop that needs more is made only for one who would else be met
LATEST = 5.0  # m/s^2 of a stop before the crosswalk, at most; chosen: a dry road gives 8, a wet one 5 to 6
LEFT = 0.2  # m between bumper and crosswalk that such a stop leaves; chosen
BITES = 0.15  # s, besides the car's delay, until an emergency's brake bites
PASSES = 0.5  # s between our leaving his way and his coming; chosen
BESIDE = 0.3  # m beside the car at which he has come into its way; chosen
RUN_UP = 2.5  # m kept to gather speed in while he leaves; who creeps to the crosswalk is slow behind it
HALTS = 2.5  # m/s^2; a walker stops no harder, so that one about to be out of the way cannot stay in it
SETS_OFF = 1.4  # m/s^2 of the car when it sets off behind him
SETTING_OFF = 0.8  # s until it does
FIRM = 1.5  # m/s^2 of a stop for one who stays in the way
GENTLE = 1.2  # m/s^2 of a stop that d_min leaves no room for
REACTION = 0.6  # s until the brake bites
EDGE_GAP = 0.8  # m between bumper and crosswalk, at least
FREE_FOR = 0.5  # s until a crossing counts as free
UNSEEN_FOR = 8.0  # s at most that a pedestrian counts who walks towards the lane and has left the sensors' view


class CrossingRule:
    """Knows the next crossing; remembers where it stops for it."""

    def __init__(self, parameters: Parameters, car: VehicleDescription) -> None:
        self._d_max, self._d_min = parameters.DECISION_PC_d_max, parameters.DECISION_PC_d_min
        self._front = car.center_x + 0.5 * car.length
        self._rear = 0.5 * car.length - car.center_x
        self._side = 0.5 * car.width
        self._half = self._side + SIDE
        self._bites = car.drive_delay + BITES
        self.crossing: Crossing | None = None
        self._stop_s: float | None = None
        self._yield_speed: float | None = None  # m/s to come behind who crosses, without a stop
        self.needed = 0.0  # m/s^2 with which the car still stops before the crosswalk; 0: it does not stop there
        self._seen = -math.inf
        self._watch = False
        self._meets = False  # as it drives, the car would pass neither before nor behind one of those who cross
        self._leaves = -math.inf  # when the last pedestrian leaves the car's way [s]; inf: not known
        self._decided = -math.inf  # when he can stay in it no more [s]
        self._may_stay = True
        self._him = math.inf  # where the nearest of those who cross is [m along the path]
        self.passing: frozenset[int] = frozenset()  # tracks of those who are let pass: no leads of ours
        self._crossed: set[int] = set()  # tracks of pedestrians who were in the car's way
        self._across: dict[int, float] = {}  # pedestrian's track -> time [s] when he will have crossed the lane

    def update(
        self, t: float, s: float, v: float, monitor: MapMonitor | None, detections: tuple[Detection, ...],
        placed: list[list[float]],
    ) -> tuple[bool, bool]:  # fmt: skip
        """Whether a crossing is within DECISION_PC_d_max, and whether the car is to stop for it."""
        before, self.crossing = self.crossing, self._next(s, monitor)
        crossing = self.crossing
        self._yield_speed, self.passing, self.needed = None, frozenset(), 0.0
        if crossing is None or before is None or crossing.s_from != before.s_from:  # another one, or another path
            self._stop_s, self._him = None, math.inf
        if crossing is None or before is None or crossing.id != before.id:  # who crosses there does not cross here
            self._seen = -math.inf
            self._watch = False
            self._across.clear()
            self._crossed.clear()
        if crossing is None:
            return False, False
        if self._occupied(t, s, v, crossing, detections, placed):
            self._seen = t
        if t - self._seen >= FREE_FOR:
            self._stop_s = None
            return True, False
        left, time = self._last_place(crossing) - s, max(self._leaves - t, 0.0)
        self._may_stay = t < self._decided
        slowest = left / (time + BEHIND_HIM)
        speed = max((left - RUN_UP) / (time + BEHIND_HIM), min(slowest, SLOWEST))
        if left > v * time + 0.5 * SETS_OFF * max(time - SETTING_OFF, 0.0) ** 2:
            speed = math.inf  # setting off now, the car still comes after him
        if speed >= SLOWEST:
            self._stop_s, self._yield_speed, self.passing = None, speed, frozenset(self._across) | self._crossed
            return True, True
        if self._stop_s is None:
            self._stop_s = self._stop_place(crossing, s, v)
        if self._stop_s is not None and self._meets:
            self.needed = self._needed(crossing, s, v)
        return True, self._stop_s is not None

    def limits(self, s: float, set_speed: float, stop: bool) -> list[tuple[float, float]]:
        """Limits (distance [m], speed [m/s]) for the crossing ahead; `stop` if the net says so."""
        crossing = self.crossing
        if crossing is None or s + self._front > crossing.s_to:  # nobody can step before it any more
            return []
        found = [(NOW, self._approach_speed(crossing.s_middle - s, set_speed))]
        if self._watch and s < crossing.s_from:
            left = crossing.s_middle - self._d_min - s
            found.append((left if left > 0.0 else NOW, max(WATCH_SPEED * set_speed, LEAST_SPEED)))
        if stop and self._yield_speed is not None:
            allowed = self._yield_speed
            if self._may_stay:
                room = self._him - self._front - EDGE_GAP - s
                allowed = min(allowed, math.sqrt(2.0 * FIRM * max(room, 0.0)))
            if allowed < math.inf:
                found.append((NOW, allowed))
        elif stop and self._stop_s is not None:
            found.append((self._stop_s - s, 0.0))
        return found

    def _approach_speed(self, distance: float, set_speed: float) -> float:
        """Speed [m/s] `distance` [m] before the middle of a crossing of which nobody is known to be on it."""
        slow = max(SPEED * set_speed, LEAST_SPEED)
        share = (distance - self._d_min) / max(self._d_max - self._d_min, 1e-3)
        return math.sqrt(slow * slow + max(set_speed * set_speed - slow * slow, 0.0) * min(max(share, 0.0), 1.0))

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
        None if it cannot, or would have to brake firmly and passes before anybody comes.
        """
        wanted = crossing.s_middle - self._d_min
        soonest = s + stopping_distance(v, GENTLE) + REACTION * v
        if soonest <= wanted:
            return wanted
        last = self._last_place(crossing)
        if last - s < v * v / (2.0 * LATE):
            return last if self._meets and self._needed(crossing, s, v) < LATEST else None
        return min(max(wanted, soonest), last)

    def _needed(self, crossing: Crossing, s: float, v: float) -> float:
        """Deceleration [m/s^2] of a stop LEFT before the crosswalk, once the brake bites; inf if it is too near."""
        room = self._last_place(crossing) + EDGE_GAP - LEFT - s - v * self._bites
        return v * v / (2.0 * room) if room > 0.0 else math.inf

    def _last_place(self, crossing: Crossing) -> float:
        """Where the rear axle is when the bumper is EDGE_GAP before the crosswalk [m along the path]."""
        at_edge = crossing.s_middle - crossing.s_from + self._front + EDGE_GAP
        return crossing.s_middle - min(self._d_min, at_edge)

    def _occupied(
        self, t: float, s: float, v: float, crossing: Crossing, detections: tuple[Detection, ...],
        placed: list[list[float]],
    ) -> bool:  # fmt: skip
        """Whether a pedestrian is in the car's way on the crossing or walks towards it.

        Near the crosswalk he may be beside the camera's view and the LiDAR's; he walks on all the same.
        """
        half = self._half
        self._watch = self._meets = False
        occupied, leaves, decided, him = False, -math.inf, -math.inf, crossing.s_from
        for row, detection in zip(placed, detections, strict=True):
            if detection.kind not in ("pedestrian", "bicycle"):
                continue
            s_from, s_to, l_from, l_to, _, across = row
            if s_to < crossing.s_from - BAND or s_from > crossing.s_to + BAND:
                continue
            track = detection.track
            middle = 0.5 * (l_from + l_to)
            towards = -math.copysign(1.0, middle) * across
            near = crossing.l_from - WATCH_SIDE < middle < crossing.l_to + WATCH_SIDE
            if near and towards > (TOWARDS if track in self._crossed else -TOWARDS):
                self._watch = True
            self._across.pop(track, None)
            leaving = abs(across) > WALKS and towards < 0.0
            side = half - SIDE + SIDE_LEAVING if leaving else half
            within = l_from < side and l_to > -side
            if within or (towards > TOWARDS and abs(middle) - half < towards * SOON):
                occupied, him = True, min(him, s_from) if occupied else s_from
                out = half - SIDE + SIDE_LEAVING
                way = out + l_to if across < 0.0 else out - l_from  # until he is out on the side he walks to
                out_at = t + way / abs(across) if abs(across) > WALKS else math.inf
                comes = max((l_from if middle > 0.0 else -l_to) - self._side - BESIDE, 0.0) / max(towards, TOWARDS)
                before_him = s_to + self._rear - s < v * max(comes - PASSES, 0.0)
                behind_him = s_from - self._front - s > v * (out_at - t)
                self._meets = self._meets or not (before_him or behind_him)
                leaves, decided = max(leaves, out_at), max(decided, out_at - 0.5 * abs(across) / HALTS)
                if within:
                    self._crossed.add(track)
                else:
                    self._across[track] = t + min((abs(middle) + half) / towards, UNSEEN_FOR)
        unseen = [until for until in self._across.values() if t < until]
        if occupied or unseen:
            self._leaves, self._decided, self._him = max([leaves, *unseen]), max([decided, *unseen]), him
        return occupied or bool(unseen)
