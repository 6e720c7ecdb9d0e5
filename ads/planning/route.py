"""Route: which lanes to drive, from the task and the lane graph of the map."""

from __future__ import annotations

import math
from typing import Any, NamedTuple, Protocol

from ads.transforms import wrap_angle
from vehicle.messages import FloatArray, RoadPoint, Task

LARGEST_TURN = math.radians(100.0)


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
        """Signals with id, road, s [m]."""

    def locate(self, x: float, y: float, h: float | None = None, hint: Any = None) -> Any:
        """Nearest drivable lane: road, lane, s, t, offset, h_road, on_road."""

    def lane_pose(self, road: str, lane: int, s: float, offset: float = 0.0) -> Any:
        """Pose x, y, z, h, ... of a lane's middle; h along increasing s."""

    def lane_width(self, road: str, lane: int, s: float) -> float:
        """Width [m]."""

    def lane_type(self, road: str, lane: int, s: float) -> str:
        """Type as in the file."""

    def driving_sign(self, road: str, lane: int) -> int:
        """+1 if traffic goes with increasing s."""

    def lane_successors(self, road: str, lane: int) -> Any:
        """(road, lane) pairs that follow in driving direction."""

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
    return h if network.driving_sign(road, lane) > 0 else h + math.pi


def follow(network: Map, road: str, lane: int, s: float, length: float) -> tuple[Leg, ...]:
    """Legs that keep to a lane for `length` [m]; at a junction the way that turns least, lower road id first."""
    legs: list[Leg] = []
    left = length
    while left > 0.0 and len(legs) < 500:
        forward = network.driving_sign(road, lane) > 0
        end = float(network.roads[road].length) if forward else 0.0
        piece = abs(end - s)
        if piece > left:
            end = s + left if forward else s - left
        if abs(end - s) > 1e-6:
            legs.append(Leg(road, lane, s, end))
        left -= piece
        if left <= 0.0:
            break
        arriving = lane_heading(network, road, lane, end)
        best: tuple[float, str, int] | None = None
        for next_road, next_lane in network.lane_successors(road, lane):
            ahead = network.driving_sign(next_road, next_lane) > 0
            far = float(network.roads[next_road].length) if ahead else 0.0
            turn = abs(wrap_angle(lane_heading(network, next_road, next_lane, far) - arriving))
            choice = (round(turn, 3), str(next_road), int(next_lane))
            if best is None or choice < best:
                best = choice
        if best is None:
            break
        road, lane = best[1], best[2]
        s = 0.0 if network.driving_sign(road, lane) > 0 else float(network.roads[road].length)
    return tuple(legs)


def to_goal(network: Map, start: RoadPoint, task: Task) -> tuple[Leg, ...]:
    """Legs from `start` over the route's points, those already behind left out, to the goal (or the last point)."""
    points = list(task.route)
    if task.goal is not None:
        points.append(task.goal)
    legs: list[Leg] = []
    at = start
    for point in points:
        if _same_place(at, point):
            continue
        piece = [Leg(str(leg.road), int(leg.lane), float(leg.s_from), float(leg.s_to)) for leg in
                 network.route(tuple(at), tuple(point))]  # fmt: skip
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
