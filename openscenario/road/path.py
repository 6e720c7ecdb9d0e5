"""Path: moving along lanes, and the line that a lane's middle or a route draws in the plane."""

from __future__ import annotations

import math

from machine_code import compiled
from openscenario.road.lanes import lane_centre, lane_row, nearest_lane, section_at
from openscenario.road.pose import reference
from openscenario.road.profile import Floats
from openscenario.road.tables import (
    LANE_DRIVABLE,
    LANE_ID,
    LANE_PREDECESSOR,
    LANE_SUCCESSOR,
    ROAD_SECTION,
    ROAD_SECTION_END,
    Tables,
)

STEP = 2.0  # m, longest step of the integration along a lane
ROUNDING = 1e-12  # m, a way shorter than that is done
NO_WIDTH = 1e-6  # m


@compiled
def stretch(kappa: float, t: float) -> float:
    """Metres travelled at t [m] for each metre of the reference line; where a lane shifts sideways that is no way."""
    return max(1.0 - kappa * t, 0.05)


@compiled
def crossed(tables: Tables, section: int, lane: int, forward: bool, road: int, s: float, offset: float) -> int:
    """Lane id in the neighbouring section that a lane continues as; where it ends, the nearest of its side.

    A lane to drive on that is linked to one that is not, a hard shoulder, ends there.
    """
    lanes, spans = tables[6], tables[4]
    row = lane_row(tables, section, lane)
    if lane == 0 or row < 0:
        return 0
    target = lanes[row, LANE_SUCCESSOR] if forward else lanes[row, LANE_PREDECESSOR]
    if target >= 0 and lanes[target, LANE_DRIVABLE] >= lanes[row, LANE_DRIVABLE]:
        return int(lanes[target, LANE_ID])
    t = lane_centre(tables, road, section, lane, s)[0] + offset
    beyond = spans[section + 1, 0] + 1e-6 if forward else spans[section - 1, 1] - 1e-6
    found = beside(tables, road, beyond, t, lanes[row, LANE_DRIVABLE] == 1, lane)[0]
    if target >= 0 and found * lane <= 0:  # nothing to drive on goes this way
        return int(lanes[target, LANE_ID])
    return found


@compiled
def beside(tables: Tables, road: int, s: float, t: float, drivable: bool, lane: int) -> tuple[int, float]:
    """Lane nearest to (s, t), if it can be of the side of `lane`, which goes its way; and t [m] of its middle."""
    same, middle, width, _ = nearest_lane(tables, road, s, t, drivable, 1 if lane > 0 else -1)
    if same != 0 and width >= NO_WIDTH:
        return same, middle
    return nearest_lane(tables, road, s, t, drivable, 0)[:2]


@compiled
def advance(
    tables: Tables, road: int, lane: int, s: float, offset: float, distance: float
) -> tuple[int, float, float, float, float]:
    """Move `distance` [m] along a lane at a constant offset from its middle; > 0 with increasing s.

    The way counts along the road's s axis at that t, as the field's tools count it: a lane that shifts sideways (its
    width or the lane offset changes) takes one along, it makes no way. Where a lane shrinks to nothing one goes on in
    the middle of the lane beside it, rather one that goes the same way.

    Returns lane, s, t, road heading, and the distance [m, same sign] left at the road's end.
    """
    spans, roads = tables[4], tables[3]
    section = section_at(tables, road, s)
    forward = distance >= 0.0
    if not forward and s <= spans[section, 0] and section > roads[road, ROAD_SECTION]:
        lane = crossed(tables, section, lane, forward, road, s, offset)
        section -= 1
    sign = 1.0 if forward else -1.0
    left = abs(distance)
    wide = lane_centre(tables, road, section, lane, s)[3]
    while left > ROUNDING:
        border = spans[section, 1] if forward else spans[section, 0]
        room = sign * (border - s)
        t = lane_centre(tables, road, section, lane, s)[0]
        rate = stretch(reference(tables, road, s)[3], t + offset)
        probe = min(left / rate, room, STEP)
        middle = s + 0.5 * sign * probe
        t = lane_centre(tables, road, section, lane, middle)[0]
        rate = stretch(reference(tables, road, middle)[3], t + offset)
        ds = min(left / rate, room, STEP)
        s += sign * ds
        left -= ds * rate
        if sign * (border - s) <= 1e-12:
            s = border
            following = section + (1 if forward else -1)
            if following < roads[road, ROAD_SECTION] or following >= roads[road, ROAD_SECTION_END]:
                break
            lane = crossed(tables, section, lane, forward, road, s, offset)
            section = following
    t, _, _, width = lane_centre(tables, road, section, lane, s)
    if width < NO_WIDTH <= wide:
        drivable = tables[6][lane_row(tables, section, lane), LANE_DRIVABLE] == 1
        lane, t = beside(tables, road, s, t, drivable, lane)
    return lane, s, t + offset, reference(tables, road, s)[2], sign * left if left > ROUNDING else 0.0


