"""Junction rules: junctions and road links name roads, lanes and junctions that exist."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from openscenario.findings import listed
from openscenario.road.attributes import Attributes
from openscenario.road.elements import OpenDrive, Road
from openscenario.road.lane_rules import NO_WIDTH, width_at
from openscenario.road.links import end_lanes
from openscenario.xml import Node

NO_JUNCTION = ("-1", "")


def check_junctions(attributes: Attributes, network: OpenDrive, road_nodes: list[Node]) -> None:
    """Add a finding for each name that nothing has, and for connections that contradict the roads."""
    root = road_nodes[0].parent
    nodes = [] if root is None else root.findall("junction")
    roads = {road.id: road for road in network.roads}
    junctions = {junction.id: junction.type for junction in network.junctions}
    _road_names(attributes, network, road_nodes, roads, junctions)
    seen: set[str] = set()
    for node in nodes:
        name = node.get("id")
        if name in seen:
            text = "two junctions have one id"
            attributes.report("asam.net:xodr:1.4.0:junctions.id_unique", node, text, attribute="id", found=name)
        seen.add(name)
        connections = node.findall("connection")
        for connection in connections:
            _connection(attributes, connection, node, roads)
        if node.get("type") != "virtual":
            _appearing(attributes, connections, roads)
        if network.version == (1, 7):
            _one_connection(attributes, connections)


def _road_names(
    attributes: Attributes,
    network: OpenDrive,
    road_nodes: list[Node],
    roads: Mapping[str, Road],
    junctions: Mapping[str, str],
) -> None:
    for road, node in zip(network.roads, road_nodes, strict=True):
        if road.junction not in NO_JUNCTION and road.junction not in junctions:
            _unknown(attributes, node, "junction", "junction", road.junction, junctions)
        links = node.find("link")
        for link in () if links is None else links.children:
            kind = link.get("elementType", "road")
            if link.tag not in ("predecessor", "successor"):
                continue
            known: Collection[str] = roads if kind == "road" else junctions
            if link.get("elementId") not in known:
                _unknown(attributes, link, "elementId", kind, link.get("elementId"), known)


def _connection(attributes: Attributes, node: Node, junction: Node, roads: Mapping[str, Road]) -> None:
    names = ("incomingRoad", "connectingRoad", "linkedRoad")
    known = True
    for name in names:
        if name in node.attributes and node.get(name) not in roads:
            known = False
            _unknown(attributes, node, name, "road", node.get(name), roads)
    if junction.get("type") == "virtual":
        return
    for name, others in (("incomingRoad", ()), ("connectingRoad", ("linkedRoad",))):
        if not any(each in node.attributes for each in (name, *others)):
            known = False
            attributes.report(
                "asam.net:xodr:1.0.0:xml.valid_schema",
                node,
                f"attribute {name} is missing",
                attribute=name,
                allowed="the id of a road",
            )
    if known:
        incoming, connecting = (roads[node.get("incomingRoad")], roads[node.get(names[1]) or node.get(names[2])])
        _ways(attributes, node, junction, incoming, connecting)


def _ways(attributes: Attributes, node: Node, junction: Node, incoming: Road, connecting: Road) -> None:
    if incoming.junction not in NO_JUNCTION and incoming.junction == junction.get("id"):
        attributes.report(
            "asam.net:xodr:1.4.0:junctions.connection.connect_road_no_incoming_road",
            node,
            "a road inside of the junction is no incoming road",
            attribute="incomingRoad",
            found=incoming.id,
        )
        return
    _contact(attributes, node, incoming, connecting)
    links = node.findall("laneLink")
    ends = (("from", incoming), ("to", connecting))
    right = [all(int(link.get(name)) in _lanes(road) for name, road in ends) for link in links]
    for link, fits in zip(links, right, strict=True):
        for name, road in () if fits else ends:
            if int(link.get(name)) not in _lanes(road):
                attributes.report(
                    "asam.net:xodr:1.4.0:junctions.connection.lane_link.unknown",
                    link,
                    f"road {road.id} has no such lane",
                    attribute=name,
                    found=link.get(name),
                    allowed=listed([str(number) for number in sorted(_lanes(road))]),
                    # one of several that leads nowhere is left out; a connection without any is none
                    severity="warning" if any(right) else "error",
                    repair="these two lanes are not linked",
                )


def _appearing(attributes: Attributes, connections: list[Node], roads: Mapping[str, Road]) -> None:
    """Of the lanes of a road that one lane is linked to, none begins there with no width."""
    targets: dict[tuple[str, ...], list[Node]] = {}
    for node in connections:
        ways = tuple(node.get(name) for name in ("incomingRoad", "connectingRoad", "linkedRoad", "contactPoint"))
        for link in node.findall("laneLink"):
            targets.setdefault((*ways, link.get("from")), []).append(link)
    for (incoming, direct, linked, contact, source), links in targets.items():
        connecting = roads.get(direct or linked)
        if len(links) < 2 or connecting is None:
            continue
        at_end = contact == "end"
        for link in links:
            lane = next((lane for lane in end_lanes(connecting, at_end) if str(lane.id) == link.get("to")), None)
            place = connecting.length - connecting.sections[-1].s if at_end else 0.0
            if lane is not None and lane.widths and abs(width_at(lane, place)) < NO_WIDTH:
                attributes.report(
                    "asam.net:xodr:1.4.0:road.lane.link.new_lane_appear",
                    link,
                    f"only the lane that continues lane {source} of road {incoming} is linked",
                    found=f"lane {lane.id} of road {connecting.id}, which has no width there",
                    repair="whoever follows the link starts on a lane without width",
                )


def _contact(attributes: Attributes, node: Node, incoming: Road, connecting: Road) -> None:
    """`start` where the connecting road's predecessor is the incoming road, `end` where its successor is."""
    before, after = (
        link is not None and link.kind == "road" and link.id == incoming.id
        for link in (connecting.predecessor, connecting.successor)
    )
    contact = node.get("contactPoint")
    for wrong, rule, right in (
        (contact == "end" and before and not after, "start_along_linkage", "start"),
        (contact == "start" and after and not before, "end_opposite_linkage", "end"),
    ):
        if wrong:
            attributes.report(
                f"asam.net:xodr:1.4.0:junctions.connection.{rule}",
                node,
                f"road {connecting.id} meets road {incoming.id} at its {right}",
                attribute="contactPoint",
                found=contact,
                allowed=right,
                repair="the junction's connection holds",
            )


def _one_connection(attributes: Attributes, connections: list[Node]) -> None:
    """In version 1.7 one connecting road stands in one connection."""
    first: dict[str, Node] = {}
    for node in connections:
        road = node.get("connectingRoad")
        if road and road in first:
            attributes.report(
                "asam.net:xodr:1.7.0:junctions.connection.one_connection_element",
                node,
                "another connection has the same connecting road",
                attribute="connectingRoad",
                found=road,
                hint=f"in line {first[road].line}",
                severity="warning",  # later versions allow it: each direction has its own
            )
        first.setdefault(road, node)


def _lanes(road: Road) -> set[int]:
    return {lane.id for section in (road.sections[0], road.sections[-1]) for lane in section.lanes}


def _unknown(attributes: Attributes, node: Node, attribute: str, what: str, found: str, known: Collection[str]) -> None:
    allowed, hint = attributes.advice(found, known)
    attributes.report(
        "asam.net:xodr:1.4.0:road.linkage.unknown",
        node,
        f"no such {what}",
        attribute=attribute,
        found=found,
        allowed=allowed,
        hint=hint,
        repair="the link is left out",
    )
