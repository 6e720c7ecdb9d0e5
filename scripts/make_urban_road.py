"""Make scenarios/urban.xodr: a two-way urban loop with bends, a T junction, a side road and a crosswalk.

    python -m scripts.make_urban_road [FILE]

The loop is a polygon of right angles whose corners are replaced by clothoid - arc - clothoid bends. A bend is
symmetric, so it meets both legs of its corner at the same distance; each straight is the leg less the two distances,
and the loop closes exactly, without a search. Same input, same bytes.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from itertools import pairwise
from math import atan2, cos, hypot, isclose, pi, sin
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np

LANE = 3.5  # m, width of a driving lane
WALK = 2.0  # m, width of a sidewalk
SPEED = 30  # km/h, the paper's scenarios stay below it
ARM = 14.0  # m, from the centre of the junction to where its roads begin
CROSSWALK = ("north", 46.0, 3.0)  # street, s of its middle, extent along the road [m]
LIGHT = ("south", 130.0)  # street, s of the traffic light for the right lane [m]
JUNCTION_ID = "100"
# Corner x, y [m], arc radius [m], length of each clothoid [m]. Counter-clockwise, so lane -1 is the outer one.
CORNERS = (
    (0.0, 0.0, 15.0, 10.0),
    (200.0, 0.0, 15.0, 10.0),
    (200.0, 61.0, 18.0, 12.0),
    (115.0, 61.0, 20.0, 12.0),  # the only right-hand bend
    (115.0, 122.0, 15.0, 10.0),
    (0.0, 122.0, 15.0, 10.0),
)
JUNCTION = (0.0, 61.0)
SIDE_ROAD = 60.0  # m

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)


@dataclass(frozen=True)
class Piece:
    """A piece of a reference line: start pose [m, rad], length [m], curvature at both ends [1/m]."""

    x: float
    y: float
    heading: float
    length: float
    k0: float = 0.0
    k1: float = 0.0

    def end(self) -> tuple[float, float, float]:
        """Pose at the end: Gauss-Legendre quadrature of the heading, exact to 1e-14 m for bends of this size."""
        s = 0.5 * self.length * (_NODES + 1.0)
        heading = self.heading + self.k0 * s + 0.5 * (self.k1 - self.k0) / self.length * s * s
        half = 0.5 * self.length
        turned = self.heading + 0.5 * (self.k0 + self.k1) * self.length
        x = self.x + half * float(_WEIGHTS @ np.cos(heading))
        return x, self.y + half * float(_WEIGHTS @ np.sin(heading)), turned


def bend(x: float, y: float, heading: float, angle: float, radius: float, clothoid: float) -> list[Piece]:
    """Clothoid, arc, clothoid that turn by `angle` [rad], left positive."""
    k = (1.0 if angle > 0 else -1.0) / radius
    arc = abs(angle) * radius - clothoid
    pieces: list[Piece] = []
    for length, k0, k1 in ((clothoid, 0.0, k), (arc, k, k), (clothoid, k, 0.0)):
        pieces.append(Piece(x, y, heading, length, k0, k1))
        x, y, heading = pieces[-1].end()
    return pieces


def tangent(radius: float, clothoid: float) -> float:
    """Distance [m] from a right-angled corner to where its bend begins."""
    return bend(0.0, 0.0, 0.0, pi / 2, radius, clothoid)[-1].end()[0]


def turn_radius(reach: float, clothoid: float) -> float:
    """Radius [m] of the right-angled bend that begins `reach` [m] before its corner; bisection to the last bit."""
    low, high = clothoid, reach
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if tangent(middle, clothoid) < reach else (low, middle)
    return 0.5 * (low + high)


def straight(start: tuple[float, float], end: tuple[float, float]) -> Piece:
    dx, dy = end[0] - start[0], end[1] - start[1]
    return Piece(*start, atan2(dy, dx), hypot(dx, dy))


def streets() -> dict[str, list[Piece]]:
    """Reference lines of the loop's roads in driving order of lane -1, from the junction round to it."""
    legs: list[Piece] = []
    bends: list[list[Piece]] = []
    points = [(x, y, tangent(r, c), r, c) for x, y, r, c in CORNERS]
    for (ax, ay, at, _, _), (bx, by, bt, radius, clothoid), (cx, cy, *_) in zip(
        points, points[1:] + points[:1], points[2:] + points[:2], strict=True
    ):
        heading = atan2(by - ay, bx - ax)
        ux, uy = cos(heading), sin(heading)
        legs.append(straight((ax + at * ux, ay + at * uy), (bx - bt * ux, by - bt * uy)))
        turn = atan2(ux * (cy - by) - uy * (cx - bx), ux * (cx - bx) + uy * (cy - by))
        bends.append(bend(bx - bt * ux, by - bt * uy, heading, turn, radius, clothoid))
    south, east, mill_a, mill_b, north, west = legs
    se, ne, mill_bend, nw_in, nw, sw = bends
    x, y = JUNCTION
    north_arm = straight((west.x, west.y), (x, y + ARM))
    south_arm = straight((x, y - ARM), (x, sw[0].y))
    return {
        "west": [south_arm, *sw],
        "south": [south],
        "east": [*se, east, *ne],
        "mill": [mill_a, *mill_bend, mill_b, *nw_in],
        "north": [north],
        "harbour": [*nw, north_arm],
        "side": [straight((x - ARM, y), (x - ARM - SIDE_ROAD, y))],
    }


