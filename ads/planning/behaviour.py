"""Behaviour: turns the scene into facts, runs the nets, and turns marked places into limits and paths."""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

from ads.control.longitudinal import COMFORT_DECELERATION, NOW
from ads.control.speed_profile import approach_speed, stopping_distance
from ads.control.spline import shifted
from ads.localization import Estimate
from ads.map_monitor import MapMonitor
from ads.parameters import Parameters
from ads.planning.crossing import CrossingRule
from ads.planning.following import MARGIN, find_lead
from ads.planning.junction import JunctionRule
from ads.planning.memory import STANDING, TrackMemory
from ads.planning.navigator import Navigator
from ads.planning.nets import NETS
from ads.planning.overtaking import CREEPS, WAIT_GAP, Neighbour, Obstacle, Overtaking
from ads.planning.petri_net import Net, NetSystem
from ads.planning.scene import first_contact, objects_of, place
from vehicle.messages import Detection, FloatArray, SignalState, VehicleDescription, lit_lamps

STANDING_FOR = 0.6  # s until a standing vehicle is an obstacle to pass
PARKED_AFTER = 10.0  # s; a vehicle that was seen moving is waited for so long
QUEUE_GAP = 10.0  # m at most between one that waits and the next, or the line that it waits at; chosen
WIDE = 2.2  # m; no car is so wide, a truck or a bus is
LONG = 10.0  # m, its length until more of it is seen
MERGE_GAP = 25.0  # m; obstacles closer than this are passed in one go
MERGE_LENGTH = 45.0  # m
ABORT_GAP = 8.0  # m
ABORT_DECELERATION = 1.5  # m/s^2
CONFLICT_FOR = 0.4  # s of conflict until the car gives up
BLOCKED_FOR = 2.0  # s without room to pass until another way is looked for
STUCK_GAP = 6.0  # m before an obstacle without a way around it; from 5.5 m on there is a tight one
SURE = 0.5  # score; an object less sure, or unseen for a while, is no reason for an emergency
DANGER_HORIZON = 3.5  # s
DANGER_DECELERATION = 3.2  # m/s^2; when a collision needs more, it is an emergency
DANGER_MARGIN = 0.15  # m beside the car
AVERTED = 2.0  # s
SIGNAL_GAP = 1.0  # m before a signal
AMBER_DECELERATION = 2.0  # m/s^2; amber is a stop if this much suffices
GOAL_NEAR = 1.0  # m
END_GAP = 2.0  # m before a dead end
FREE = 1e6  # m


class Decision(NamedTuple):
    """What the controls are to do: limits (distance ahead [m], speed there [m/s]) and emergency braking [m/s^2]."""

    limits: list[tuple[float, float]]
    brake: float
    path: FloatArray  # (n, COLUMNS) of a spline; the same object until planned anew


class Planner(Protocol):
    """Decides from the objects, the map and the signals."""

    trace: dict[str, float]

    def step(
        self,
        estimate: Estimate,
        navigator: Navigator,
        new_reference: bool,
        detections: tuple[Detection, ...],
        signals: tuple[SignalState, ...],
    ) -> Decision:
        """One tick."""

    def may_replan(self) -> bool:
        """Whether the reference path may change now."""


