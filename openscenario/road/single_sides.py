"""Lane sections of one side of a road: the other side goes on as the sections before have it."""

from __future__ import annotations

import itertools

from openscenario.xml import Node

_SIDES = ("left", "right")
_CUBICS = ("width", "border")


def complete_sides(lanes: Node) -> None:
    """Give each section with singleSide="true" the side that it does not state, in the place of the road's own element.

    A side that another section continues is cut there: its records start anew, and its lanes lead from one part to the
    other. Sections that begin at the same place become one. Nothing is changed where no section is single-sided, or
    where a place is no number: that is for the reader.
    Source: ASAM OpenDRIVE 1.8, 11.3 (lane sections), attribute singleSide.
    """
    sections = lanes.findall("laneSection")
    if not any(node.get("singleSide") == "true" for node in sections):
        return
    if not _spelled(lanes):
        return
    for before, node in itertools.pairwise(sections):
        if node.get("singleSide") == "true":
            apart = float(node.get("s")) - float(before.get("s"))
            stated = {side for side in _SIDES if node.find(side) is not None}
            for side in _SIDES:
                known = before.find(side)
                if known is not None and side not in stated and apart >= 0.0:
                    node.children.append(_carried(known, node, apart))
            if apart == 0.0 and not any(before.find(side) is not None for side in stated):
                lanes.children.remove(before)


def _spelled(lanes: Node) -> bool:
    """Whether all places and coefficients are numbers."""
    try:
        for node in lanes.walk():
            for name in ("s",) if node.tag == "laneSection" else ("sOffset", *"abcd"):
                float(node.get(name) or ("" if name == "s" else 0.0))
    except ValueError:
        return False
    return True


def _carried(side: Node, section: Node, apart: float) -> Node:
    """A copy of a side for a section that begins `apart` [m] later."""
    copy = Node(side.tag, side.line, dict(side.attributes), "", section)
    for lane in side.findall("lane"):
        part = _copied(lane, copy)
        copy.children.append(part)
        if apart > 0.0:
            part.children = _later(part.children, apart)
            _link(part, "predecessor", lane.get("id"))
            _link(lane, "successor", lane.get("id"))
    return copy


def _copied(node: Node, parent: Node) -> Node:
    copy = Node(node.tag, node.line, dict(node.attributes), node.text, parent)
    copy.children = [_copied(child, copy) for child in node.children]
    return copy


def _later(records: list[Node], apart: float) -> list[Node]:
    """The records of a lane that hold from `apart` [m] on, with places from there."""
    kept: list[Node] = []
    first: dict[str, Node] = {}
    for record in sorted(records, key=lambda each: float(each.get("sOffset") or 0.0)):
        place = float(record.get("sOffset") or 0.0) - apart
        if record.tag == "link":
            kept.append(record)
        elif place > 0.0:
            record.attributes["sOffset"] = repr(place)
            kept.append(record)
        else:  # the last one that begins before holds at the cut
            first[record.tag] = record
            if record.tag in _CUBICS:
                _shift(record, -place)
            record.attributes["sOffset"] = "0"
    return [*first.values(), *kept]


def _shift(record: Node, u: float) -> None:
    """The same cubic, of a place that is counted from `u` [m] further on."""
    a, b, c, d = (float(record.get(name) or 0.0) for name in "abcd")
    values = (a + u * (b + u * (c + u * d)), b + u * (2.0 * c + 3.0 * u * d), c + 3.0 * u * d, d)
    record.attributes.update(zip("abcd", map(repr, values), strict=True))


def _link(lane: Node, end: str, number: str) -> None:
    """The only link of a lane at that end leads to the lane of this number."""
    link = lane.find("link")
    if link is None:
        link = Node("link", lane.line, {}, "", lane)
        lane.children.insert(0, link)
    link.children = [child for child in link.children if child.tag != end]
    link.children.append(Node(end, lane.line, {"id": number}, "", link))
