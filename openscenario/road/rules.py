"""Rules: what a road network must keep beyond its schema, each with the ASAM rule UID where one exists."""

from __future__ import annotations

import math
from collections.abc import Iterator

from openscenario.road.attributes import Attributes
from openscenario.road.elements import Lane, OpenDrive, Road, lane_direction
from openscenario.road.joint_rules import check_joints
from openscenario.road.junction_rules import check_junctions
from openscenario.road.lane_rules import LANE_TYPES, NO_WIDTH, check_lanes, width_at
from openscenario.road.links import LaneEnd, answered, end_lanes, make_links
from openscenario.road.shapes import geometry_rows, row_end
from openscenario.road.thing_rules import check_things
from openscenario.xml import Node

MAX_GAP = 0.1  # m, between two geometries of a road; more than rounding, and a vehicle on it would feel a kick
MAX_KINK = 0.05  # rad, between the headings of two geometries; the most that public files have is 0.005
MAX_CONTACT_GAP = 0.5  # m, between the reference lines of two linked roads
MAX_STATION_GAP = 0.1  # m, between the end of a geometry and the s that the next one states

Point = tuple[float, float, float]  # x, y [m], heading [rad]


def check_network(attributes: Attributes, network: OpenDrive, nodes: list[Node]) -> None:
    """Add a finding for each broken rule; `nodes` are the road elements that the roads were read from."""
    ends = []
    for road, node in zip(network.roads, nodes, strict=True):
        ends.append(_plan(attributes, road, node))
        check_lanes(attributes, road, node)
        _levels(attributes, road, node)
        _section_links(attributes, road, node)
    _somewhere_to_drive(attributes, network, nodes)
    _unique_ids(attributes, network, nodes)
    check_junctions(attributes, network, nodes)
    check_things(attributes, nodes)
    _contact_points(attributes, network, nodes, ends)
    check_joints(attributes, network, nodes, ends)
    _road_links(attributes, network, nodes)
    _appearing_lanes(attributes, network, nodes)


def _somewhere_to_drive(attributes: Attributes, network: OpenDrive, nodes: list[Node]) -> None:
    lanes = [lane for road in network.roads for section in road.sections for lane in section.lanes]
    if not any(lane.drivable or lane.type not in LANE_TYPES for lane in lanes):
        group = nodes[0].find("lanes")
        section = None if group is None else group.find("laneSection")
        side = None if section is None else section.find("right") or section.find("left") or section
        text = "the network has no lane to drive on"
        attributes.report("road.no_driving_lane", side or nodes[0], text, allowed="a lane of type driving")


def _unique_ids(attributes: Attributes, network: OpenDrive, nodes: list[Node]) -> None:
    seen: set[str] = set()
    for road, node in zip(network.roads, nodes, strict=True):
        if road.id in seen:
            text = "two roads have one id"
            attributes.report("asam.net:xodr:1.4.0:road.id_unique", node, text, attribute="id", found=road.id)
        seen.add(road.id)


def _plan(attributes: Attributes, road: Road, node: Node) -> tuple[Point, Point]:
    """Look for gaps between the geometries of a road; returns the poses of its two ends."""
    plan = node.find("planView")
    elements = {item.line: item for item in plan.children} if plan is not None else {}
    end: Point | None = None
    station = 0.0
    for geometry in road.geometries:
        if abs(geometry.s - station) > MAX_STATION_GAP:
            attributes.report(
                "asam.net:xodr:1.4.0:road.geometry.s",
                elements.get(geometry.line, node),
                "the geometry's s is not where the one before it ends",
                attribute="s",
                found=f"{geometry.s:g}",
                allowed=f"{station:g}",
            )
        station = geometry.s + geometry.length
        if end is not None:
            gap = math.hypot(geometry.x - end[0], geometry.y - end[1])
            if gap > MAX_GAP:
                attributes.report(
                    "road.geometry_gap",
                    elements.get(geometry.line, node),
                    "the geometry does not begin where the one before it ends",
                    found=f"a gap of {gap:.3g} m",
                    allowed=f"up to {MAX_GAP} m",
                    # between two roads as much is allowed
                    repair="a vehicle is put across the gap" if gap <= MAX_CONTACT_GAP else "",
                )
            kink = abs(math.remainder(geometry.hdg - end[2], 2.0 * math.pi))
            if kink > MAX_KINK:
                attributes.report(
                    "road.geometry_kink",
                    elements.get(geometry.line, node),
                    "the reference line should have no kinks: lanes jump there, and vehicles turn at once",
                    attribute="hdg",
                    found=f"a kink of {kink:.3g} rad",
                    allowed=f"up to {MAX_KINK} rad",
                    severity="warning",
                )
        end = row_end(geometry_rows(geometry)[-1])
    first, last = road.geometries[0], road.geometries[-1]
    if abs(last.s + last.length - road.length) > max(1.0, 0.01 * road.length):
        attributes.report(
            "asam.net:xodr:1.4.0:road.length",
            node,
            "the road is not as long as its geometries; the last one is continued or cut",
            attribute="length",
            found=node.get("length"),
            allowed=f"{last.s + last.length:g}",
            severity="warning",
        )
    return (first.x, first.y, first.hdg), end or (first.x, first.y, first.hdg)


