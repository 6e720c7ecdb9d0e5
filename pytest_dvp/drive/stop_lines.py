"""Stop lines of the map's traffic lights, as the log tells them to whoever judges a drive."""

from __future__ import annotations

import math
from typing import Any

from openscenario.road.elements import Signal
from openscenario.road.network import RoadNetwork

ALL_LANES = ((-math.inf, math.inf),)


def stop_lines(network: RoadNetwork) -> list[dict[str, Any]]:
    """Of each dynamic signal of the map: its id, and the line across the lanes that it is for.

    x, y [m] of the line's middle, heading [rad] of the traffic over it, width [m]. The line is where the signal, or a
    reference to it, stands (s of the OpenDRIVE file), over the drivable lanes of its orientation, each range of its
    validity with a line of its own; a signal without such lanes has none.
    """
    found = []
    for signal in network.signals:
        if not signal.dynamic:
            continue
        for sign in (1, -1):
            if (signal.orientation, sign) in (("+", -1), ("-", 1)):
                continue
            for low, high in signal.validity or ALL_LANES:
                edges = _edges(network, signal, sign, low, high)
                if edges:
                    pose = network.road_pose(signal.road, signal.s, 0.5 * (min(edges) + max(edges)))
                    heading = pose.h if sign > 0 else pose.h + math.pi
                    width = max(edges) - min(edges)
                    found.append(
                        {"signal": signal.id, "x": pose.x, "y": pose.y, "heading": heading, "width": width},
                    )
    return found


def _edges(network: RoadNetwork, signal: Signal, sign: int, low: float, high: float) -> list[float]:
    """t [m] of the edges of the drivable lanes with ids from low to high whose traffic runs as `sign` says."""
    road, s = signal.road, signal.s
    edges = []
    for lane in network.section(road, s).lanes:
        width = network.lane_width(road, lane.id, s)
        if (
            lane.id
            and low <= lane.id <= high
            and lane.drivable
            and width
            and network.driving_sign(road, lane.id, s) == sign
        ):
            middle = network.lane_t(road, lane.id, s)
            edges += [middle - 0.5 * width, middle + 0.5 * width]
    return edges
