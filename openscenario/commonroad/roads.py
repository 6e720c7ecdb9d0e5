"""Lanelets as OpenDRIVE: those side by side become the lanes of one road, those behind each other are linked.

A road runs along the left bound of its leftmost lanelet of one direction; lanelets of the other direction are its left
lanes. Its reference line is a cubic through the points of that bound (Hermite, with the directions of central
differences), and the width of a lane changes evenly from point to point. Where lanelets of several roads meet, a
junction joins them by connecting roads of 5 cm: in OpenDRIVE, only junctions fork and merge.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, NamedTuple

from openscenario.commonroad.nodes import element
from openscenario.commonroad.source import Lanelet, Point, Source
from openscenario.xml import Node

SHORT: Final = 0.05  # m, of a connecting road; gaps below 0.1 m between roads are none
SAMPLES: Final = 16  # of a cubic, from which its length is taken
STRAIGHT: Final = 1e-6  # rad between directions that are taken for one
MOTORWAYS: Final = ("highway", "interstate", "mainCarriageWay", "accessRamp", "exitRamp")
TYPES: Final = {
    "sidewalk": "sidewalk",
    "crosswalk": "sidewalk",
    "bicycleLane": "biking",
    "border": "border",
    "shoulder": "shoulder",
    "parking": "parking",
    "restricted": "restricted",
}  # all others are lanes to drive on
Bound = list[Point]


class LaneEnd(NamedTuple):
    """An end of a lane: of which road, at its end or its start, and the id of the lane."""

    road: str
    at_end: bool
    lane: int


@dataclass
class Street:
    """Lanelets side by side: `right` in the direction of the road, `left` against it, each from the middle outwards."""

    id: str
    right: list[Lanelet]
    left: list[Lanelet]

    @property
    def middle(self) -> Bound:
        """The line between both directions."""
        return self.right[0].left

    def lanes(self) -> Iterable[tuple[int, Lanelet]]:
        """Lane ids with their lanelets."""
        yield from ((-1 - n, each) for n, each in enumerate(self.right))
        yield from ((1 + n, each) for n, each in enumerate(self.left))


class Line:
    """The reference line of a street: points, directions [rad] and stations [m]."""

    def __init__(self, points: Bound) -> None:
        self.points = points
        last = len(points) - 1
        near = [(points[max(n - 1, 0)], points[min(n + 1, last)]) for n in range(last + 1)]
        self.directions = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in near]
        if last > 1:  # at its ends a bend goes on as it began: exact for a circle
            for end, beside in ((0, 1), (last, last - 1)):
                beyond = math.remainder(self.directions[beside] - self.directions[end], 2.0 * math.pi)
                self.directions[end] -= beyond
        ends = zip(pairwise(points), pairwise(self.directions), strict=True)
        self.pieces = [_Piece(a, b, h, h_end) for (a, b), (h, h_end) in ends]
        self.stations = [0.0]
        for piece in self.pieces:
            self.stations.append(self.stations[-1] + piece.length)

    def offsets(self, bound: Bound) -> list[float]:
        """How far [m] a bound lies to the left, at each point of the line."""
        found = []
        for (x, y), h, (u, v) in zip(self.points, self.directions, resampled(bound, self.points), strict=True):
            found.append((v - y) * math.cos(h) - (u - x) * math.sin(h))
        return found


class _Piece:
    """A cubic between two points in the frame of its start: u and v of p from 0 to 1, with its length [m]."""

    def __init__(self, a: Point, b: Point, h: float, h_end: float) -> None:
        self.x, self.y, self.h = a[0], a[1], h
        chord = math.dist(a, b)
        c, s = math.cos(h), math.sin(h)
        u = (b[0] - a[0]) * c + (b[1] - a[1]) * s
        v = (b[1] - a[1]) * c - (b[0] - a[0]) * s
        turn = math.remainder(h_end - h, 2.0 * math.pi)
        du, dv = chord * math.cos(turn), chord * math.sin(turn)
        self.straight = abs(turn) < STRAIGHT and abs(v) < STRAIGHT * chord
        self.u = (0.0, chord, 3.0 * u - 2.0 * chord - du, chord + du - 2.0 * u)
        self.v = (0.0, 0.0, 3.0 * v - dv, dv - 2.0 * v)
        self.length = chord if self.straight else self._measured()

    def _measured(self) -> float:
        """The length by Simpson's rule."""
        step = 1.0 / SAMPLES
        speeds = [math.hypot(_slope(self.u, n * step), _slope(self.v, n * step)) for n in range(SAMPLES + 1)]
        return step / 3.0 * (speeds[0] + speeds[-1] + 4.0 * sum(speeds[1:-1:2]) + 2.0 * sum(speeds[2:-1:2]))