def _lane_nodes(road_node: Node) -> Iterator[dict[int, Node]]:
    """Lane elements by id, section by section."""
    lanes = road_node.find("lanes")
    sections = [] if lanes is None else lanes.findall("laneSection")
    for section in sorted(sections, key=lambda item: float(item.get("s"))):
        yield {int(lane.get("id")): lane for side in section.children for lane in side.findall("lane")}


def _levels(attributes: Attributes, road: Road, node: Node) -> None:
    """Outside a level lane all lanes are level; a banked road has them banked all the same, with a warning."""
    if not any(lane.level for section in road.sections for lane in section.lanes):
        return
    banked = any(any((each.a, each.b, each.c, each.d)) for each in road.superelevations) or bool(road.shapes)
    for section, elements in zip(road.sections, _lane_nodes(node), strict=True):
        for side in (1, -1):
            level = False
            for lane in sorted((lane for lane in section.lanes if lane.id * side > 0), key=lambda item: abs(item.id)):
                if lane.level and banked:
                    attributes.report(
                        "road.unsupported",
                        elements[lane.id],
                        "a lane on level is not used: the lanes of this road lean as its superelevation and shape say",
                        attribute="level",
                        found="true",
                        severity="warning",
                    )
                    banked = False  # once a road
                if level and not lane.level:
                    attributes.report(
                        "asam.net:xodr:1.7.0:road.lane.level_true_one_side",
                        elements[lane.id],
                        "a lane outside of a level lane must be level too",
                        found=f"lane {lane.id}: level=false",
                        allowed="level=true",
                    )
                level = level or lane.level


def _section_links(attributes: Attributes, road: Road, node: Node) -> None:
    """A lane link between two sections is written on both sides."""
    if len(road.sections) < 2:
        return
    elements = list(_lane_nodes(node))
    for number, (before, after) in enumerate(zip(road.sections, road.sections[1:], strict=False)):
        ids_before = {lane.id: lane for lane in before.lanes}
        ids_after = {lane.id: lane for lane in after.lanes}
        for lane in before.lanes:
            claimed = [other.id for other in after.lanes if lane.id in other.predecessors and other.id]
            if lane.id and claimed and not lane.successors:
                _missing_link(attributes, elements[number][lane.id], "successor", claimed[0])
            _known_lanes(attributes, elements[number][lane.id] if lane.successors else None, lane.successors, ids_after)
        for lane in after.lanes:
            claimed = [other.id for other in before.lanes if lane.id in other.successors and other.id]
            if lane.id and claimed and not lane.predecessors:
                _missing_link(attributes, elements[number + 1][lane.id], "predecessor", claimed[0])
            there = elements[number + 1][lane.id] if lane.predecessors else None
            _known_lanes(attributes, there, lane.predecessors, ids_before)


def _missing_link(attributes: Attributes, node: Node, what: str, lane: int) -> None:
    attributes.report(
        "asam.net:xodr:1.4.0:road.lane.link.lanes_across_lane_sections",
        node,
        f"the lane has no {what}, but lane {lane} of the section there names it",
        allowed=f"{what} {lane}",
        repair="the link holds for both lanes",
    )


def _known_lanes(attributes: Attributes, node: Node | None, targets: tuple[int, ...], known: dict[int, Lane]) -> None:
    for target in targets:
        if node is not None and target not in known:
            attributes.report(
                "asam.net:xodr:1.4.0:road.lane.link.unknown",
                node,
                "the lane is linked to a lane that the section it leads to does not have",
                found=str(target),
                allowed=", ".join(str(lane) for lane in known),
                repair="the lane is not linked there",
            )


