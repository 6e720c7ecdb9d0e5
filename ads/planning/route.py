"""Route: which lanes to drive, from the task and the lane graph of the map."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol

from vehicle.messages import FloatArray, RoadPoint, Task

FOLLOW_STEP = 2.0  # m
GONE = 1.0  # m, of a lane at its end: no car goes on in it
ROOMY = 2.5  # m, in which a car of 1.8 m has 0.35 m to each side; chosen
JUST_BEFORE = 0.01  # m


class Leg(NamedTuple):
    """A piece of one lane, from s_from to s_to [m] in driving direction."""

    road: str
    lane: int
    s_from: float
    s_to: float


class Map(Protocol):
    """What the stack needs of openscenario.road.network.RoadNetwork."""

    @property
    def roads(self) -> Any:
        """Road id to road; a road has `length` [m] and `junction`."""

    @property
    def crosswalks(self) -> Any:
        """Crossings with id, road, s, outline (k, 2) [m], s_from, s_to."""

    @property
    def signals(self) -> Any:
        """Signals with id, road, s [m], orientation, validity, type and country."""

    def locate(self, x: float, y: float, h: float | None = None, hint: Any = None) -> Any:
        """Nearest drivable lane: road, lane, s, t, offset, h_road, on_road."""

    def lane_pose(self, road: str, lane: int, s: float, offset: float = 0.0) -> Any:
        """Pose x, y, z, h, ... of a lane's middle; h along increasing s."""

    def lane_width(self, road: str, lane: int, s: float) -> float:
        """Width [m]."""

    def lane_type(self, road: str, lane: int, s: float) -> str:
        """Type as in the file."""

    def driving_sign(self, road: str, lane: int, s: float = 0.0) -> int:
        """+1 if traffic goes with increasing s."""

    def advance(self, position: Any, ds: float) -> Any:
        """The position `ds` [m] further along its lane; straight on where lanes part."""

    def dead_end(self, position: Any) -> bool:
        """Whether a lane leads nowhere from here."""

    def route(self, start: Any, goal: Any) -> Any:
        """Cheapest legs from start to goal."""

    def centreline(self, route: Any, step: float = 0.5) -> FloatArray:
        """(n, 4): x, y [m], heading in driving direction [rad], curvature [1/m]."""


class Route(NamedTuple):
    """Legs in order; `to_goal` is False for a lane that is merely followed."""

    legs: tuple[Leg, ...]
    to_goal: bool


def lane_heading(network: Map, road: str, lane: int, s: float) -> float:
    """Direction of traffic [rad] in the middle of a lane."""
    h: float = network.lane_pose(road, lane, s).h
    return h if network.driving_sign(road, lane, s) > 0 else h + math.pi


def follow(network: Map, road: str, lane: int, s: float, length: float) -> tuple[Leg, ...]:
    """Legs that keep to a lane for `length` [m], at a junction the way that turns least; shorter at a dead end."""
    pose = network.lane_pose(road, lane, s)
    at = network.locate(pose.x, pose.y)._replace(road=road, lane=lane, s=s, offset=0.0)
    legs = [Leg(road, lane, s, s)]
    for _ in range(math.ceil(length / FOLLOW_STEP)):
        after = network.advance(at, FOLLOW_STEP)._replace(offset=0.0)
        last = legs[-1]
        if str(after.road) != last.road:
            legs[-1] = last._replace(s_to=_ends(network, last.road, last.lane, last.s_to)[1])
            begin = _ends(network, str(after.road), int(after.lane), after.s)[0]
            legs.append(Leg(str(after.road), int(after.lane), begin, float(after.s)))
        elif after.lane != last.lane:  # lanes are numbered anew in another section
            legs[-1] = last._replace(s_to=float(after.s))
            legs.append(Leg(last.road, int(after.lane), float(after.s), float(after.s)))
        else:
            legs[-1] = last._replace(s_to=float(after.s))
        if network.dead_end(after):
            break
        at = after
    return tuple(piece for leg in legs if leg.s_from != leg.s_to for piece in _merging(network, leg))


def _merging(network: Map, leg: Leg) -> tuple[Leg, ...]:
    """A leg, on a lane that narrows to nothing only as far as it is wide enough, and then on the lane beside it."""
    road, lane, s_from, s_to = leg
    forward = 1.0 if s_to > s_from else -1.0
    if network.lane_width(road, lane, s_to - forward * JUST_BEFORE) > GONE:
        return (leg,)
    s = s_to
    while forward * (s - s_from) > 0.0 and network.lane_width(road, lane, s) < ROOMY:
        s -= forward * FOLLOW_STEP
    beside = (other for other in (lane - 1, lane + 1) if other * lane > 0)
    there = s_to - forward * JUST_BEFORE
    for other in beside:
        if network.lane_type(road, other, there) == "driving" and network.lane_width(road, other, there) >= ROOMY:
            return (leg._replace(s_to=s), Leg(road, other, s, s_to)) if forward * (s - s_from) > 0.0 else (leg,)
    return (leg,)


def _ends(network: Map, road: str, lane: int, s: float) -> tuple[float, float]:
    """s [m] where traffic enters and leaves a road on the lane that is `lane` at `s`."""
    length = float(network.roads[road].length)
    return (0.0, length) if network.driving_sign(road, lane, s) > 0 else (length, 0.0)


def to_goal(route: Callable[[RoadPoint, RoadPoint], Sequence[Any]], start: RoadPoint, task: Task) -> tuple[Leg, ...]:
    """Legs from `start` over the route's points, those already behind left out, to the goal (or the last point)."""
    points = list(task.route)
    if task.goal is not None:
        points.append(task.goal)
    legs: list[Leg] = []
    at = start
    for point in points:
        if _same_place(at, point):
            continue
        piece = [Leg(str(leg.road), int(leg.lane), float(leg.s_from), float(leg.s_to)) for leg in route(at, point)]
        if legs and piece and (legs[-1].road, legs[-1].lane) == (piece[0].road, piece[0].lane):
            first = piece.pop(0)
            legs[-1] = legs[-1]._replace(s_to=first.s_to)
        legs.extend(piece)
        at = point
    return tuple(legs)


def _same_place(a: RoadPoint, b: RoadPoint) -> bool:
    return a.road == b.road and a.lane == b.lane and abs(a.s - b.s) < 1.0


def continued(network: Map, legs: tuple[Leg, ...], length: float) -> tuple[Leg, ...]:
    """`legs` and what follows behind their end for `length` [m], so that a path does not end at the goal."""
    last = legs[-1]
    more = list(follow(network, last.road, last.lane, last.s_to, length))
    if more and (more[0].road, more[0].lane) == (last.road, last.lane):
        return (*legs[:-1], last._replace(s_to=more[0].s_to), *more[1:])
    return (*legs, *more)
