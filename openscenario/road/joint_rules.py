"""Joint rules: lanes that are linked meet, in junctions as well, and neither a road's height nor its lanes jump.

All are warnings: a vehicle is put across the gap, aside, or lifted, in one step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from openscenario.road.attributes import Attributes
from openscenario.road.elements import Cubic, LaneSection, OpenDrive, Road
from openscenario.road.junction_rules import NO_JUNCTION
from openscenario.road.lane_rules import outer_border, value_at
from openscenario.road.links import LaneEnd, make_links
from openscenario.xml import Node

_SAME = 1e-6  # m between stations that are one; rounding
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
        _steps_aside(attributes, road, node)
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


def _steps_aside(attributes: Attributes, road: Road, node: Node) -> None:
    """Where another lane section or another offset begins, lanes go on where they were.

    An offset may jump if the lanes are numbered anew or have other widths there: then a border at least stays.
    """
    starts = {section.s for section in road.sections[1:]} | {each.s for each in road.lane_offsets}
    for s in sorted(each for each in starts if 0.0 < each < road.length):
        before = [each for each in road.sections if each.s < s - _SAME] or list(road.sections[:1])
        after = [each for each in road.sections if each.s <= s + _SAME] or list(road.sections[:1])
        offsets = [each for each in road.lane_offsets if each.s < s - _SAME]
        old, new = _borders(before[-1], offsets, s), _borders(after[-1], road.lane_offsets, s)
        for lane in after[-1].lanes:
            came = lane.predecessors if before[-1] is not after[-1] else (lane.id,)
            for number in came:
                if not lane.drivable or lane.id not in new or number not in old:
                    continue
                inner, outer = (b - a for a, b in zip(old[number], new[lane.id], strict=True))
                if inner * outer > 0.0 and min(abs(inner), abs(outer)) > MOST:
                    attributes.report(
                        "road.lane_step",
                        node.find("lanes") or node,
                        f"lane {lane.id} lies elsewhere than the lane before it, from s = {s:g} m on",
                        found=f"a step of {min(abs(inner), abs(outer)):.3g} m aside",
                        allowed=f"up to {MOST} m",
                        severity="warning",
                    )


def _borders(section: LaneSection, offsets: Sequence[Cubic], s: float) -> dict[int, tuple[float, float]]:
    """t [m] of the inner and outer border of each lane of a section at s [m] of its road."""
    found = {}
    for side in (1, -1):
        inner = _at(offsets, s)
        for lane in sorted((each for each in section.lanes if each.id * side > 0), key=lambda each: abs(each.id)):
            outer = outer_border(lane, side, s - section.s, inner)
            found[lane.id] = inner, outer
            inner = outer
    return found


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