@compiled
def lateral(
    tables: Tables, road: int, from_lane: int, to_lane: int, s: float, first: float, last: float
) -> tuple[float, float, float]:
    """t [m] with two derivatives of a line that changes smoothly from one lane's middle to another's between two s."""
    section = section_at(tables, road, s)
    t, t1, t2, _ = lane_centre(tables, road, section, from_lane, s)
    if from_lane == to_lane:
        return t, t1, t2
    v, v1, v2, _ = lane_centre(tables, road, section, to_lane, s)
    span = last - first
    u = min(max((s - first) / span, 0.0), 1.0)
    # quintic step: curvature stays continuous at both ends
    w = u * u * u * (10.0 - 15.0 * u + 6.0 * u * u)
    w1 = 30.0 * u * u * (1.0 - u) * (1.0 - u) / span
    w2 = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / (span * span)
    d, d1, d2 = v - t, v1 - t1, v2 - t2
    return t + w * d, t1 + w * d1 + w1 * d, t2 + w * d2 + 2.0 * w1 * d1 + w2 * d


@compiled
def line_point(
    tables: Tables, road: int, from_lane: int, to_lane: int, s: float, first: float, last: float, sign: float
) -> tuple[float, float, float, float, float]:
    """x, y [m], heading [rad], curvature [1/m] in driving direction, and metres travelled for each metre of s."""
    x, y, heading, kappa, rate = reference(tables, road, s)
    t, t1, t2 = lateral(tables, road, from_lane, to_lane, s, first, last)
    forward = max(1.0 - kappa * t, 0.05)
    speed2 = forward * forward + t1 * t1
    # r' = forward T + t1 N, r'' = -(rate t + 2 kappa t1) T + (kappa forward + t2) N
    bend = forward * (kappa * forward + t2) + t1 * (rate * t + 2.0 * kappa * t1)
    angle = heading + math.atan2(t1, forward) + (0.0 if sign > 0.0 else math.pi)
    x -= math.sin(heading) * t
    y += math.cos(heading) * t
    return x, y, angle, sign * bend / (speed2 * math.sqrt(speed2)), math.sqrt(speed2)


@compiled
def trace(
    tables: Tables,
    road: int,
    from_lane: int,
    to_lane: int,
    s_from: float,
    s_to: float,
    first: float,
    last: float,
    step: float,
    carry: float,
    out: Floats,
    count: int,
) -> tuple[int, float]:
    """Sample one piece of a line into out[count:], each `step` [m] of travel.

    The lane changes from `from_lane` to `to_lane` between s = first and s = last. `carry` [m] is the way to the first
    sample. Returns the new count (beyond out's length: too short) and the way left to the next sample. Where a lane
    ends before the piece does, the line ends.
    """
    sign = 1.0 if s_to >= s_from else -1.0
    s = s_from
    while True:
        room = sign * (s_to - s)
        rate = line_point(tables, road, from_lane, to_lane, s, first, last, sign)[4]
        probe = min(carry / rate, room)
        rate = line_point(tables, road, from_lane, to_lane, s + 0.5 * sign * probe, first, last, sign)[4]
        if not rate > 0.0:  # there is no such lane here: never NaN, which would never end
            return count, carry
        if carry > room * rate:
            return count, carry - room * rate
        s += sign * carry / rate
        point = line_point(tables, road, from_lane, to_lane, s, first, last, sign)
        if count < out.shape[0]:
            for column in range(4):
                out[count, column] = point[column]
        count += 1
        carry = step
