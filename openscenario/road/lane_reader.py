"""Reads a road's lane sections and lanes."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from itertools import pairwise

from openscenario.road.attributes import Attributes, by_tag
from openscenario.road.elements import Cubic, Friction, Lane, LaneHeight, LaneSection, RoadMark, SpeedLimit
from openscenario.road.plan_reader import MAX_LENGTH, bounded, in_order, read_cubics
from openscenario.xml import Node

MAX_LANES = 255  # on one side
MAX_HEIGHT = 100.0  # m of a lane above its road: kerbs are lower
LATE = 1e-3  # m into a section; chosen: a first width up to there is one from the beginning, rounded
_TO_SPEED = {"m/s": 1.0, "km/h": 1.0 / 3.6, "mph": 0.44704}  # the units of OpenDRIVE 1.4 to 1.9 (e_unitSpeed)
_MEANT = {"kph": "km/h", "kmh": "km/h", "kmph": "km/h", "mps": "m/s", "": "m/s", "mih": "mph"}  # letters of others


def read_speed(attributes: Attributes, node: Node) -> float | None:
    """Speed limit [m/s] of a speed element: inf for no limit, None for undefined."""
    text = attributes.text(node, "max")
    if text in ("no limit", "undefined", ""):
        return math.inf if text == "no limit" else None
    unit = _speed_unit(attributes, node)
    if unit is None:
        return None
    value = attributes.number(node, "max") * _TO_SPEED[unit]
    if value < 0.0:  # written as -1 by several tools for "no limit"
        return None
    return value


def _speed_unit(attributes: Attributes, node: Node) -> str | None:
    """The unit of a speed element, m/s where it states none; None for one that nobody knows: such a limit is none."""
    written = node.get("unit", "m/s")
    letters = "".join(filter(str.isalpha, written.lower()))
    same = {"".join(filter(str.isalpha, unit)): unit for unit in _TO_SPEED}
    meant = written if written in _TO_SPEED else (_MEANT | same).get(letters)
    with attributes.repairing(f"it is {meant}" if meant else "no speed limit is stated there"):
        attributes.choice(node, "unit", tuple(_TO_SPEED), "m/s")
    return meant


def read_section(attributes: Attributes, node: Node) -> LaneSection:
    """One lane section."""
    lanes: list[Lane] = []
    sides = by_tag(node)
    for side in ("left", "center", "right"):
        for second in sides.get(side, ())[1:]:
            text = "only one element of its kind may stand here"
            attributes.report("asam.net:xodr:1.0.0:xml.valid_schema", second, text, found=side, allowed="one")
    if "center" not in sides:
        text = "a lane section needs a centre"
        code, assumed = "asam.net:xodr:1.0.0:xml.valid_schema", "a centre lane of type none"
        attributes.report(code, node, text, allowed="center", repair=assumed)
    for side, sign in (("left", 1), ("center", 0), ("right", -1)):
        for group in sides.get(side, ()):
            nodes = by_tag(group).get("lane", [])
            if not nodes and side != "center":
                attributes.report(
                    "asam.net:xodr:1.0.0:xml.valid_schema",
                    group,
                    f"the {side} side of a lane section is empty",
                    allowed="at least one lane, or no such element",
                    repair="the road has no lane on this side",
                )
            for lane_node in nodes:
                lane = _read_lane(attributes, lane_node)
                if lane.id * sign < 0 or (sign == 0) != (lane.id == 0):
                    allowed = {1: "id > 0", 0: "id = 0", -1: "id < 0"}[sign]
                    attributes.report(
                        "asam.net:xodr:1.4.0:road.lane.id_side",
                        lane_node,
                        f"lane on the wrong side: it is listed {side}",
                        attribute="id",
                        found=str(lane.id),
                        allowed=allowed,
                        repair="the lane lies on the side of its id" if sign and lane.id else "",
                    )
                lanes.append(lane)
    lanes.sort(key=lambda lane: -lane.id)
    ids = [lane.id for lane in lanes]
    if 0 not in ids:
        lanes.append(Lane(0, "none", False, (), (), (), (), (), (), (), node.line))
        lanes.sort(key=lambda lane: -lane.id)
        ids = [lane.id for lane in lanes]
    if any(a - b != 1 for a, b in pairwise(ids)) or max(abs(number) for number in ids) > MAX_LANES:
        _report_ids(attributes, node, lanes)
        lanes = [Lane(0, "none", False, (), (), (), (), (), (), (), node.line)]
    return LaneSection(attributes.number(node, "s"), tuple(lanes), node.line)


def _report_ids(attributes: Attributes, section: Node, lanes: list[Lane]) -> None:
    """At the first lane of a side whose id is not its place, counted from the centre or towards it as fits better."""
    wrong = section
    for side in section.children:
        nodes = side.findall("lane")
        outwards = [(node, 1 + place) for place, node in enumerate(nodes)]
        inwards = [(node, len(nodes) - place) for place, node in enumerate(nodes)]
        misfits = [[node for node, place in order if abs(_whole(node)) != place] for order in (outwards, inwards)]
        fewest = min(misfits, key=len)
        if side.tag != "center" and fewest and wrong is section:
            wrong = fewest[0]
    attributes.report(
        "asam.net:xodr:1.4.0:road.lane.id_consecutive",
        wrong,
        "lane ids must count from the centre lane outwards without a gap or repetition",
        attribute="" if wrong is section else "id",
        found=" ".join(str(lane.id)[:20] for lane in lanes[:40]),
        allowed=f"-{MAX_LANES} to {MAX_LANES}",
    )


def _temporary(link: Node) -> bool:
    """Whether a lane link leads to the temporary layer of a road (1.9), which is not used."""
    return link.get("layer") == "temporary"


def _whole(lane: Node) -> int:
    text = lane.get("id").strip()
    return int(text) if re.fullmatch(r"[-+]?[0-9]{1,9}", text) else 0


def _height(attributes: Attributes, node: Node) -> LaneHeight:
    s = bounded(attributes, node, "sOffset", attributes.number(node, "sOffset", 0.0), MAX_LENGTH)
    inner, outer = (attributes.number(node, name, 0.0) for name in ("inner", "outer"))
    for name, value in (("inner", inner), ("outer", outer)):
        bounded(attributes, node, name, value, MAX_HEIGHT)
    return LaneHeight(s, inner, outer)


def _read_lane(attributes: Attributes, node: Node) -> Lane:
    parts = by_tag(node)
    heights = tuple(_height(attributes, node) for node in parts.get("height", ()))
    stated = [(each, read_speed(attributes, each)) for each in parts.get("speed", ())]
    limits = [(each, limit) for each, limit in stated if limit is not None]
    speeds = [SpeedLimit(attributes.number(each, "sOffset", 0.0), limit) for each, limit in limits]
    marks = tuple(
        RoadMark(attributes.number(m, "sOffset", 0.0), m.get("type", "none"), m.get("laneChange", "both"))
        for m in parts.get("roadMark", ())
    )
    link = by_tag(parts["link"][0]) if "link" in parts else {}
    number = attributes.integer(node, "id")
    return Lane(
        id=number,
        type=attributes.text(node, "type", "none" if number == 0 else None),  # few files say it of the centre
        level=attributes.choice(node, "level", ("false", "true", "0", "1"), "false") in ("true", "1"),
        widths=_from_start(attributes, parts.get("width", [])),
        borders=_from_start(attributes, parts.get("border", [])),
        heights=heights,
        speeds=in_order(attributes, [each for each, _ in limits], speeds, "sOffset"),
        marks=marks,
        predecessors=tuple(attributes.integer(n, "id") for n in link.get("predecessor", ()) if not _temporary(n)),
        successors=tuple(attributes.integer(n, "id") for n in link.get("successor", ()) if not _temporary(n)),
        line=node.line,
        direction=_direction(attributes, node),
        frictions=tuple(sorted(_frictions(parts.get("material", [])), key=lambda each: each.s)),
    )


def _from_start(attributes: Attributes, nodes: list[Node]) -> tuple[Cubic, ...]:
    """Widths or borders of a lane; the first of them holds from the beginning of the section."""
    records = read_cubics(attributes, nodes, "sOffset")
    if not records or records[0].s <= 0.0:
        return records
    first = records[0]
    if first.s > LATE:
        attributes.report(
            "road.lane_without_width",
            nodes[0],
            "the lane has no width or border from the beginning of its section on",
            attribute="sOffset",
            found=f"{first.s:g}",
            allowed="0",
            repair="the first one holds from there",
        )
    return (Cubic(0.0, first.a, 0.0, 0.0, 0.0), *records)


def _direction(attributes: Attributes, node: Node) -> str:
    if not node.get("direction"):
        return "standard"
    found = attributes.choice(node, "direction", ("standard", "reversed", "both"), "standard")
    if found == "both":
        attributes.report(
            "road.unsupported",
            node,
            "a lane for both directions is driven in one only, that of its side",
            attribute="direction",
            found=found,
            severity="warning",
        )
    return found


def _frictions(materials: list[Node]) -> Iterator[Friction]:
    """The materials that state a friction; what is no number is found with the other attributes that nobody needs."""
    for node in materials:
        try:
            s, friction = float(node.get("sOffset") or 0.0), float(node.get("friction"))
        except ValueError:
            continue
        if math.isfinite(s) and 0.0 <= friction < math.inf:
            yield Friction(s, friction)