def check_chain(pieces: list[Piece]) -> None:
    for before, after in pairwise(pieces):
        x, y, heading = before.end()
        gap = hypot(after.x - x, after.y - y)
        if gap > 1e-9 or not isclose(cos(heading - after.heading), 1.0, abs_tol=1e-12):
            raise AssertionError(f"gap of {gap} m at {after}")


@dataclass(frozen=True)
class Turn:
    """A connecting road: where it comes from and goes to, as (road, lane, contact point), and whether it has a walk."""

    id: str
    start: tuple[str, int, str]
    end: tuple[str, int, str]
    pieces: list[Piece]
    walk: bool


ROAD_IDS = {"west": "1", "south": "2", "east": "3", "mill": "4", "north": "5", "harbour": "6", "side": "7"}
ROAD_NAMES = {
    "west": "West Street",
    "south": "South Street",
    "east": "East Street",
    "mill": "Mill Lane",
    "north": "North Street",
    "harbour": "Harbour Street",
    "side": "Garden Road",
}


def turns() -> list[Turn]:
    """The six ways through the junction. Reference line: left border of the one driving lane."""
    x, y = JUNCTION
    clothoid = 6.0
    radius = turn_radius(ARM, clothoid)
    from_north, from_south, from_side = (x, y + ARM, -pi / 2), (x, y - ARM, pi / 2), (x - ARM, y, 0.0)
    north_in, north_out = ("6", -1, "end"), ("6", 1, "end")
    south_in, south_out = ("1", 1, "start"), ("1", -1, "start")
    side_in, side_out = ("7", 1, "start"), ("7", -1, "start")
    right, left = -pi / 2, pi / 2
    return [
        Turn("11", north_in, south_out, [Piece(*from_north, 2 * ARM)], False),
        Turn("12", south_in, north_out, [Piece(*from_south, 2 * ARM)], True),
        Turn("13", north_in, side_out, bend(*from_north, right, radius, clothoid), True),
        Turn("14", south_in, side_out, bend(*from_south, left, radius, clothoid), False),
        Turn("15", side_in, south_out, bend(*from_side, right, radius, clothoid), True),
        Turn("16", side_in, north_out, bend(*from_side, left, radius, clothoid), False),
    ]


def num(value: float) -> str:
    """Shortest text of a length or angle to 1e-12, without -0."""
    return f"{round(value, 12) + 0.0:.12f}".rstrip("0").rstrip(".")


def add(parent: ET.Element, tag: str, **attributes: object) -> ET.Element:
    texts = {key: num(value) if isinstance(value, float) else str(value) for key, value in attributes.items()}
    return ET.SubElement(parent, tag, texts)


def add_plan(road: ET.Element, pieces: list[Piece]) -> None:
    plan = add(road, "planView")
    s = 0.0
    for piece in pieces:
        geometry = add(plan, "geometry", s=s, x=piece.x, y=piece.y, hdg=piece.heading, length=piece.length)
        if piece.k0 != piece.k1:
            add(geometry, "spiral", curvStart=piece.k0, curvEnd=piece.k1)
        elif piece.k0:
            add(geometry, "arc", curvature=piece.k0)
        else:
            add(geometry, "line")
        s += piece.length


def add_lane(side: ET.Element, lane: int, kind: str, width: float, links: dict[str, int], mark: str) -> None:
    element = add(side, "lane", id=lane, type=kind, level="false")
    if links:
        link = add(element, "link")
        for name in ("predecessor", "successor"):
            if name in links:
                add(link, name, id=links[name])
    if lane:
        add(element, "width", sOffset=0.0, a=width, b=0.0, c=0.0, d=0.0)
    width = 0.0 if mark == "none" else 0.12
    add(element, "roadMark", sOffset=0.0, type=mark, weight="standard", color="standard", width=width)
    if kind == "driving":
        add(element, "speed", sOffset=0.0, max=SPEED, unit="km/h")


def add_lanes(road: ET.Element, lanes: list[tuple[int, dict[str, int]]], centre: str) -> None:
    section = add(add(road, "lanes"), "laneSection", s=0.0)
    for name, chosen in (
        ("left", [entry for entry in lanes if entry[0] > 0]),
        ("center", [(0, {})]),
        ("right", [entry for entry in lanes if entry[0] < 0]),
    ):
        if chosen:
            side = add(section, name)
            for lane, links in sorted(chosen, key=lambda entry: -entry[0]):
                if lane == 0:
                    add_lane(side, 0, "none", 0.0, {}, centre)
                elif abs(lane) == 1:
                    add_lane(side, lane, "driving", LANE, links, "solid")
                else:
                    add_lane(side, lane, "sidewalk", WALK, links, "none")