def _slope(cubic: tuple[float, float, float, float], p: float) -> float:
    return cubic[1] + 2.0 * cubic[2] * p + 3.0 * cubic[3] * p * p


def resampled(bound: Bound, like: Bound) -> Bound:
    """A bound with as many points as another one has, at the same parts of its length; as it is, if it has as many."""
    if len(bound) == len(like):
        return bound
    ways, wanted = _ways(bound), _ways(like)
    found = []
    for way in wanted:
        at = way / wanted[-1] * ways[-1]
        n = min(max(bisect_right(ways, at) - 1, 0), len(bound) - 2)
        part = (at - ways[n]) / (ways[n + 1] - ways[n])
        (x, y), (u, v) = bound[n], bound[n + 1]
        found.append((x + part * (u - x), y + part * (v - y)))
    return found


def _ways(points: Bound) -> list[float]:
    ways = [0.0]
    for a, b in pairwise(points):
        ways.append(ways[-1] + math.dist(a, b))
    return ways


def streets(lanelets: dict[int, Lanelet]) -> list[Street]:
    """The lanelets, each in the street that it belongs to, in the order of the file."""
    seen: set[int] = set()
    found = []
    for lanelet in lanelets.values():
        if lanelet.id in seen:
            continue
        first, passed = lanelet, {lanelet.id}  # lanelets of a broken file may stand in a circle
        while (left := _beside(lanelets, first.at_left, same=True)) is not None and left.id not in seen | passed:
            first = left
            passed.add(left.id)
        right = _rightwards(lanelets, first, seen)
        facing = _beside(lanelets, first.at_left, same=False)
        left_side = [] if facing is None or facing.id in seen else _rightwards(lanelets, facing, seen)
        found.append(Street(str(first.id), right, left_side))
    return found


def _beside(lanelets: dict[int, Lanelet], neighbour: tuple[int, bool] | None, *, same: bool) -> Lanelet | None:
    return lanelets.get(neighbour[0]) if neighbour is not None and neighbour[1] is same else None


def _rightwards(lanelets: dict[int, Lanelet], first: Lanelet, seen: set[int]) -> list[Lanelet]:
    """A lanelet and those to its right that are driven the same way and are in no street yet."""
    found: list[Lanelet] = []
    following: Lanelet | None = first
    while following is not None and following.id not in seen:
        seen.add(following.id)
        found.append(following)
        following = _beside(lanelets, following.at_right, same=True)
    return found


class Map:
    """Where each lanelet is: its road, its lane, and the line of the road."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.streets = streets(source.lanelets)
        self.lines = {street.id: Line(street.middle) for street in self.streets}
        self.places = {lanelet.id: (street.id, lane) for street in self.streets for lane, lanelet in street.lanes()}

    def ends(self, lanelet: int) -> tuple[LaneEnd, LaneEnd]:
        """Where a lanelet begins and ends."""
        road, lane = self.places[lanelet]
        return LaneEnd(road, lane > 0, lane), LaneEnd(road, lane < 0, lane)

    def length(self, road: str) -> float:
        """Length [m] of a road."""
        return self.lines[road].stations[-1]

    def links(self) -> list[tuple[LaneEnd, LaneEnd]]:
        """(end of a lane, beginning of the one after it), each once; what leads out of the file is left out."""
        pairs: dict[tuple[LaneEnd, LaneEnd], None] = {}
        for lanelet in self.source.lanelets.values():
            known = [(lanelet.id, other) for other in lanelet.after] + [(other, lanelet.id) for other in lanelet.before]
            for a, b in known:
                if a in self.places and b in self.places:
                    pairs[(self.ends(a)[1], self.ends(b)[0])] = None
        return list(pairs)


def opendrive(source: Source) -> Node:
    """The file's lanelets as the root of an OpenDRIVE file of version 1.8."""
    net = Map(source)
    direct, joined = _sorted_out(net.links())
    roads = [_road(net, street, direct, joined) for street in net.streets]
    junctions: dict[str, list[Node]] = {}
    for number, (a, b) in enumerate(pair for pairs in joined.values() for pair in pairs):
        junction = _junction_of(a, joined)
        connector = f"c{number}"
        roads.append(_connector(net, connector, junction, (a, b)))
        connection = element(
            "connection", 1, element("laneLink", 1, **{"from": str(a.lane), "to": "-1"}),
            id=str(number), incomingRoad=a.road, connectingRoad=connector, contactPoint="start",
        )  # fmt: skip
        junctions.setdefault(junction, []).append(connection)
    nodes = [element("junction", 1, *connections, id=name, name="") for name, connections in junctions.items()]
    header = element("header", 1, revMajor="1", revMinor="8", name=source.name)
    return element("OpenDRIVE", 1, header, *roads, *nodes)


