"""Reads what stands on and beside a road: objects with outlines and repetitions, and signals."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TypeVar

import msgspec

from openscenario.road.attributes import Attributes, by_tag
from openscenario.road.elements import Corner, Repeat, Road, RoadObject, Signal
from openscenario.xml import Node

MAX_CORNERS = 10_000  # of one outline; chosen, not measured: a file with more is a mistake or an attack
YES = ("yes", "true", "1")  # in any case; the standard has the first, tools that think of a boolean write the others
LEFT_OUT = "it is left out"  # what stands beside the road and cannot be read: nobody drives on it
# code of the object type in OpenDRIVE 1.4 files that say it by name only
_NAMED = {"crosswalk": "crosswalk", "zebra": "crosswalk", "crossing": "crosswalk"}


def read_objects(attributes: Attributes, nodes: list[Node]) -> tuple[RoadObject, ...]:
    """Objects of one road."""
    return tuple(item for node in nodes if (item := _kept(attributes, _read_object, node)) is not None)


_Thing = TypeVar("_Thing", RoadObject, Signal)


def _kept(attributes: Attributes, read: Callable[[Attributes, Node], _Thing], node: Node) -> _Thing | None:
    """What an element says, or None if some of it cannot be read."""
    before = len(attributes.findings)
    with attributes.repairing(LEFT_OUT):
        item = read(attributes, node)
    wrong = any(each.severity == "error" and each.repair == LEFT_OUT for each in attributes.findings[before:])
    return None if wrong else item


def _read_object(attributes: Attributes, node: Node) -> RoadObject:
    number = attributes.number
    parts = by_tag(node)
    outlines = [_read_outline(attributes, outline) for outline in parts.get("outline", ())]
    for group in parts.get("outlines", ()):
        outlines.extend(_read_outline(attributes, outline) for outline in by_tag(group).get("outline", ()))
    name = node.get("name")
    kind = node.get("type")
    if kind in ("", "-1", "none"):
        kind = next((value for word, value in _NAMED.items() if word in name.lower()), kind)
    place = number(node, "s")
    return RoadObject(
        id=node.get("id"),
        name=name,
        type=kind,
        s=place,
        t=number(node, "t"),
        z_offset=number(node, "zOffset", 0.0),
        hdg=number(node, "hdg", 0.0),
        length=number(node, "length", 0.0),
        width=number(node, "width", 0.0),
        height=number(node, "height", 0.0),
        radius=number(node, "radius", 0.0),
        outlines=tuple(outline for outline in outlines if len(outline) >= 2),
        repeats=tuple(_read_repeat(attributes, repeat, place) for repeat in parts.get("repeat", ())),
        line=node.line,
    )


def _read_outline(attributes: Attributes, node: Node) -> tuple[Corner, ...]:
    corners: list[Corner] = []
    for corner in node.children[:MAX_CORNERS]:
        if corner.tag == "cornerLocal":
            corners.append(Corner(attributes.number(corner, "u"), attributes.number(corner, "v"), False))
        elif corner.tag == "cornerRoad":
            corners.append(Corner(attributes.number(corner, "s"), attributes.number(corner, "t"), True))
    return tuple(corners)


def _read_repeat(attributes: Attributes, node: Node, place: float) -> Repeat:
    """A repetition of an object that stands at s = place [m]."""
    number = attributes.number
    length, distance = number(node, "length"), number(node, "distance")
    if length < 0.0 or distance < 0.0:
        attributes.report("value.out_of_range", node, "length and distance of a repetition are not negative")
        length, distance = 0.0, 0.0
    with attributes.repairing("the repetition starts where the object stands"):
        start = number(node, "s") if "s" in node.attributes else place
        if "s" not in node.attributes:
            attributes.report("xml.valid_schema", node, "attribute s is missing", attribute="s", allowed="s")
    return Repeat(
        s=start,
        length=length,
        distance=distance,
        t_start=number(node, "tStart", 0.0),
        t_end=number(node, "tEnd", number(node, "tStart", 0.0)),
        width_start=number(node, "widthStart", math.inf) if "widthStart" in node.attributes else math.inf,
        width_end=number(node, "widthEnd", math.inf) if "widthEnd" in node.attributes else math.inf,
    )


def read_signals(attributes: Attributes, nodes: list[Node], road: str) -> tuple[Signal, ...]:
    """Signals of one road."""
    read = partial(_read_signal, road=road)
    return tuple(item for node in nodes if (item := _kept(attributes, read, node)) is not None)


def _read_signal(attributes: Attributes, node: Node, road: str) -> Signal:
    number = attributes.number
    return Signal(
        id=attributes.text(node, "id"),
        name=node.get("name"),
        road=road,
        s=number(node, "s"),
        t=number(node, "t"),
        z_offset=number(node, "zOffset", 0.0),
        h_offset=number(node, "hOffset", 0.0),
        type=node.get("type"),
        subtype=node.get("subtype"),
        country=node.get("country"),
        dynamic=is_dynamic(node),
        orientation=node.get("orientation", "none"),
        value=number(node, "value") if _is_number(node.get("value")) else None,
        unit=node.get("unit"),
        width=number(node, "width", 0.0),
        height=number(node, "height", 0.0),
        line=node.line,
        validity=_read_validity(attributes, node),
    )


def is_dynamic(node: Node) -> bool:
    """Whether a signal changes its state."""
    return node.get("dynamic").strip().lower() in YES


def _read_validity(attributes: Attributes, node: Node) -> tuple[tuple[int, int], ...]:
    """The ranges of lane ids that a signal is for; from 0 to 0 is no lane that anybody drives on."""
    found = []
    for each in node.findall("validity"):
        before = len(attributes.findings)
        with attributes.repairing("it is for every lane of its direction"):
            first, last = attributes.integer(each, "fromLane"), attributes.integer(each, "toLane")
        if len(attributes.findings) > before:
            return ()
        found.append((min(first, last), max(first, last)))
    return tuple(found)


def refer(attributes: Attributes, roads: Sequence[Road], nodes: Sequence[Node]) -> tuple[Road, ...]:
    """The roads with what their signalReference elements name; `nodes` are the elements of the roads.

    A reference to a signal that is not in the file names nothing; the rules report it.
    Source: ASAM OpenDRIVE 1.8, 14.5 (reuse of signals): the signal is valid on the referring road as well.
    """
    known = {signal.id: signal for road in roads for signal in road.signals}
    found = []
    for road, node in zip(roads, nodes, strict=True):
        read = partial(_read_reference, road=road.id, known=known)
        references = [each for group in node.findall("signals") for each in group.findall("signalReference")]
        more = tuple(
            item
            for each in references
            if each.get("id") in known and (item := _kept(attributes, read, each)) is not None
        )
        found.append(msgspec.structs.replace(road, signals=road.signals + more) if more else road)
    return tuple(found)


def _read_reference(attributes: Attributes, node: Node, road: str, known: Mapping[str, Signal]) -> Signal:
    return msgspec.structs.replace(
        known[node.get("id")],
        road=road,
        s=attributes.number(node, "s"),
        t=attributes.number(node, "t"),
        orientation=node.get("orientation", "none"),
        validity=_read_validity(attributes, node),
        line=node.line,
    )


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False
