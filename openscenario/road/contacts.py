"""Contacts: which end of a road another road is linked to, where the link does not say so."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import msgspec

from openscenario.road.attributes import Attributes
from openscenario.road.elements import Contact, Road, RoadLink
from openscenario.road.shapes import geometry_rows, row_end
from openscenario.xml import Node

Point = tuple[float, float]


def with_contacts(attributes: Attributes, roads: Sequence[Road], nodes: Sequence[Node]) -> tuple[Road, ...]:
    """The roads, each link to a road with its contact point; `nodes` are the elements of the roads.

    One that is missing is the end from which the other road leads back, else the one that lies nearer.
    """
    by_id = {road.id: road for road in roads}
    found = []
    for road, node in zip(roads, nodes, strict=True):
        parts = {}
        for name, link in (("predecessor", road.predecessor), ("successor", road.successor)):
            if link is None or link.kind != "road" or link.contact or link.s is not None or link.id not in by_id:
                continue
            contact = _contact(road, name == "successor", by_id)
            if contact:
                parts[name] = msgspec.structs.replace(link, contact=contact)
                links = node.find("link")
                attributes.report(
                    "road.contact_point_missing",
                    (links.find(name) if links is not None else None) or node,
                    "the link does not say which end of the road it leads to",
                    attribute="contactPoint",
                    allowed="start, end",
                    repair=f"it leads to the {contact} of road {link.id}",
                )
        found.append(msgspec.structs.replace(road, **parts) if parts else road)
    return tuple(found)


def _contact(road: Road, at_end: bool, by_id: Mapping[str, Road]) -> Contact:
    link = road.successor if at_end else road.predecessor
    assert link is not None
    other = by_id[link.id]
    ends: dict[Contact, RoadLink | None] = {"start": other.predecessor, "end": other.successor}
    if other.id == road.id:
        return "start" if at_end else "end"  # a ring of one road
    mine = ("", "end" if at_end else "start")  # a link back to the other end of this road is another joint
    back = [
        end
        for end, each in ends.items()
        if each is not None
        and (each.id == road.id and each.contact in mine if each.kind == "road" else each.id == road.junction)
    ]
    if len(back) == 1:
        return back[0]
    here, there = _ends(road), _ends(other)
    if not here or not there:
        return ""
    start, end = (math.dist(here[at_end], there[each]) for each in (False, True))
    return "start" if start <= end else "end"


def _ends(road: Road) -> tuple[Point, ...]:
    """Where the reference line begins and ends; nothing of a road without geometries."""
    if not road.geometries:
        return ()
    first = road.geometries[0]
    return (first.x, first.y), row_end(geometry_rows(road.geometries[-1])[-1])[:2]
