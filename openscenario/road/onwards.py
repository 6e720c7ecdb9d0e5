"""Onwards: the lane of another place that a lane runs on as, over the sections, links and junctions between."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from heapq import heappop, heappush

from openscenario.road import lanes as kernels
from openscenario.road import path
from openscenario.road.links import LaneEnd
from openscenario.road.tables import Tables

Ends = Callable[[int, int, bool], Iterable[LaneEnd]]
"""Road number, lane, whether at the road's end -> the lane ends that the lane meets there."""


def lane_along(tables: Tables, road: int, lane: int, s: float, to: float) -> int:
    """The lane that a lane at s [m] of a road runs on as at another s; one that ends, as the nearest of its side."""
    section, last = kernels.section_at(tables, road, s), kernels.section_at(tables, road, to)
    while section != last:
        forward = section < last
        border = tables[4][section, 1 if forward else 0]
        lane = path.crossed(tables, section, lane, forward, road, border, 0.0)
        section += 1 if forward else -1
    return int(lane)


def lane_onwards(
    tables: Tables, ends: Ends, start: tuple[int, int, float], goal: tuple[int, float], most: float
) -> int | None:
    """The lane at the goal (road number, s [m]) that the start's (road number, lane, s [m]) runs on as.

    Whichever way the traffic runs; along the shortest way over lanes that meet, of at most `most` [m]. None without it.
    """
    (road, lane, s), (last, goal_s) = start, goal
    if road == last:
        return lane_along(tables, road, lane, s, goal_s)
    lengths = tables[2]
    reached: set[LaneEnd] = set()
    found: list[tuple[float, bool, LaneEnd]] = []  # way, whether it is the goal, the lane's end; a heap
    for at_end in (True, False):
        to = float(lengths[road]) if at_end else 0.0
        heappush(found, (abs(to - s), False, LaneEnd(road, lane_along(tables, road, lane, s, to), at_end)))
    while found:
        way, there, here = heappop(found)
        if way > most:
            return None
        if there:
            return here.lane
        if here in reached:
            continue
        reached.add(here)
        for end in ends(*here):
            heappush(found, (way, False, end))  # ways that begin at the same place meet there
            length = float(lengths[end.road])
            first = length if end.at_end else 0.0
            to = goal_s if end.road == last else length - first
            beyond = lane_along(tables, end.road, end.lane, first, to)
            heappush(found, (way + abs(to - first), end.road == last, LaneEnd(end.road, beyond, not end.at_end)))
    return None
