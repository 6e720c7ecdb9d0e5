"""Joint rules: lanes that are linked meet, in junctions as well, and the height of a road does not jump.

Both are warnings: a vehicle is put across the gap, or lifted, in one step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from openscenario.road.attributes import Attributes
from openscenario.road.elements import Cubic, OpenDrive, Road
from openscenario.road.junction_rules import NO_JUNCTION
from openscenario.road.lane_rules import outer_border, value_at
from openscenario.road.links import LaneEnd, make_links
from openscenario.xml import Node

MOST = 0.5  # m; as much is allowed between the reference lines of two linked roads

Point = tuple[float, float, float]  # x, y [m], heading [rad]


class Middle(NamedTuple):
    """Middle of a lane at an end of its road [m], the lane's width [m], heading of the road [rad]."""

    x: float
    y: float
    z: float
    width: float
    heading: float


def check_joints(
    attributes: Attributes, network: OpenDrive, nodes: Sequence[Node], ends: Sequence[tuple[Point, Point]]
) -> None:
    """Add a warning for each joint that does not meet; `ends` are the poses of both ends of each road."""
    for road, node in zip(network.roads, nodes, strict=True):
        _heights(attributes, road, node)
    middles: dict[LaneEnd, Middle] = {}
    found: set[tuple[int, bool, int, bool]] = set()
    for a, others in make_links(network.roads, network.junctions).items():
        for b in others:
            joint = (a.road, a.at_end, b.road, b.at_end)
            if b < a or joint in found:
                continue
            for each in (a, b):
                if each not in middles:
                    middles[each] = _middle(network.roads[each.road], ends[each.road][each.at_end], each)
            inside = network.roads[a.road].junction not in NO_JUNCTION
            beside, above = _apart(middles[a], middles[b])
            if not inside and network.roads[b.road].junction in NO_JUNCTION:
                beside = 0.0  # the rule of contact points looks at two roads outside of junctions
            if max(beside, above) > MOST:
                found.add(joint)
                _report(attributes, network, nodes, (a, b) if inside else (b, a), max(beside, above))


def _report(
    attributes: Attributes, network: OpenDrive, nodes: Sequence[Node], joint: tuple[LaneEnd, LaneEnd], apart: float
) -> None:
    here, there = joint
    links = nodes[here.road].find("link")
    element = None if links is None else links.find("successor" if here.at_end else "predecessor")
    attributes.report(
        "road.joint_gap",
        element or nodes[here.road],
        f"lane {here.lane} is linked to lane {there.lane} of road {network.roads[there.road].id}, but does not meet it",
        found=f"a gap of {apart:.3g} m",
        allowed=f"up to {MOST} m",
        severity="warning",
    )


def _heights(attributes: Attributes, road: Road, node: Node) -> None:
    profile = node.find("elevationProfile")
    # before its first record a road lies at 0; of two records at one place, the last one holds
    records = {max(each.s, 0.0): each for each in (Cubic(0.0, 0.0, 0.0, 0.0, 0.0), *road.elevations)}
    for before, record in pairwise(records.values()):
        if record.s >= road.length:
            break
        step = record.a - value_at((before,), record.s)
        if abs(step) > MOST:
            attributes.report(
                "road.height_step",
                profile or node,
                f"the height of the road jumps at s = {record.s:g} m",
                found=f"a step of {step:.3g} m",
                allowed=f"up to {MOST} m",
                severity="warning",
            )


def _apart(a: Middle, b: Middle) -> tuple[float, float]:
    """How far [m] two lanes lie apart where they should meet: in the plane, along or beside each other; in height."""
    c, sn = math.cos(a.heading), math.sin(a.heading)
    along = abs((b.x - a.x) * c + (b.y - a.y) * sn)
    across = abs((b.y - a.y) * c - (b.x - a.x) * sn)
    return max(along, across - 0.5 * (a.width + b.width)), abs(b.z - a.z)


def _middle(road: Road, end: Point, lane: LaneEnd) -> Middle:
    s = road.length if lane.at_end else 0.0
    section = road.sections[-1 if lane.at_end else 0]
    side = 1 if lane.lane > 0 else -1
    inner = outer = _at(road.lane_offsets, s)
    for each in sorted(section.lanes, key=lambda item: abs(item.id)):
        if 0 < each.id * side <= abs(lane.lane):
            inner, outer = outer, outer_border(each, side, s - section.s, outer)
    t = 0.5 * (inner + outer)
    x, y, heading = end
    roll = _at(road.superelevations, s)
    z = _at(road.elevations, s) + t * math.sin(roll)
    t *= math.cos(roll)
    return Middle(x - t * math.sin(heading), y + t * math.cos(heading), z, abs(outer - inner), heading)


def _at(records: Sequence[Cubic], s: float) -> float:
    value = value_at(records, s)
    return 0.0 if math.isnan(value) else value