def _road_links(attributes: Attributes, network: OpenDrive, nodes: list[Node]) -> None:
    """A lane at the end of a road is linked to lanes that the road linked there has."""
    numbers = {road.id: number for number, road in enumerate(network.roads)}
    for road, node in zip(network.roads, nodes, strict=True):
        for at_end, link in ((False, road.predecessor), (True, road.successor)):
            if link is None or link.kind != "road" or link.s is not None or not link.contact:
                continue
            if link.id not in numbers or not answered(road, network.roads[numbers[link.id]], link):
                continue
            known = {lane.id: lane for lane in end_lanes(network.roads[numbers[link.id]], link.contact == "end")}
            for lane in end_lanes(road, at_end):
                targets = lane.successors if at_end else lane.predecessors
                if not known.keys() >= set(targets):
                    element = list(_lane_nodes(node))[-1 if at_end else 0].get(lane.id, node)
                    _known_lanes(attributes, element, targets, known)


def _contact_points(
    attributes: Attributes, network: OpenDrive, nodes: list[Node], ends: list[tuple[Point, Point]]
) -> None:
    """The reference lines of two linked roads meet, and where several roads begin at a road's end there is a junction.

    A link that the other road does not return and that does not meet it either joins nothing: that is only a warning.
    """
    numbers = {road.id: number for number, road in enumerate(network.roads)}
    done: set[tuple[int, int]] = set()
    claims: dict[tuple[int, bool], list[tuple[int, str]]] = {}
    for number, road in enumerate(network.roads):
        for name, link in (("predecessor", road.predecessor), ("successor", road.successor)):
            if link is None or link.kind != "road" or link.s is not None:
                continue
            other = numbers.get(link.id)
            if other is None or road.junction != "-1" or network.roads[other].junction != "-1" or not link.contact:
                continue
            at_end = link.contact == "end"
            here, there = ends[number][name == "successor"], ends[other][at_end]
            gap = math.hypot(here[0] - there[0], here[1] - there[1])
            if gap <= MAX_CONTACT_GAP:
                claims.setdefault((other, at_end), []).append((number, name))
                continue
            pair = (min(number, other), max(number, other))
            backs = network.roads[other].successor, network.roads[other].predecessor
            returned = any(back is not None and back.kind == "road" and back.id == road.id for back in backs)
            if pair not in done:
                done.add(pair)
                attributes.report(
                    "asam.net:xodr:1.7.0:road.geometry.contact_point",
                    nodes[number],
                    f"the road does not meet road {link.id}, which it is linked to, at the contact point",
                    found=f"a gap of {gap:.3g} m",
                    allowed=f"up to {MAX_CONTACT_GAP} m",
                    severity="error" if returned else "warning",
                )
    for (target, at_end), claimants in claims.items():
        if len({number for number, _ in claimants}) < 2:
            continue
        number, name = claimants[0]
        links = nodes[number].find("link")
        element = links.find(name) if links is not None else None
        end = "end" if at_end else "start"
        attributes.report(
            "asam.net:xodr:1.4.0:road.linkage.is_junction_needed",
            element or nodes[number],
            f"several roads meet the {end} of road {network.roads[target].id}: it needs a junction",
            found="roads " + ", ".join(network.roads[claimant].id for claimant, _ in claimants),
        )


def _appearing_lanes(attributes: Attributes, network: OpenDrive, nodes: list[Node]) -> None:
    """A lane that begins with no width is not linked to the lane it grows beside."""
    ends = ((number, at_end) for number in range(len(network.roads)) for at_end in (False, True))
    narrow = (
        _end_width(network, LaneEnd(number, lane.id, at_end)) < NO_WIDTH
        for number, at_end in ends
        for lane in end_lanes(network.roads[number], at_end)
        if lane.id
    )
    if not any(narrow):
        return  # as in most files, whose links need not be looked at for this
    for end, others in make_links(network.roads, ()).items():
        if len(others) < 2:
            continue
        road = network.roads[end.road]
        rule = 1 if road.rule == "RHT" else -1
        if (lane_direction(end.lane, rule) > 0) != end.at_end:
            continue  # traffic comes from there: lanes merge, none appears
        growing = [other for other in others if _end_width(network, other) < NO_WIDTH]
        if growing:
            lanes = list(_lane_nodes(nodes[end.road]))[-1 if end.at_end else 0]
            attributes.report(
                "asam.net:xodr:1.4.0:road.lane.link.new_lane_appear",
                lanes.get(end.lane, nodes[end.road]),
                "only the lane that continues is linked, not the one that appears beside it",
                found=", ".join(f"lane {other.lane} of road {network.roads[other.road].id}" for other in growing),
                repair="whoever follows the link starts on a lane without width",
            )


def _end_width(network: OpenDrive, end: LaneEnd) -> float:
    road = network.roads[end.road]
    lane = next(item for item in end_lanes(road, end.at_end) if item.id == end.lane)
    width = width_at(lane, road.length - road.sections[-1].s if end.at_end else 0.0)
    return math.inf if math.isnan(width) else width