class Behaviour:
    """Planner by hierarchical Petri nets; a net without transitions is a behaviour switched off."""

    def __init__(self, parameters: Parameters, car: VehicleDescription, nets: tuple[Net, ...] = NETS) -> None:
        self._parameters = parameters
        self._car = car
        self._front = car.center_x + 0.5 * car.length
        self.nets = nets
        self._nets = NetSystem(nets)
        self.trace = self._nets.trace
        self._overtaking = Overtaking(parameters, car)
        self._path: FloatArray | None = None
        self._memory = TrackMemory(car.camera_z)
        self._crossing = CrossingRule(parameters, car)
        self._junction = JunctionRule(car)
        self._signals: dict[str, str] = {}
        self._amber = ""  # id of the signal for whose amber the car stops
        self._obstacle: Obstacle | None = None
        self._obstacle_seen = -math.inf
        self._queue_s = math.inf  # where the rear of the last who waits at a line ahead is [m along the path]
        self._last: int | None = None  # his track, kept until he drives or is an obstacle
        self._free_at = -math.inf
        self._stuck = False
        self._passable_at = -math.inf
        self._tried: int | None = None  # track of the obstacle for which another way was looked for
        self._stop_s: float | None = None

    def may_replan(self) -> bool:
        """Only in its lane: the offset belongs to the points of the reference path."""
        return self._overtaking.offsets is None

    def step(
        self,
        estimate: Estimate,
        navigator: Navigator,
        new_reference: bool,
        detections: tuple[Detection, ...],
        signals: tuple[SignalState, ...],
    ) -> Decision:
        """See Planner."""
        assert navigator.path is not None
        t, s, v = estimate.t, navigator.s, max(estimate.v, 0.0)
        if new_reference or self._path is None:
            self._path = navigator.path
            self._overtaking.reset()
            self._obstacle = self._stop_s = None  # places along the path that there was
        for signal in signals:
            self._signals[signal.id] = signal.state
        self._memory.note(t, estimate.x, estimate.y, detections)
        placed, contact = self._place(s, v, navigator, self._path, detections)
        monitor = navigator.monitor
        needed = self._needed_deceleration(v, contact)
        crossing_near, crossing_stop = self._crossing.update(t, s, v, monitor, detections, placed)
        if self._nets.marked("crossing", "stop") and self._crossing.needed < math.inf:
            needed = max(needed, self._crossing.needed)
        junction_near, junction_taken = self._junction.update(t, s, v, navigator, detections, self._memory)
        pass_by = self._junction.passing | self._overtaking.met | self._crossing.passing
        lead = find_lead(s, v, self._car, self._overtaking.offset, detections, placed, pass_by)
        stop_light = self._stop_light(s, v, monitor)
        self._note_queue(t, s, detections, placed, stop_light, crossing_stop)
        self._find_obstacle(t, s, detections, placed, monitor)
        self._look_for_another_way(estimate, navigator)
        facts = {
            "located": True,
            "danger": needed > DANGER_DECELERATION,
            "averted": contact > AVERTED or v < 0.05,
            "at_goal": navigator.goal_s - s < GOAL_NEAR and v < 0.2,
            "light_stop": stop_light < FREE,
            "crossing_near": crossing_near,
            "crossing_occupied": crossing_stop,
            "junction_near": junction_near,
            "junction_taken": junction_taken,
            "lead": lead is not None,
            **self._overtaking_facts(t, s, v, navigator, detections, placed),
        }
        self._nets.step(facts)
        self._act_on_path(t, s, navigator)
        limits = self._limits(s, v, navigator, lead, stop_light)
        brake = 0.0
        if self._nets.marked("main", "emergency"):
            brake = max(4.0, 1.3 * needed)
        return Decision(limits, brake, self._path)

    # what is seen ---------------------------------------------------------------------------------------------------

    def _place(
        self, s: float, v: float, navigator: Navigator, path: FloatArray, detections: tuple[Detection, ...]
    ) -> tuple[list[list[float]], float]:
        """Objects in coordinates of the reference path, and the time [s] until the car would touch one."""
        if not detections:
            return [], math.inf
        reference, index, car = navigator.path, navigator.index, self._car
        assert reference is not None
        objects = objects_of(detections)
        in_path = place(reference, index, objects)
        placed: list[list[float]] = in_path.tolist()
        sure = [i for i, d in enumerate(detections) if d.score > SURE]
        if len(sure) < len(detections):
            objects, in_path = objects[sure], in_path[sure]
        contact = first_contact(
            path, reference, index, s, v, 0.5 * car.length, 0.5 * car.width + DANGER_MARGIN, car.center_x,
            objects, in_path, DANGER_HORIZON,
        )  # fmt: skip
        return placed, float(contact)

    def _needed_deceleration(self, v: float, contact: float) -> float:
        if contact > DANGER_HORIZON or v < 0.1:
            return 0.0
        distance = v * contact - v * (self._car.drive_delay + 0.15) - 0.4
        return v * v / (2.0 * max(distance, 0.1))

    def _stop_light(self, s: float, v: float, monitor: MapMonitor | None) -> float:
        """Distance [m] to where the rear axle stops for a signal; FREE if none asks for it.

        A stop for amber, once begun, is not given up: until the brake bites it comes to need more than at the onset.
        """
        begun, self._amber = self._amber, ""
        if monitor is None or not self._signals:
            return FREE
        for signal in monitor.signals:
            distance = signal.s - s - self._front - SIGNAL_GAP
            if distance < -SIGNAL_GAP or distance > 150.0:
                continue
            lamps = lit_lamps(self._signals.get(signal.id, "green"))
            if "red" in lamps:  # amber beside it lifts nothing (Vienna Convention on Road Signs 1968, art. 23)
                return distance
            stops = signal.id == begun or v * v < 2.0 * AMBER_DECELERATION * max(distance, 0.0)
            if "amber" in lamps and stops:
                self._amber = signal.id
                return distance
        return FREE

    # overtaking -----------------------------------------------------------------------------------------------------

    def _note_queue(
        self, t: float, s: float, detections: tuple[Detection, ...], placed: list[list[float]], stop_light: float,
        crossing_stop: bool,
    ) -> None:  # fmt: skip
        """Note who waits in the lane at a light that asks for a stop or at an occupied crossing: no obstacles to pass.

        They are waited for as if they had moved up to now.
        """
        last, self._last, self._queue_s = self._last, None, math.inf
        if self._passing():
            return
        half, crossing = 0.5 * self._car.width + MARGIN, self._crossing.crossing
        lines = [s + self._front + SIGNAL_GAP + stop_light] if stop_light < FREE else []
        if crossing_stop and crossing is not None:
            lines.append(crossing.s_from)
        standing = [
            (s_to, s_from, detection.track)
            for (s_from, s_to, l_from, l_to, along, _), detection in zip(placed, detections, strict=True)
            if detection.kind != "pedestrian" and abs(along) < STANDING
            and l_from < half and l_to > -half and s_from > s + self._front
        ]  # fmt: skip
        for line in lines:
            reach = line
            for s_to, s_from, track in sorted(standing, reverse=True):
                if s_from > line or s_to < reach - QUEUE_GAP:
                    continue
                reach = min(reach, s_from)
                self._memory.waits(t, track)
                if reach < self._queue_s:
                    self._queue_s, self._last = reach, track
        obstacle = None if self._obstacle is None else self._obstacle.track
        if self._last is not None and self._last == obstacle:
            self._obstacle = None
        if self._last is None and last is not None and last != obstacle:
            self._queue_s = next((s_from for _, s_from, track in standing if track == last), math.inf)
            self._last = last if self._queue_s < math.inf else None

    def _find_obstacle(
        self,
        t: float,
        s: float,
        detections: tuple[Detection, ...],
        placed: list[list[float]],
        monitor: MapMonitor | None,
    ) -> None:
        """Note the standing vehicles ahead in the lane, near ones taken together; keeps the last while it passes it."""
        half = 0.5 * self._car.width + MARGIN
        found: list[Obstacle] = []
        beside = self._nets.marked("overtaking", "beside")
        for row, detection in zip(placed, detections, strict=True):
            s_from, s_to, l_from, l_to, along, _ = row
            if detection.kind == "pedestrian" or abs(along) > 0.6:
                continue
            if l_from > half or l_to < -half or s_to < s - 3.0 or s_from > s + 100.0:
                continue
            patience = PARKED_AFTER if self._memory.moved(detection.track) else STANDING_FOR
            passed_now = beside and self._obstacle is not None and detection.track == self._obstacle.track
            if passed_now or self._memory.stood(t, detection.track) >= patience:
                if detection.width > WIDE:  # only its rear may be in sight, and the rest is longer than a car's
                    s_to = max(s_to, s_from + LONG)
                found.append(Obstacle(detection.track, s_from, s_to, l_from, l_to))
        if not found:
            if t - self._obstacle_seen > 3.0 and not self._passing():
                self._obstacle = None
            return
        found.sort(key=lambda o: o.s_from)
        merged = found[0]
        for other in found[1:]:
            if other.s_from < merged.s_to + MERGE_GAP and other.s_to - merged.s_from < MERGE_LENGTH:
                merged = Obstacle(
                    merged.track,
                    merged.s_from,
                    max(merged.s_to, other.s_to),
                    min(merged.l_from, other.l_from),
                    max(merged.l_to, other.l_to),
                )
        if self._passing() and self._obstacle is not None and merged.s_from > self._obstacle.s_to + MERGE_GAP:
            return  # the next one, after this
        self._obstacle, self._obstacle_seen = merged, t

    def _look_for_another_way(self, estimate: Estimate, navigator: Navigator) -> None:
        """Have the route changed once when the road is too narrow beside what stands in it."""
        o, monitor, t = self._obstacle, navigator.monitor, estimate.t
        if o is None or monitor is None or self._overtaking.wanted_offset(o, monitor) is not None:
            self._passable_at = t
        elif t - self._passable_at > BLOCKED_FOR and self._tried != o.track:
            self._tried = o.track
            if navigator.avoid(o.s_from, estimate):
                self._obstacle = None

    def _passing(self) -> bool:
        marked = self._nets.marked
        return any(marked("overtaking", p) for p in ("out", "beside", "back", "abort"))

    def _overtaking_facts(
        self, t: float, s: float, v: float, navigator: Navigator, detections: tuple[Detection, ...],
        placed: list[list[float]],
    ) -> dict[str, bool]:  # fmt: skip
        o, plan, monitor = self._obstacle, self._overtaking, navigator.monitor
        facts = dict.fromkeys(("obstacle", "in_range", "gap_free", "way_around", "beside", "conflict", "passed"), False)
        plan.met, plan.meeting_speed, plan.creeps = frozenset(), None, v < CREEPS
        facts["standing"] = v < 0.05
        facts["in_lane"] = plan.offsets is None or (plan.back_in_lane(s) and abs(navigator.lateral) < 0.25)
        if o is None or monitor is None:
            return facts
        gap = o.s_from - s - self._front
        facts["obstacle"] = o.s_to > s
        facts["in_range"] = gap <= self._parameters.DECISION_OT_d_max
        # nearer than this the car could not be back in its lane and stand behind the obstacle: it goes through with it
        facts["beside"] = gap < ABORT_GAP + v * v / (2.0 * ABORT_DECELERATION)
        facts["passed"] = s > plan.back_at(o)
        if not facts["in_range"] or gap < -o.s_to + o.s_from:
            return facts
        wanted = plan.wanted_offset(o, monitor)
        reachable = navigator.goal_s > plan.back_at(o) + 5.0
        if wanted is not None:
            others = [
                Neighbour(d.track, row[0], row[1], row[2], row[3], row[4], self._memory.stood(t, d.track))
                for row, d in zip(placed, detections, strict=True)
            ]
            if reachable and self._parameters.MPC_w > 0.0:
                facts["way_around"] = plan.feasible(t, s, o, monitor)
            facts["gap_free"] = plan.gap_free(s, v, o, monitor, wanted, others)
        if facts["gap_free"]:
            self._free_at = t
        facts["conflict"] = t - self._free_at > CONFLICT_FOR
        return facts

    def _act_on_path(self, t: float, s: float, navigator: Navigator) -> None:
        """Plan offsets as the places ask; a plan that cannot be made leaves the old path (and the lead rule stops)."""
        marked, plan, monitor = self._nets.marked, self._overtaking, navigator.monitor
        reference = navigator.path
        assert reference is not None
        if monitor is None:
            return
        new: bool | None = False
        if marked("overtaking", "out") or marked("overtaking", "beside"):
            if self._obstacle is not None and s < plan.back_at(self._obstacle):
                new = plan.plan(t, s, reference, self._obstacle, monitor)
        elif marked("overtaking", "abort"):
            new = plan.plan(t, s, reference, None, monitor)
        elif plan.offsets is not None and not marked("overtaking", "back") and plan.back_in_lane(s):
            plan.reset()
            self._path = reference
            if marked("overtaking", "keep"):
                self._obstacle = None
        self._stuck = new is None
        if new and plan.offsets is not None:
            self._path = shifted(reference, 0, plan.offsets)
            navigator.fill(self._path)

    # what to do -----------------------------------------------------------------------------------------------------

    def _stop_behind(self, s: float, v: float, obstacle: Obstacle) -> float:
        """Distance [m] to where the rear axle stops: WAIT_GAP behind an obstacle, else as soon as comfort allows."""
        wanted = obstacle.s_from - self._front - WAIT_GAP
        if s + stopping_distance(v, 1.5) + 0.3 * v <= wanted:
            self._stop_s = None
            return wanted - s
        if self._stop_s is None:
            self._stop_s = s + stopping_distance(v, 1.2) + 0.6 * v
        return min(self._stop_s, obstacle.s_from - self._front - STUCK_GAP) - s

    def _waiting_speed(self, s: float, obstacle: Obstacle) -> float:
        """Speed [m/s] of one that comes to rest WAIT_GAP behind an obstacle by comfortable braking."""
        return float(approach_speed(obstacle.s_from - self._front - WAIT_GAP - s, COMFORT_DECELERATION))

    def _limits(
        self, s: float, v: float, navigator: Navigator, lead: tuple[float, float] | None, stop_light: float
    ) -> list[tuple[float, float]]:
        marked = self._nets.marked
        limits: list[tuple[float, float]] = []
        if navigator.goal_s < FREE:
            limits.append((navigator.goal_s - s, 0.0))
        if navigator.dead_end_s < FREE:
            limits.append((navigator.dead_end_s - s - self._front - END_GAP, 0.0))
        if lead is not None and marked("following", "follow"):
            limits.append(lead)
        if marked("light", "stop") and stop_light < FREE:
            limits.append((stop_light, 0.0))
        if not marked("crossing", "clear"):
            limits.extend(self._crossing.limits(s, navigator.set_speed, marked("crossing", "stop")))
        if not marked("junction", "clear"):
            limits.extend(self._junction.limits(s, marked("junction", "give_way")))
        if self._queue_s < math.inf:  # so far that there is a way around the last of them if he does not set off
            limits.append((self._queue_s - self._front - STUCK_GAP - s, 0.0))
        obstacle = self._obstacle
        if obstacle is not None:
            stuck = self._stuck and s + self._front < obstacle.s_from
            meeting = self._overtaking.meeting_speed
            if marked("overtaking", "wait") and meeting is not None and meeting > self._waiting_speed(s, obstacle):
                limits.append((obstacle.s_from - self._front - STUCK_GAP - s, 0.0))
                limits.append((NOW, meeting))
            elif marked("overtaking", "wait") or marked("overtaking", "abort") or stuck:
                limits.append((self._stop_behind(s, v, obstacle), 0.0))
            else:
                self._stop_s = None
        if self._passing() and not marked("overtaking", "back"):
            limits.append((NOW, self._parameters.DECISION_OT_speed))
        return limits
