"""Right of way: which ways through a junction cross ours, and which of them go first.

Goes first: who comes along a road without a sign where ours has a yield or stop sign; and, without signs between the
two, who comes towards us when we turn across his side. Right before left at unsigned junctions is not known here.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ads.control.spline import YAW, S, X, Y
from ads.map_monitor import LaneSpan, faces
from ads.planning.route import Leg, Map
from ads.transforms import wrap_angle
from vehicle.messages import FloatArray

STEP = 0.5  # m between points of a way
APPROACH = 60.0  # m of the road that a way comes along
BEFORE = 30.0  # m before a junction in which a sign is the junction's
TOUCH = 2.3  # m between lines on which two cars touch: their widths and a little more
TURN = 0.25 * math.pi  # rad; less is straight on
ACROSS = math.radians(60.0)  # how far from opposite a road may lie that traffic comes towards us from
SIGNS = {  # (country, type) as OpenDRIVE has them: Vienna convention B1 and B2 in national numbers
    ("", "205"): "yield",
    ("", "206"): "stop",
    ("DE", "205"): "yield",
    ("DE", "206"): "stop",
    ("ES", "R1"): "yield",
    ("ES", "R2"): "stop",
    ("US", "R1-2"): "yield",
    ("US", "R1-1"): "stop",
}


class Way(NamedTuple):
    """Another way through the junction: points x, y [m], heading [rad], arc length [m] (n, 4) in driving direction.

    `first` and `last` [m]: where along it a car on it touches one on ours.
    """

    line: FloatArray
    first: float
    last: float


class Priority(NamedTuple):
    """A junction of the route at which somebody goes first; places in arc length of the path [m].

    `line`: where the junction begins; `first` and `last`: the part of the path that the other ways touch.
    `sign`: "yield", "stop" or "" where only those who come towards us go first.
    """

    line: float
    first: float
    last: float
    sign: str
    ways: tuple[Way, ...]


def sign_of(network: Map, road: str, lane: int, at_end: bool) -> str:
    """The sign that a road's lane has where it enters a junction: "yield", "stop" or ""."""
    length = float(network.roads[road].length)
    for signal in network.signals:
        if str(signal.road) != road or (length - signal.s if at_end else signal.s) > BEFORE:
            continue
        if not faces(network, signal, road, lane, length if at_end else 0.0):
            continue
        kind = str(getattr(signal, "type", "")).upper()
        country = str(getattr(signal, "country", "")).upper()
        found = SIGNS.get((country, kind)) or SIGNS.get((country[:2], kind)) or SIGNS.get(("", kind))
        if found:
            return found
    return ""


def priority_of(network: Map, before: LaneSpan, span: LaneSpan, path: FloatArray, side: float) -> Priority | None:
    """Who goes first on the junction leg `span`, which the route enters from `before`; None if nobody does.

    `path` (n, COLUMNS) of a spline, SI units; `side`: +1 for right-hand traffic, -1 for left-hand.
    """
    junctions = getattr(network, "junctions", {})
    junction = junctions.get(str(network.roads[span.leg.road].junction))
    if junction is None:
        return None
    own = path[(path[:, S] >= span.s_from) & (path[:, S] <= span.s_to)]
    if len(own) < 2:
        return None
    entry = float(own[0, YAW])
    turns_across = side * wrap_angle(float(own[-1, YAW]) - entry) > TURN
    sign = sign_of(network, before.leg.road, before.leg.lane, before.leg.s_to > before.leg.s_from)
    ways, first, last = [], math.inf, -math.inf
    for connection in junction.connections:
        if connection.connecting == span.leg.road or connection.incoming == before.leg.road:
            continue
        for come, go in connection.lane_links:
            line = _line(network, connection, come, go)
            if line is None:
                continue
            theirs = sign_of(network, connection.incoming, come, _ends_here(network, connection.incoming, come))
            if sign and not theirs:
                goes_first = True
            elif theirs and not sign:
                goes_first = False
            else:
                opposite = abs(wrap_angle(_heading_at_entry(network, connection, come) - entry - math.pi)) < ACROSS
                turned = side * wrap_angle(float(line[-1, 2]) - _heading_at_entry(network, connection, come))
                goes_first = turns_across and opposite and turned < TURN
            if not goes_first:
                continue
            gaps = np.hypot(own[:, X, None] - line[None, :, 0], own[:, Y, None] - line[None, :, 1]) < TOUCH
            if not gaps.any():
                continue
            ours, other = np.flatnonzero(gaps.any(axis=1)), np.flatnonzero(gaps.any(axis=0))
            ways.append(Way(line, float(line[other[0], 3]), float(line[other[-1], 3])))
            first, last = min(first, float(own[ours[0], S])), max(last, float(own[ours[-1], S]))
    return Priority(span.s_from, first, last, sign, tuple(ways)) if ways else None


def _ends_here(network: Map, road: str, lane: int) -> bool:
    """Whether traffic on a lane drives towards the road's end."""
    return network.driving_sign(road, lane, 0.0) > 0


def _heading_at_entry(network: Map, connection: Any, come: int) -> float:
    road = connection.incoming
    forward = _ends_here(network, road, come)
    heading = float(network.lane_pose(road, come, float(network.roads[road].length) if forward else 0.0).h)
    return heading if forward else heading + math.pi


def _line(network: Map, connection: Any, come: int, go: int) -> FloatArray | None:
    """Line (n, 4) of the last APPROACH metres of a road and the way it leads onto; None if it is none for cars."""
    road, way = connection.incoming, connection.connecting
    if connection.contact not in ("start", "end") or "driving" not in (
        network.lane_type(way, go, 0.0),
        network.lane_type(road, come, 0.0),
    ):
        return None
    length, beyond = float(network.roads[road].length), float(network.roads[way].length)
    forward = _ends_here(network, road, come)
    reach = min(length, APPROACH)
    legs = (
        Leg(road, come, length - reach if forward else reach, length if forward else 0.0),
        Leg(way, go, *((0.0, beyond) if connection.contact == "start" else (beyond, 0.0))),
    )
    points = network.centreline(legs, STEP)
    if len(points) < 2:
        return None
    along = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(points[:, 0]), np.diff(points[:, 1])))))
    return np.column_stack((points[:, :3], along))