Pair = tuple[LaneEnd, LaneEnd]
RoadEnd = tuple[str, bool]


def _sorted_out(pairs: list[Pair]) -> tuple[dict[RoadEnd, list[Pair]], dict[str, list[Pair]]]:
    """Links between two ends of roads that meet nobody else, by either end; and those of junctions, by name."""
    meets: dict[RoadEnd, set[RoadEnd]] = {}
    for a, b in pairs:
        meets.setdefault(a[:2], set()).add(b[:2])
        meets.setdefault(b[:2], set()).add(a[:2])
    direct: dict[RoadEnd, list[Pair]] = {}
    joined: dict[str, list[Pair]] = {}
    names: dict[RoadEnd, str] = {}
    for a, b in pairs:
        if a[:2] != b[:2] and meets[a[:2]] == {b[:2]} and meets[b[:2]] == {a[:2]}:
            direct.setdefault(a[:2], []).append((a, b))
            direct.setdefault(b[:2], []).append((a, b))
            continue
        if a[:2] not in names:  # a junction is all ends that hang together
            name, open_ends = f"j{len(joined)}", [a[:2]]
            joined[name] = []
            while open_ends:
                end = open_ends.pop()
                if end not in names:
                    names[end] = name
                    open_ends.extend(meets[end])
        joined[names[a[:2]]].append((a, b))
    return direct, joined


def _junction_of(end: LaneEnd, joined: dict[str, list[Pair]]) -> str:
    return next(name for name, pairs in joined.items() if any(end in pair for pair in pairs))


def _road(net: Map, street: Street, direct: dict[RoadEnd, list[Pair]], joined: dict[str, list[Pair]]) -> Node:
    """A street as a road."""
    line, at = net.lines[street.id], street.right[0].line
    ends = {end[:2]: name for name, pairs in joined.items() for pair in pairs for end in pair}
    links = []
    for tag, at_end in (("predecessor", False), ("successor", True)):
        here = (street.id, at_end)
        if here in direct:
            there = next(end for end in direct[here][0] if end[:2] != here)
            contact = "end" if there.at_end else "start"
            links.append(element(tag, at, elementType="road", elementId=there.road, contactPoint=contact))
        elif here in ends:
            links.append(element(tag, at, elementType="junction", elementId=ends[here]))
    plan = [_geometry(piece, s, at) for piece, s in zip(line.pieces, line.stations, strict=False)]
    left = _lanes(street.id, line, street.left, 1, direct)
    right = _lanes(street.id, line, street.right, -1, direct)
    centre = element("center", at, element("lane", at, id="0", type="none", level="false"))
    groups = [element("left", at, *reversed(left))] if left else []
    section = element("laneSection", at, *groups, centre, element("right", at, *right), s=0.0)
    kinds = frozenset[str]().union(*(lanelet.kinds for _, lanelet in street.lanes()))
    kind = "motorway" if kinds & set(MOTORWAYS) else "rural" if "country" in kinds else "town"
    return element(
        "road", at, element("link", at, *links), element("type", at, s=0.0, type=kind),
        element("planView", at, *plan), element("lanes", at, section),
        name="", id=street.id, length=net.length(street.id), junction="-1", rule="RHT",
    )  # fmt: skip


def _lanes(road: str, line: Line, members: list[Lanelet], sign: int, direct: dict[RoadEnd, list[Pair]]) -> list[Node]:
    """The lanelets of one side as lanes, from the middle outwards; sign: 1 to the left, -1 to the right."""
    inner, nodes = [0.0] * len(line.points), []
    for n, lanelet in enumerate(members, start=1):
        outer = line.offsets(lanelet.right if sign < 0 else lanelet.right[::-1])
        widths = [max(sign * (b - a), 0.0) for a, b in zip(inner, outer, strict=True)]
        links = _lane_links(road, sign * n, direct)
        nodes.append(_lane(lanelet, sign * n, (line.stations, widths), links))
        inner = outer
    return nodes


