"""Map monitor: what the map holds along the route: lanes, junctions, crossings, signals, room to the side."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ads.control.spline import YAW, S, X, Y, project
from ads.planning.route import Leg, Map
from vehicle.messages import FloatArray

REACH = 150.0  # m ahead that a view covers
PASSING = 10.0  # m behind the rear axle in which a crossing or signal is still in view
BESIDE = 0.5  # m; a path that passes a crosswalk at no more than this goes over it


class LaneSpan(NamedTuple):
    """A leg of the route with its place on the path [m]."""

    leg: Leg
    junction: bool
    s_from: float
    s_to: float


class Crossing(NamedTuple):
    """A crosswalk area in path coordinates: s_from..s_to along, l_from..l_to across (left positive) [m]."""

    id: str
    s_from: float
    s_to: float
    l_from: float
    l_to: float

    @property
    def s_middle(self) -> float:
        """Arc length [m] of the path at the middle of the crossing."""
        return 0.5 * (self.s_from + self.s_to)


class StopSignal(NamedTuple):
    """A signal of the map and where it stands along the path [m]."""

    id: str
    s: float


class Room(NamedTuple):
    """Road beside the path at some place: half the own lane's width and the width of the lane to pass in [m]."""

    half_width: float
    side_width: float
    side_same_direction: bool


class CrossingAhead(NamedTuple):
    """A crosswalk of the route: outline (k, 2) [m] in the map, metres along the route to its near and far edge."""

    id: str
    area: FloatArray
    distance: float
    distance_end: float


class SignalAhead(NamedTuple):
    """A traffic light or sign of the route, `distance` [m] along it; `state` as last heard, "" if it never spoke."""

    id: str
    distance: float
    state: str


class View(NamedTuple):
    """What lies ahead of the car: current lane, next junction, crossings and signals within REACH.

    `junction_lanes` are the route's legs through the next junction, `junction_others` the lanes of its other ways.
    Distances are from the rear axle along the route, negative for what it is passing.
    """

    lane: Leg
    in_junction: bool
    junction_distance: float  # m, inf if none
    junction_lanes: tuple[Leg, ...]
    junction_others: tuple[Leg, ...]
    crossings: tuple[CrossingAhead, ...]
    signals: tuple[SignalAhead, ...]


class MapMonitor:
    """Places the map's elements on a reference path once; looking ahead is then cheap."""

    def __init__(self, network: Map, legs: tuple[Leg, ...], path: FloatArray) -> None:
        self._network = network
        self.side = -1.0 if getattr(network, "rule", "RHT") == "LHT" else 1.0
        self.spans = _spans(network, legs, path)
        self.crossings = _crossings(network, path)
        self.signals = _signals(network, self.spans, path)
        self._areas = {str(c.id): np.asarray(c.outline, dtype=np.float64)[:, :2] for c in network.crosswalks}
        self._at = 0
        self._room: Room | None = None
        self._room_s = math.nan

    def view(self, s: float, states: Mapping[str, str] | None = None) -> View:
        """What lies ahead of arc length `s` [m] of the path; `states` of the signals by id, as last heard."""
        heard = states or {}
        spans = self.spans
        while self._at < len(spans) - 1 and s > spans[self._at].s_to:
            self._at += 1
        while self._at > 0 and s < spans[self._at].s_from:
            self._at -= 1
        here = spans[self._at]
        distance = math.inf
        lanes: list[Leg] = []
        for span in spans[self._at :]:
            if span.junction:
                if not lanes:
                    distance = max(span.s_from - s, 0.0)
                lanes.append(span.leg)
            elif lanes:
                break
        return View(
            here.leg,
            here.junction,
            distance,
            tuple(lanes),
            _other_ways(self._network, lanes),
            tuple(
                CrossingAhead(c.id, self._areas[c.id], c.s_from - s, c.s_to - s)
                for c in self.crossings
                if s - PASSING < c.s_to and c.s_from < s + REACH
            ),
            tuple(
                SignalAhead(g.id, g.s - s, heard.get(g.id, "")) for g in self.signals if s - PASSING < g.s < s + REACH
            ),
        )

    def room(self, s: float) -> Room:
        """Room at arc length `s` [m]; no side width where there is no drivable lane or a junction."""
        if s != self._room_s:  # the behaviour asks for the same place twice a tick
            self._room, self._room_s = self._room_at(s), s
        assert self._room is not None
        return self._room

    def half_width(self, s: float) -> float:
        """Half the width [m] of the own lane at arc length `s` [m]."""
        span, at = self._leg_at(s)
        return 0.5 * float(self._network.lane_width(span.leg.road, span.leg.lane, at))

    def _leg_at(self, s: float) -> tuple[LaneSpan, float]:
        """The leg at arc length `s` [m] of the path, and s [m] on its road."""
        for span in self.spans:
            if s <= span.s_to or span is self.spans[-1]:
                break
        leg = span.leg
        share = min(max((s - span.s_from) / max(span.s_to - span.s_from, 1e-6), 0.0), 1.0)
        return span, leg.s_from + share * (leg.s_to - leg.s_from)

    def _room_at(self, s: float) -> Room:
        span, at = self._leg_at(s)
        leg = span.leg
        net = self._network
        half = 0.5 * float(net.lane_width(leg.road, leg.lane, at))
        sign = net.driving_sign(leg.road, leg.lane, at)
        beside = leg.lane + sign * int(self.side)
        if beside == 0:
            beside = sign * int(self.side)
        if span.junction:
            return Room(half, 0.0, False)
        try:
            if net.lane_type(leg.road, beside, at) not in ("driving", "bidirectional", "entry", "exit"):
                return Room(half, 0.0, False)
            width = float(net.lane_width(leg.road, beside, at))
            return Room(half, width, net.driving_sign(leg.road, beside, at) == sign)
        except (KeyError, ValueError, IndexError):
            return Room(half, 0.0, False)


