"""Links: which lane ends meet, over road links, junctions and their connecting roads.

A lane end is (road number, lane id, at_end): the end of the lane's last section at the road's end, or the beginning of
its first section at the road's start. Meeting is mutual; which way traffic may pass follows from the lanes' directions.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from openscenario.road.elements import Connection, Junction, Lane, Road, RoadLink


class LaneEnd(NamedTuple):
    """One end of a lane of a road."""

    road: int
    lane: int
    at_end: bool


def make_links(roads: Sequence[Road], junctions: Iterable[Junction]) -> dict[LaneEnd, tuple[LaneEnd, ...]]:
    """For each lane end the lane ends it meets, in file order."""
    numbers = {road.id: number for number, road in enumerate(roads)}
    by_id = {junction.id: junction for junction in junctions}
    found: dict[LaneEnd, dict[LaneEnd, None]] = {}
    known = [[{lane.id for lane in end_lanes(road, at_end)} - {0} for at_end in (False, True)] for road in roads]

    def join(a: LaneEnd, b: LaneEnd) -> None:
        if a.lane in known[a.road][a.at_end] and b.lane in known[b.road][b.at_end] and a != b:
            found.setdefault(a, {})[b] = None
            found.setdefault(b, {})[a] = None

    for number, road in enumerate(roads):
        for at_end, link in ((False, road.predecessor), (True, road.successor)):
            if link is None or link.id not in numbers or link.kind != "road" or link.s is not None:
                continue
            if not answered(road, roads[numbers[link.id]], link):
                continue
            for a, b in _road_link(roads, number, at_end, numbers[link.id], link):
                join(a, b)
    for junction in by_id.values():
        if junction.type == "virtual":
            continue  # its ways meet no end of the main road: see `branches.py`
        for connection in junction.connections:
            for a, b in _connection(roads, numbers, junction, connection):
                join(a, b)
    return {end: tuple(others) for end, others in found.items()}


def answered(road: Road, other: Road, link: RoadLink) -> bool:
    """Whether the other road's own link there agrees, or it has none; a connecting road is named by its junction."""
    back = other.successor if link.contact == "end" else other.predecessor
    if back is None or not link.contact:
        return True
    return back.id == (road.id if back.kind == "road" else road.junction)


def end_lanes(road: Road, at_end: bool) -> tuple[Lane, ...]:
    """Lanes at one end of a road, leftmost first."""
    if not road.sections:
        return ()
    return road.sections[-1 if at_end else 0].lanes


def _road_link(
    roads: Sequence[Road], number: int, at_end: bool, other: int, link: RoadLink
) -> Iterable[tuple[LaneEnd, LaneEnd]]:
    """Pairs of lane ends that a link between two roads joins."""
    there = link.contact == "end" if link.contact else not at_end
    lanes = [lane for lane in end_lanes(roads[number], at_end) if lane.id]
    back = [lane for lane in end_lanes(roads[other], there) if lane.id]
    silent = not any(lane.successors if at_end else lane.predecessors for lane in lanes) and not any(
        lane.successors if there else lane.predecessors for lane in back
    )
    for lane in lanes:
        targets = lane.successors if at_end else lane.predecessors
        if silent:  # no lane link on either side: sides keep their ids, swapped where the roads run against each other
            targets = (-lane.id if at_end == there else lane.id,)
        for target in targets:
            yield LaneEnd(number, lane.id, at_end), LaneEnd(other, target, there)


def _connection(
    roads: Sequence[Road], numbers: Mapping[str, int], junction: Junction, connection: Connection
) -> Iterable[tuple[LaneEnd, LaneEnd]]:
    """Pairs of lane ends that a junction's connection joins."""
    incoming, connecting = numbers.get(connection.incoming), numbers.get(connection.connecting)
    if incoming is None or connecting is None:
        return
    there = connection.contact == "end"
    at_end = _end_at_junction(roads, incoming, connecting, there, junction.id)
    links = connection.lane_links
    if not links:  # the standard allows a connection without lane links: lanes keep their ids
        sign = -1 if at_end == there else 1
        links = tuple((lane.id, sign * lane.id) for lane in end_lanes(roads[incoming], at_end) if lane.id)
    for source, target in links:
        yield LaneEnd(incoming, source, at_end), LaneEnd(connecting, target, there)


def _end_at_junction(roads: Sequence[Road], incoming: int, connecting: int, there: bool, junction: str) -> bool:
    """Which end of the incoming road lies at the junction: as the connecting road says, else as its own link does."""
    back = roads[connecting].successor if there else roads[connecting].predecessor
    if back is not None and back.kind == "road" and back.id == roads[incoming].id and back.contact:
        return back.contact == "end"
    before = roads[incoming].predecessor
    return not (before is not None and before.kind == "junction" and before.id == junction)