def _geometry(piece: _Piece, s: float, line: int) -> Node:
    if piece.straight:
        shape = element("line", line)
    else:
        names = zip(("aU", "bU", "cU", "dU", "aV", "bV", "cV", "dV"), (*piece.u, *piece.v), strict=True)
        shape = element("paramPoly3", line, pRange="normalized", **dict(names))
    return element("geometry", line, shape, s=s, x=piece.x, y=piece.y, hdg=piece.h, length=piece.length)


def _lane_links(road: str, lane: int, direct: dict[RoadEnd, list[Pair]]) -> list[tuple[str, int]]:
    """(predecessor or successor, lane there) of a lane whose road is linked to another one."""
    found: dict[tuple[str, int], None] = {}
    for tag, at_end in (("predecessor", False), ("successor", True)):
        for pair in direct.get((road, at_end), ()):
            mine, other = pair if pair[0][:2] == (road, at_end) else (pair[1], pair[0])
            if mine.lane == lane:
                found[(tag, other.lane)] = None
    return list(found)


def _lane(lanelet: Lanelet, number: int, widths: tuple[list[float], list[float]], links: list[tuple[str, int]]) -> Node:
    """A lanelet as a lane, with its widths [m] at stations [m]."""
    line = lanelet.line
    parts = [element("link", line, *(element(tag, line, id=str(other)) for tag, other in links))]
    stations, values = widths
    for n in range(len(stations) - 1):
        slope = (values[n + 1] - values[n]) / (stations[n + 1] - stations[n])
        parts.append(element("width", line, sOffset=stations[n], a=values[n], b=slope, c=0.0, d=0.0))
    return element("lane", line, *parts, *_limit(lanelet), id=str(number), type=_type(lanelet), level="false")


def _type(lanelet: Lanelet) -> str:
    return next((TYPES[each] for each in sorted(lanelet.kinds) if each in TYPES), "driving")


def _limit(lanelet: Lanelet) -> list[Node]:
    if lanelet.speed is None:
        return []
    return [element("speed", lanelet.line, sOffset=0.0, max=lanelet.speed, unit="m/s")]


def _connector(net: Map, name: str, junction: str, pair: Pair) -> Node:
    """The short road of a junction from the end of a lane to the beginning of the next; a lane of the first's kind."""
    a, b = pair
    line = net.lines[a.road]
    n = len(line.points) - 1 if a.at_end else 0
    street = next(each for each in net.streets if each.id == a.road)
    members = street.right if a.lane < 0 else street.left
    bounds = [each.right if a.lane < 0 else each.right[::-1] for each in members[: abs(a.lane)]]
    edges = [0.0, *(line.offsets(each)[n] for each in bounds)]
    h = line.directions[n]
    (x, y), t = line.points[n], edges[-2]
    x, y = x - t * math.sin(h), y + t * math.cos(h)
    h += 0.0 if a.at_end else math.pi
    width = max(abs(edges[-1] - edges[-2]), 0.01)
    lanelet = members[abs(a.lane) - 1]
    at = lanelet.line
    links = [
        element(tag, at, elementType="road", elementId=end.road, contactPoint="end" if end.at_end else "start")
        for tag, end in (("predecessor", a), ("successor", b))
    ]
    lane_link = element(
        "link", at, element("predecessor", at, id=str(a.lane)), element("successor", at, id=str(b.lane))
    )
    lane = element(
        "lane", at, lane_link, element("width", at, sOffset=0.0, a=width, b=0.0, c=0.0, d=0.0), *_limit(lanelet),
        id="-1", type=_type(lanelet), level="false",
    )  # fmt: skip
    centre = element("center", at, element("lane", at, id="0", type="none", level="false"))
    section = element("laneSection", at, centre, element("right", at, lane), s=0.0)
    plan = element("geometry", at, element("line", at), s=0.0, x=x, y=y, hdg=h, length=SHORT)
    return element(
        "road", at, element("link", at, *links), element("planView", at, plan), element("lanes", at, section),
        name="", id=name, length=SHORT, junction=junction, rule="RHT",
    )  # fmt: skip
