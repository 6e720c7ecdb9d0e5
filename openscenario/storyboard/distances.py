"""Distances between entities, or to a place, in the standard's coordinate systems.

Source: ASAM OpenSCENARIO XML 1.3, section "Distances". A signed distance is positive ahead of (left of) the entity
it is measured from; `free` distances are those between the bounding boxes, 0 where they overlap in that direction.
Distances along the road follow the reference lines; None where no road leads from one to the other.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from openscenario.road.positions import RoadPosition
from openscenario.storyboard.actions.trajectory import FollowTrajectory
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.places import Place
from openscenario.storyboard.road_extents import road_extent
from openscenario.storyboard.trailers import couples

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board
    from openscenario.storyboard.ground import Ground

Corners = tuple[tuple[float, float], ...]
Measure = Callable[[], float | None]
"""Signed distance [m] now; None where it is not defined."""


class Span(NamedTuple):
    """Extent of a box along an axis."""

    low: float
    high: float


def gap(ours: Span, theirs: Span, side: float = 0.0) -> float:
    """Signed distance between two intervals, 0 where they overlap.

    With a side, that between the ends which face each other when they are beyond us (side > 0) or we beyond them
    (side < 0), wherever both are: its sign turns where they overlap or are the other way round.
    """
    if side > 0.0:
        return theirs.low - ours.high
    if side < 0.0:
        return theirs.high - ours.low
    if theirs.low > ours.high:
        return theirs.low - ours.high
    if theirs.high < ours.low:
        return theirs.high - ours.low
    return 0.0


def box_distance(a: Corners, b: Corners) -> float:
    """Smallest distance [m] between two convex boxes, 0 where they overlap."""
    if overlap(a, b):
        return 0.0
    return min(min(_to_edges(point, b) for point in a), min(_to_edges(point, a) for point in b))


def overlap(a: Corners, b: Corners) -> bool:
    """Whether two boxes overlap (separating axis test)."""
    for box in (a, b):
        for i in (0, 1):
            nx, ny = box[i][1] - box[i + 1][1], box[i + 1][0] - box[i][0]
            first = [nx * u + ny * v for u, v in a]
            second = [nx * u + ny * v for u, v in b]
            if max(first) < min(second) or max(second) < min(first):
                return False
    return True


def _to_edges(point: tuple[float, float], box: Corners) -> float:
    px, py = point
    best = math.inf
    for i, (x, y) in enumerate(box):
        u, v = box[(i + 1) % len(box)]
        dx, dy = u - x, v - y
        square = dx * dx + dy * dy
        share = min(max(((px - x) * dx + (py - y) * dy) / square, 0.0), 1.0) if square > 0.0 else 0.0
        best = min(best, math.hypot(px - x - share * dx, py - y - share * dy))
    return best


def measure(
    board: Board,
    entity: Entity,
    target: Entity | Callable[[], Place],
    *,
    kind: str | None,
    system: str | None,
    free: bool,
    side: float = 0.0,
) -> Measure:
    """How to measure from `entity` to another one or to a place.

    kind: longitudinal, lateral, euclidianDistance (cartesianDistance), None (euclidian) or alongRoute (euclidian in
    road coordinates: turns of the road lengthen it); system: entity, lane, road, trajectory, world or None (entity).
    Lane coordinates count as road coordinates; those of a trajectory are there while `entity` follows one, and only
    then. Trailers belong to who draws them: `free` distances are the smallest of those between the parts.
    side: of a free longitudinal or lateral distance, as for `gap`.
    """
    if free:
        return _of_parts(entity, target, side, lambda part, goal: _measure(board, part, goal, kind, system, free, side))
    return _measure(board, entity, target, kind, system, free, side)


def _measure(
    board: Board,
    entity: Entity,
    target: Entity | Callable[[], Place],
    kind: str | None,
    system: str | None,
    free: bool,
    side: float,
) -> Measure:
    if kind in (None, "euclidianDistance", "cartesianDistance"):
        return _euclidian(entity, target, free)
    if kind == "alongRoute":
        return _along_route(board, entity, target, free)
    lateral = kind == "lateral"
    if system == "trajectory":
        return _along_trajectory(entity, target, lateral, free, side)
    if system in ("road", "lane") and board.network is not None:
        return _along_road(board.ground, entity, target, lateral, free, side)
    if system == "world":
        return _along_axis(entity, target, free, lambda: 0.5 * math.pi if lateral else 0.0, side)
    return _along_axis(entity, target, free, lambda: entity.h + (0.5 * math.pi if lateral else 0.0), side)


def _of_parts(
    entity: Entity,
    target: Entity | Callable[[], Place],
    side: float,
    between: Callable[[Entity, Entity | Callable[[], Place]], Measure],
) -> Measure:
    """The smallest distance from an entity or what hangs on it to another, or what hangs on that; to a side, the one
    that leaves least room there.

    The standard says nothing about trailers here; distances between parts of one train are those between these parts.
    """
    whole = between(entity, target)

    def nearer(apart: float) -> float:
        return apart * side if side else abs(apart)

    parts: dict[tuple[str, str], Measure] = {}

    def run() -> float | None:
        ours = couples(entity)
        theirs = couples(target) if isinstance(target, Entity) else ()
        if (len(ours) <= 1 and len(theirs) <= 1) or target in ours:
            return whole()
        best: float | None = None
        for mine in ours:
            for other in theirs or (target,):
                key = mine.name, other.name if isinstance(other, Entity) else ""
                if key not in parts:
                    parts[key] = between(mine, other)
                apart = parts[key]()
                if apart is not None and (best is None or (nearer(apart) < nearer(best))):
                    best = apart
        return best

    return run


def _extent(target: Entity | Place, axis: float) -> tuple[float, float]:
    """How far a target reaches back and ahead of its reference point along `axis`; a place is a point."""
    return target.extent(axis) if isinstance(target, Entity) else (0.0, 0.0)


def _now(target: Entity | Callable[[], Place]) -> Callable[[], Entity | Place]:
    return (lambda: target) if isinstance(target, Entity) else target


def _euclidian(entity: Entity, target: Entity | Callable[[], Place], free: bool) -> Measure:
    now = _now(target)

    def run() -> float:
        there = now()
        if not free:
            return math.hypot(there.x - entity.x, there.y - entity.y)
        ours = entity.corners()
        if isinstance(there, Entity):
            return box_distance(ours, there.corners())
        point = (there.x, there.y)
        inside = overlap(ours, (point, point, point, point))
        return 0.0 if inside else _to_edges(point, ours)

    return run


def _along_route(board: Board, entity: Entity, target: Entity | Callable[[], Place], free: bool) -> Measure:
    if board.network is None:
        return _euclidian(entity, target, free)
    ahead = _along_road(board.ground, entity, target, False, free)
    aside = _along_road(board.ground, entity, target, True, free)

    def run() -> float | None:
        along, across = ahead(), aside()
        if along is None or across is None:
            return None
        apart = math.hypot(along, across)
        return -apart if along < 0.0 else apart

    return run


def _along_axis(
    entity: Entity, target: Entity | Callable[[], Place], free: bool, axis: Callable[[], float], side: float = 0.0
) -> Measure:
    now = _now(target)

    def run() -> float:
        there = now()
        direction = axis()
        if not free:
            return (there.x - entity.x) * math.cos(direction) + (there.y - entity.y) * math.sin(direction)
        apart = (there.x - entity.x) * math.cos(direction) + (there.y - entity.y) * math.sin(direction)
        low, high = _extent(there, direction)
        return gap(Span(*entity.extent(direction)), Span(apart + low, apart + high), side)

    return run


def _along_trajectory(
    entity: Entity, target: Entity | Callable[[], Place], lateral: bool, free: bool, side: float
) -> Measure:
    """In s and t of the trajectory that the entity follows; extents are those along its direction at either place."""
    now = _now(target)

    def run() -> float | None:
        follower = entity.lateral
        if not isinstance(follower, FollowTrajectory):
            return None
        there = now()
        here, (s, t, h) = follower.axis()[0], follower.beside(there.x, there.y)
        sense = 1.0 if math.cos(entity.h - here) >= 0.0 else -1.0  # rear first: ahead is where it faces
        apart = (t if lateral else s) * sense
        if not free:
            return apart
        turn = (0.5 * math.pi if lateral else 0.0) + (0.0 if sense > 0.0 else math.pi)
        low, high = _extent(there, h + turn)
        return gap(Span(*entity.extent(here + turn)), Span(apart + low, apart + high), side)

    return run


def _along_road(
    ground: Ground, entity: Entity, target: Entity | Callable[[], Place], lateral: bool, free: bool, side: float = 0.0
) -> Measure:
    now = _now(target)

    def run() -> float | None:
        there = now()
        here = ground.position(entity)
        goal = ground.position(there) if isinstance(there, Entity) else ground.position_of(there)
        sign = entity.sense
        # the other road may run the other way: what counts is its direction as seen from here
        same = ground.turned(here, goal) > 0.0
        if lateral:
            apart = (goal.t if same else -goal.t) - here.t
        else:
            apart = ground.distance(here, goal)
            if apart != apart:
                return None
        apart *= sign
        if not free:
            return apart
        ours = _seen(road_extent(ground, entity, here, lateral=lateral), sign)
        theirs = road_extent(ground, there, goal, lateral=lateral) if isinstance(there, Entity) else (0.0, 0.0)
        low, high = _seen(theirs, sign if same else -sign)
        return gap(ours, Span(apart + low, apart + high), side)

    return run


def _seen(reach: tuple[float, float], sign: float) -> Span:
    """An extent as seen by who faces with (+1) or against (-1) its axis."""
    low, high = reach
    return Span(low, high) if sign > 0.0 else Span(-high, -low)


__all__ = ["Measure", "RoadPosition", "box_distance", "gap", "measure", "overlap"]