def _spans(network: Map, legs: tuple[Leg, ...], path: FloatArray) -> tuple[LaneSpan, ...]:
    begin = network.lane_pose(legs[0].road, legs[0].lane, legs[0].s_from)
    hint, s, _ = project(path, begin.x, begin.y, 0, 80)
    ends = [float(s)]
    for leg in legs:
        pose = network.lane_pose(leg.road, leg.lane, leg.s_to)
        ahead = int(abs(leg.s_to - leg.s_from) / 0.4) + 40
        hint, s, _ = project(path, pose.x, pose.y, hint, ahead)
        ends.append(max(float(s), ends[-1]))
    return tuple(LaneSpan(leg, _is_junction(network, leg.road), ends[i], ends[i + 1]) for i, leg in enumerate(legs))


def _is_junction(network: Map, road: str) -> bool:
    return _junction(network, road) not in ("-1", "None", "")


def _junction(network: Map, road: str) -> str:
    return str(getattr(network.roads[road], "junction", "-1"))


def _other_ways(network: Map, legs: list[Leg]) -> tuple[Leg, ...]:
    """Lanes in driving direction of the roads that lead through the junction of `legs`, these left out."""
    if not legs:
        return ()
    own = {(leg.road, leg.lane) for leg in legs}
    found = []
    for id, road in network.roads.items():
        if _junction(network, id) != _junction(network, legs[0].road):
            continue
        for lane in road.sections[0].lanes:
            if not lane.drivable or (id, lane.id) in own:
                continue
            ends = (0.0, float(road.length))
            found.append(Leg(id, lane.id, *(ends if network.driving_sign(id, lane.id) > 0 else ends[::-1])))
    return tuple(found)


def _crossings(network: Map, path: FloatArray) -> tuple[Crossing, ...]:
    found = []
    for crosswalk in network.crosswalks:
        outline = np.asarray(crosswalk.outline, dtype=np.float64)[:, :2]
        middle = outline.mean(axis=0)
        reach = float(np.hypot(*(outline - middle).T).max()) + BESIDE
        for i in _passes(path, float(middle[0]), float(middle[1]), reach):
            c, s = math.cos(path[i, YAW]), math.sin(path[i, YAW])
            relative = outline - path[i, X : Y + 1]
            along = path[i, S] + relative @ (c, s)
            across = relative @ (-s, c)
            if across.min() < BESIDE and across.max() > -BESIDE:
                found.append(
                    Crossing(
                        str(crosswalk.id),
                        float(along.min()),
                        float(along.max()),
                        float(across.min()),
                        float(across.max()),
                    )
                )
    return tuple(sorted(found, key=lambda c: c.s_from))


def _passes(path: FloatArray, x: float, y: float, reach: float) -> list[int]:
    """Indices where the path passes a place at less than `reach` [m]; a path may pass it several times."""
    d = np.hypot(path[:, X] - x, path[:, Y] - y)
    close = np.flatnonzero(d < reach)
    if not len(close):
        return []
    groups = np.split(close, np.flatnonzero(np.diff(close) > 1) + 1)
    return [int(g[np.argmin(d[g])]) for g in groups]


def _signals(network: Map, spans: tuple[LaneSpan, ...], path: FloatArray) -> tuple[StopSignal, ...]:
    found = []
    for signal in network.signals:
        for span in spans:
            leg = span.leg
            low, high = min(leg.s_from, leg.s_to), max(leg.s_from, leg.s_to)
            if str(signal.road) != leg.road or not low <= signal.s <= high:
                continue
            if not faces(network, signal, leg.road, leg.lane, leg.s_from):
                continue
            share = abs(signal.s - leg.s_from) / max(high - low, 1e-6)
            found.append(StopSignal(str(signal.id), span.s_from + share * (span.s_to - span.s_from)))
    return tuple(sorted(found, key=lambda g: g.s))


def faces(network: Map, signal: Any, road: str, lane: int, s: float) -> bool:
    """True unless the signal is for the other direction ("+" is for traffic along increasing s) or for other lanes.

    Judged of the traffic of a road's lane at s [m].
    """
    if signal.validity and not any(low <= lane <= high for low, high in signal.validity):
        return False
    orientation, sign = signal.orientation, network.driving_sign(road, lane, s)
    return not ((orientation == "+" and sign < 0) or (orientation == "-" and sign > 0))