def add_road(root: ET.Element, name: str, road_id: str, junction: str, pieces: list[Piece]) -> ET.Element:
    length = sum(piece.length for piece in pieces)
    return add(root, "road", name=name, length=length, id=road_id, junction=junction, rule="RHT")


def add_type(road: ET.Element) -> None:
    add(add(road, "type", s=0.0, type="town", country="ES"), "speed", max=SPEED, unit="km/h")


def add_crosswalk(road: ET.Element, s: float, extent: float) -> None:
    crosswalk = add(
        add(road, "objects"), "object", type="crosswalk", id="1", name="zebra", s=s, t=0.0, zOffset=0.0, hdg=0.0,
        pitch=0.0, roll=0.0, orientation="none", length=extent, width=2 * LANE, height=0.0,
    )  # fmt: skip
    outline = add(add(crosswalk, "outlines"), "outline", id=0, fillType="asphalt", closed="true")
    u, v = extent / 2, LANE
    for number, (corner_u, corner_v) in enumerate(((-u, -v), (u, -v), (u, v), (-u, v))):
        add(outline, "cornerLocal", id=number, u=corner_u, v=corner_v, z=0.0, height=0.0)


def add_light(road: ET.Element, s: float) -> None:
    add(
        add(road, "signals"), "signal", name="light", id="1", s=s, t=-1.5 * LANE, zOffset=2.5, dynamic="yes",
        orientation="+", country="OpenDRIVE", type="1000001", subtype="-1", value=-1.0, height=0.9, width=0.3,
    )  # fmt: skip


def make() -> ET.Element:
    roads = streets()
    for pieces in [*roads.values(), *(turn.pieces for turn in turns())]:
        check_chain(pieces)
    check_chain([piece for name, pieces in roads.items() if name != "side" for piece in pieces])
    root = ET.Element("OpenDRIVE")
    add(root, "header", revMajor=1, revMinor=7, name="urban loop", version="1.00",
        north=128.0, south=-6.0, east=206.0, west=-74.0)  # fmt: skip
    order = list(ROAD_IDS)
    for index, name in enumerate(order):
        pieces = roads[name]
        road = add_road(root, ROAD_NAMES[name], ROAD_IDS[name], "-1", pieces)
        link = add(road, "link")
        before = {} if name in ("west", "side") else {"predecessor": ROAD_IDS[order[index - 1]]}
        after = {} if name in ("harbour", "side") else {"successor": ROAD_IDS[order[index + 1]]}
        if before:
            add(link, "predecessor", elementType="road", elementId=before["predecessor"], contactPoint="end")
        else:
            add(link, "predecessor", elementType="junction", elementId=JUNCTION_ID)
        if after:
            add(link, "successor", elementType="road", elementId=after["successor"], contactPoint="start")
        elif name == "harbour":
            add(link, "successor", elementType="junction", elementId=JUNCTION_ID)
        add_type(road)
        add_plan(road, pieces)
        ends = [*before, *after]
        add_lanes(road, [(lane, dict.fromkeys(ends, lane)) for lane in (2, 1, -1, -2)], "broken")
        if name == CROSSWALK[0]:
            add_crosswalk(road, CROSSWALK[1], CROSSWALK[2])
        if name == LIGHT[0]:
            add_light(road, LIGHT[1])
    junction = ET.Element("junction", {"name": "Harbour corner", "id": JUNCTION_ID, "type": "default"})
    for number, turn in enumerate(turns()):
        road = add_road(root, f"way {turn.id}", turn.id, JUNCTION_ID, turn.pieces)
        link = add(road, "link")
        for tag, (other, _, contact) in (("predecessor", turn.start), ("successor", turn.end)):
            add(link, tag, elementType="road", elementId=other, contactPoint=contact)
        add_type(road)
        add_plan(road, turn.pieces)
        lanes = [(-1, {"predecessor": turn.start[1], "successor": turn.end[1]})]
        if turn.walk:
            lanes.append((-2, {"predecessor": 2 * turn.start[1], "successor": 2 * turn.end[1]}))
        add_lanes(road, lanes, "none")
        connection = add(junction, "connection", id=number, incomingRoad=turn.start[0], connectingRoad=turn.id,
                         contactPoint="start")  # fmt: skip
        for lane, links in lanes:
            add(connection, "laneLink", **{"from": links["predecessor"], "to": lane})
    root.append(junction)
    return root


def main(argv: list[str]) -> None:
    target = Path(argv[0]) if argv else Path(__file__).resolve().parents[1] / "scenarios" / "urban.xodr"
    root = make()
    ET.indent(root)
    text = '<?xml version="1.0" encoding="UTF-8"?>\n<!-- Made by scripts/make_urban_road.py; do not edit. -->\n'
    target.write_text(text + ET.tostring(root, encoding="unicode") + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
